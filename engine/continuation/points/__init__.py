"""Points of branches as problems in two numbers.

Each module has the problem of some kinds of points; a module that is added here is found, with the kinds it names.
"""

from importlib import import_module
from pkgutil import iter_modules

from vibroscope.engine.continuation.kinds import POINT_KINDS
from vibroscope.engine.continuation.points.problem import PointProblem

for _module in iter_modules(__path__):
    import_module(f"{__name__}.{_module.name}")

FOLLOWED_KINDS = tuple(kind for kind in POINT_KINDS if kind in PointProblem.by_kind)

__all__ = ["FOLLOWED_KINDS", "PointProblem"]
