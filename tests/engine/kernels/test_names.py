"""No two kernels have machine code of one name: a process that loads both would take one for the other."""

import importlib
import pkgutil
from collections import defaultdict

from numba.core.dispatcher import Dispatcher
from vibroscope.engine import kernels


def compiled_functions():
    """Every function that Numba compiles to machine code of its own, those within others included."""
    modules = [
        importlib.import_module(each.name)
        for each in pkgutil.walk_packages(kernels.__path__, "vibroscope.engine.kernels.")
    ]
    left = [value for module in modules for value in vars(module).values()]
    found = {}
    while left:
        value = left.pop()
        if isinstance(value, Dispatcher) and id(value) not in found and value.targetoptions.get("inline") != "always":
            found[id(value)] = value.py_func
            left += [cell.cell_contents for cell in value.py_func.__closure__ or ()]
    return found.values()


def test_each_name_is_of_one_function():
    named = defaultdict(set)
    for function in compiled_functions():
        named[function.__module__, function.__qualname__].add(function)
    assert len(named) > 200
    assert [name for name, functions in named.items() if len(functions) > 1] == []
