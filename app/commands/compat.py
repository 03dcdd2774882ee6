"""Skip parts of Numba's start that the command line does not need; they take most of the time of a short run.

The parts use private or undocumented names of Numba and do nothing where a version has others
(`tests/app/test_start_of_commands.py`). With them ``vibroscope simulate`` takes a fifth less processor time.
"""

import contextlib
import functools
import sys
from importlib import import_module
from pathlib import Path


@functools.cache
def shorten_start() -> None:
    """Leave out what no kernel uses. To be called before the engine is imported."""
    for leave_out in (leave_out_imports, leave_out_repeated_checks, leave_out_compiler, leave_out_bitcode):
        with contextlib.suppress(ImportError, AttributeError):
            leave_out()


def leave_out_imports() -> None:
    """Import Numba without SciPy and YAML, which stay usable.

    Numba checks the version of SciPy, and looks for its BLAS when the undocumented module below is imported. It reads
    a file of settings by YAML, if there is one.
    """
    names = ["scipy"] if Path(".numba_config.yaml").exists() else ["scipy", "yaml"]
    hidden = [name for name in names if name not in sys.modules]
    sys.modules.update(dict.fromkeys(hidden))  # whose import then fails, as where they are not installed
    try:
        import_module("numba.np.arraymath")
    finally:
        for name in hidden:
            del sys.modules[name]


def leave_out_repeated_checks() -> None:
    """Check once for each cache folder, and not for each of 170 kernels, that it can be written."""
    locator, checked = import_module("numba.core.caching")._CacheLocator, set()
    check = locator.ensure_cache_path

    def check_once(self) -> None:
        if (path := self.get_cache_path()) not in checked:
            check(self)
            checked.add(path)

    locator.ensure_cache_path = check_once


def leave_out_compiler() -> None:
    """Load machine code without the tables of all that Numba can compile.

    A compilation sets them up itself, when it begins. Machine code needs the functions that count references alone.
    """
    cache = import_module("numba.core.caching").FunctionCache
    runtime = import_module("numba.core.runtime").rtsys
    load = cache._load_overload

    def load_overload(self, sig, target_context):
        runtime.initialize(target_context)
        return load(self, sig, target_context)

    cache.load_overload = load_overload


def leave_out_bitcode() -> None:
    """Load machine code without the bitcode beside it, from which other functions would be compiled.

    A compilation that needs the bitcode parses it then.
    """
    binding, codegen = import_module("llvmlite.binding"), import_module("numba.core.codegen")
    library, empty = codegen.JITCodeLibrary, binding.parse_assembly("").as_bitcode()
    load, find_address, parse = library._unserialize, library.get_pointer_to_function, library._get_module_for_linking

    def load_machine_code(cls, target, state):
        name, kind, data = state
        if kind != "object":
            return load.__func__(cls, target, state)
        loaded = load.__func__(cls, target, (name, kind, (data[0], empty)))
        loaded._shared_module, loaded.unparsed = None, data[1]
        return loaded

    def address_of(self, name):
        if hasattr(self, "unparsed"):  # then the names in it are not known, which this function would look up
            return self._codegen._engine.get_function_address(name)
        return find_address(self, name)

    def parse_late(self):
        if hasattr(self, "unparsed"):
            self._shared_module = binding.parse_bitcode(self.unparsed)
            self._codegen._engine._load_defined_symbols(self._shared_module)
            del self.unparsed
        return parse(self)

    library._unserialize = classmethod(load_machine_code)
    library.get_pointer_to_function, library._get_module_for_linking = address_of, parse_late
