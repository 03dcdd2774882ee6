"""Which of the numbers is to blame: each is changed alone, and what is then left of the difference is measured.

The largest part of a difference (:mod:`.parts`) need not be what a change takes away, since parts can cancel, and
the parts do not tell K from D. So the blame is found by experiment. Without a time step there is the exact penalty
solution; without the joint's own damping, the reference with the derived one; both have been run. K and D are changed
and Newmark is run again:

- D to that of equal restitution, D = ζ(e) √(Kμ/(1 + μ));
- K to ten times as much, with D kept, and with D growing as √K so that its restitution is kept; the better of the two.

What is left is the error of :class:`.error.Target`, or if the reference does not repeat, the distance between
sections (:mod:`.statistics`).
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

import numpy as np

from ..methods import STIFFNESS_RANGE, Newmark
from ..result import Record
from ..simulate import simulate
from .compare import Comparison
from .contact import equal_restitution_damping
from .error import Target
from .grid import rms
from .statistics import distance, section_of

STIFFER = 10.0
EQUAL = 0.01  # D so near to equal restitution is left there
SAMPLES = 100  # per period
HELPS = 0.9  # a change that leaves more of the difference is no cure


@dataclass(frozen=True)
class Cure:
    """One number changed.

    Attributes
    ----------
    name : {"steps", "K", "D", "joint damping"}
    left : float
        What is left of the difference, relative to the reference; nan if it cannot be told.
    method : Newmark or None
        What was run; None for the limits without a time step, and without the joint's own damping.
    """

    name: str
    left: float
    method: Newmark | None = None


def cures(found: Comparison, cancelled: Callable[[], bool] | None = None) -> list[Cure]:
    """Every number changed alone, the one that leaves least first; three runs of Newmark.

    Parameters
    ----------
    found : Comparison
        With ``parts``: Newmark and the reference must have reached their ends.
    """
    tried = [Cure("steps", _limit(found, "time_step")), Cure("joint damping", _limit(found, "joint_damping"))]
    tried += [Cure(name, _left(found, method, cancelled), method) for name, method in _changed(found)]
    known = [cure for cure in tried if np.isfinite(cure.left)]
    return sorted(known, key=lambda cure: cure.left)


def difference(found: Comparison) -> float:
    """What the cures diminish: ``total``, or if the reference does not repeat, that of the statistics."""
    return found.total if found.motions.reference.period else found.statistics.total


def equal_damping(found: Comparison, stiffness: float) -> float:
    """D with which the contact delivers the reference's restitution."""
    return float(equal_restitution_damping(found.runs.reference.system, stiffness))


def _limit(found: Comparison, name: str) -> float:
    if found.motions.reference.period:
        return found.parts.without(name)
    sections = found.statistics.sections
    pair = {
        "time_step": (sections.exact, sections.reference),
        "joint_damping": (sections.penalty, sections.derived),
    }
    return distance(*pair[name]) / rms(sections.reference)


def _changed(found: Comparison) -> Iterator[tuple[str, Newmark]]:
    method = found.runs.penalty.method
    equal = equal_damping(found, method.stiffness)
    if abs(method.damping - equal) > EQUAL * equal:
        yield "D", replace(method, damping=equal)
    stiffer = STIFFER * method.stiffness
    if stiffer <= STIFFNESS_RANGE[1]:
        yield "K", replace(method, stiffness=stiffer)
        yield "K", replace(method, stiffness=stiffer, damping=STIFFER**0.5 * method.damping)


def _left(found: Comparison, method: Newmark, cancelled) -> float:
    run, period = found.runs.penalty, found.motions.reference.period
    record = Record(run.keep, SAMPLES) if period else None
    options = {"periods": run.periods, "keep": run.keep, "record": record, "cancelled": cancelled}
    changed = simulate(run.system, run.eta, method, **options)
    if period:
        return Target(found.runs.reference, period).error(changed)
    return found.statistics.of(section_of(changed))
