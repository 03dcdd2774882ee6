"""Branches of periodic motions over a number of the problem, with their bifurcations.

``find`` is the way in, ``search`` looks for branches, ``follow`` follows one; ``curve`` solves the equations of orbits
with one sequence of events (:mod:`..drivers.orbit`), ``margins`` says where it holds, ``sequences`` what follows where
it does not. ``point_curve`` follows a point in two numbers; ``points`` has a problem for each kind. Both are curves for
the ``tracer``.
"""

from vibroscope.engine.continuation.branch import Branch, Point, branches_dataset
from vibroscope.engine.continuation.family import PARAMETERS, BranchQuestion
from vibroscope.engine.continuation.kinds import POINT_KINDS, PointKind
from vibroscope.engine.continuation.point_curve import PointCurve, PointCurves, continue_point
from vibroscope.engine.continuation.points import FOLLOWED_KINDS
from vibroscope.engine.continuation.search import continue_branch, find_branches, search_branches

__all__ = [
    "FOLLOWED_KINDS",
    "PARAMETERS",
    "POINT_KINDS",
    "Branch",
    "BranchQuestion",
    "Point",
    "PointCurve",
    "PointCurves",
    "PointKind",
    "branches_dataset",
    "continue_branch",
    "continue_point",
    "find_branches",
    "search_branches",
]
