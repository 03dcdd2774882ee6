"""What docstrings refer to, by :func:`…` and its like, exists under that name."""

import re
from importlib import import_module
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
REFERENCE = re.compile(r":(?:func|mod|class|data|meth|attr|exc|obj):`~?([^`<]+?)`")
MODULES = {
    ".".join(("vibroscope", *path.relative_to(ROOT).with_suffix("").parts)).removesuffix(".__init__"): path
    for folder in ("app", "engine")
    for path in (ROOT / folder).rglob("*.py")
    if REFERENCE.search(path.read_text())
}


def found(name):
    """What stands under a dotted name: a module, or what one holds; raises ImportError or AttributeError."""
    module, *rest = name.split(".")
    held = import_module(module)
    for k, part in enumerate(rest, 1):
        try:
            held = import_module(".".join((module, *rest[:k])))  # a function may have the name of its module
        except ImportError:
            if part in getattr(held, "__annotations__", {}):  # a field without a default
                return held
            held = getattr(held, part)
    return held


def exists(name, module, path):
    """Whether a docstring of a module may say this name."""
    package = module if path.name == "__init__.py" else module.rpartition(".")[0]
    if re.search(rf"^    +(def {name}\(|{name}( |:))", path.read_text(), re.MULTILINE):  # of a class of this module
        return True
    places = [f"{module}.{name}", f"vibroscope.{name}", f"vibroscope.engine.{name}", name]
    if dots := len(name) - len(name.lstrip(".")):
        places = [f"{'.'.join(package.split('.')[: len(package.split('.')) - dots + 1])}.{name.lstrip('.')}"]
    for place in places:
        try:
            found(place)
        except (ImportError, AttributeError, ValueError):
            continue
        return True
    return False


@pytest.mark.parametrize("module", MODULES)
def test_what_docstrings_refer_to_exists(module):
    path = MODULES[module]
    names = ["".join(name.split()) for name in REFERENCE.findall(path.read_text())]
    assert not [name for name in names if not exists(name, module, path)]
