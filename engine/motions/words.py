"""A motion in words: the only place that says how a motion repeats itself, and how two motions differ in kind."""

import math

from vibroscope.engine.facts import Amount, Statement, Symbol, stated
from vibroscope.engine.motions.description import Kind, Motion
from vibroscope.engine.motions.tolerances import UNBROKEN
from vibroscope.engine.wording import every

_TYPES = {
    Kind.CHAOTIC: "is chaotic and never repeats",
    Kind.QUASI_PERIODIC: "is quasi-periodic: two frequencies, so that it never quite repeats",
    Kind.DIVERGED: "blew up",
}


_SYMMETRY = {True: "symmetric between the stops", False: "not symmetric: its mirror image is a motion, too"}
NOT_JUDGED = "kind not judged"  # of a motion of which a section alone is known, unless that shows the kind
SYMBOLS = {1: "ξ₁", 2: "ξ₂"}  # of a body's displacement


def repetition(found: Motion) -> str:
    """How a motion repeats itself, such as "repeats every 2 periods".

    Scatter of a displacement about the points of the cycle is its standard deviation. Only evidence shows that the time
    step causes it; without evidence the motion "nearly repeats".

    Examples
    --------
    >>> from vibroscope.engine import Newmark, System, motion, repetition
    >>> repetition(motion(System(), 2.76, Newmark(12000, 18, 8000)))
    'repeats every period, blurred by the time step (±0.034 in ξ₂)'
    """
    if math.isfinite(found.own_period):
        return "repeats with a period of its own"
    words = repetition_of(found.type, found.period, found.near_period, found.scatter, found.step_noise > 0, found.body)
    return words if found.symmetric is None else stated("{}, {}", words, _SYMMETRY[found.symmetric])


def repetition_of(kind: Kind, period: int, near_period: int, scatter: float, blurred: bool, body: int = 2) -> str:
    """How a motion repeats itself, by its numbers; ``blurred``: whether the step causes the scatter of ``body``."""
    if kind in _TYPES:
        return _TYPES[kind]
    if not near_period:
        return "does not repeat"
    cycle = every(near_period)
    amount = ""
    if math.isfinite(scatter):
        amount = stated(" (±{} in {})", Amount(scatter, "displacement", 2), Symbol(SYMBOLS[body]))
    if blurred:
        return Statement(f"repeats {cycle}, blurred by the time step", amount)
    return f"repeats {cycle}" if period == near_period else Statement(f"nearly repeats {cycle}", amount)


def of_section(words: str, period: int, has_step: bool) -> str:
    """What the section of one run shows of a motion; any period but one may be the doing of a time step."""
    return stated("{}, {}", words, NOT_JUDGED) if has_step and period != 1 else words


def difference_in_kind(reference: Motion, penalty: Motion) -> str:
    """Both motions in words if they are of different kind; else empty.

    Motions are of one kind if they repeat after equally many periods, scatter ignored, or if neither repeats.
    """
    if penalty.near_period == reference.near_period and penalty.type is not Kind.DIVERGED:
        return ""
    if penalty.type is reference.type in (Kind.CHAOTIC, Kind.QUASI_PERIODIC):  # though one of them may nearly repeat
        return ""
    return stated("the penalty solution {}, the reference {}", repetition(penalty), repetition(reference))


def stays_apart(found: Motion) -> bool:
    """Whether nothing touches in the kept periods of a run."""
    return found.contact_share == 0.0 and found.impacts_per_period == 0.0


def stays_together(found: Motion) -> bool:
    """Whether the bodies never part in the kept periods of a run."""
    return found.contact_share >= 1.0 - UNBROKEN


def touching(found: Motion) -> str:
    """A sentence on a motion in which contact never changes; else empty."""
    if stays_together(found):
        return "The bodies stay in contact all the time."
    if stays_apart(found):
        return "Nothing touches: the bodies stay apart all the time, so that K and D have no effect."
    return ""
