"""What is zero at a point of a branch, beside the equations of its orbit, so that it is followed in two numbers.

Each module has the condition of some kinds of points; a module that is added here is found, with the kinds it names.
"""

from importlib import import_module
from pkgutil import iter_modules

from ..margins import POINT_KINDS
from .condition import Condition

for _module in iter_modules(__path__):
    import_module(f"{__name__}.{_module.name}")

FOLLOWED = tuple(kind for kind in POINT_KINDS if kind in Condition.by_kind)

__all__ = ["FOLLOWED", "Condition"]
