"""Private names of the libraries are used in modules called ``compat`` and in ``page/shared/compat.js`` alone."""

import ast
import functools
import importlib
import inspect
import pkgutil
import re
import textwrap
from pathlib import Path

import pytest
from vibroscope import app

ROOT = Path(__file__).parents[2]
LIBRARIES = ("panel", "bokeh", "tornado", "param", "holoviews")
# Panel documents these for components; the standard library documents the others.
DOCUMENTED = {"_esm", "_stylesheets", "_send_msg", "_replace", "_asdict", "_fields", "_exit"}


def sources(pattern):
    return [path for path in (ROOT / "app").rglob(pattern) if path.stem != "compat"]


def is_private(name):
    return name.startswith("_") and not name.startswith("__") and name not in DOCUMENTED


@pytest.mark.parametrize("path", sources("*.py"), ids=lambda path: str(path.relative_to(ROOT)))
def test_no_private_name_of_another_object_or_library_is_used(path):
    nodes = [*ast.walk(ast.parse(path.read_text(encoding="utf-8")))]
    found = [
        node
        for node in nodes
        if isinstance(node, ast.Attribute)
        and is_private(node.attr)
        and not (isinstance(node.value, ast.Name) and node.value.id in ("self", "cls"))
        and ast.unparse(node.value) != "super()"
    ]
    found += [
        node
        for node in nodes
        if isinstance(node, ast.ImportFrom) and (node.module or "").partition(".")[0] in LIBRARIES
        if any(map(is_private, (*node.module.split("."), *(each.name for each in node.names))))
    ]
    lines = [f"line {node.lineno}: {ast.unparse(node)}" for node in found]
    assert not lines, f"move it to a module compat.py: {lines}"


def classes_above_library_classes():
    """Every class of the app with its base classes from the libraries."""
    for info in pkgutil.walk_packages(app.__path__, f"{app.__name__}."):
        module = importlib.import_module(info.name)
        for value in vars(module).values():
            if inspect.isclass(value) and value.__module__ == info.name != f"{app.__name__}.compat":
                bases = [base for base in value.__mro__ if base.__module__.split(".")[0] in LIBRARIES]
                if bases:
                    yield value, bases


def own_names(cls):
    """Private names that the body of a class uses on ``self`` or defines."""
    found = set()
    for node in ast.walk(ast.parse(textwrap.dedent(inspect.getsource(cls)))):
        if isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name) and node.value.id == "self":
            found.add(node.attr)
        elif isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef):
            found.add(node.name)
        elif isinstance(node, ast.Assign | ast.AnnAssign):
            found.update(name.id for name in ast.walk(node) if isinstance(name, ast.Name))
    return set(filter(is_private, found))


@functools.cache
def names_of_library(base):
    """Private names of a class of a library: what it defines, and what its methods set on ``self``."""
    try:
        text = inspect.getsource(base)
    except (OSError, TypeError):
        text = ""
    return {name for name in (*vars(base), *re.findall(r"self\.(_\w+)\b", text)) if is_private(name)}


def test_no_class_uses_or_redefines_a_private_name_of_its_library_base():
    found = {
        f"{cls.__module__}.{cls.__qualname__}.{name} ({base.__module__}.{base.__qualname__})"
        for cls, bases in classes_above_library_classes()
        for base in bases
        for name in own_names(cls) & names_of_library(base)
    }
    assert not found, f"rename it, or move it to a module compat.py: {found}"


@pytest.mark.parametrize("path", sources("*.js") + sources("*.html"), ids=lambda path: str(path.relative_to(ROOT)))
def test_no_private_name_of_the_libraries_scripts_is_used(path):
    found = re.findall(r"\.\s*_\w+|Bokeh\.loader|importShim", path.read_text(encoding="utf-8"))
    assert not found, f"move it to page/shared/compat.js: {found}"
