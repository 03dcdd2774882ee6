"""A motion in words: the only place that says how a motion repeats itself, and how two motions differ in kind."""

from ..wording import every, rounded
from .description import Kind, Motion

_TYPES = {
    Kind.CHAOTIC: "is chaotic and never repeats",
    Kind.QUASI_PERIODIC: "is quasi-periodic: two frequencies, so that it never quite repeats",
    Kind.DIVERGED: "blew up",
}


def repetition(found: Motion) -> str:
    """How a motion repeats itself, such as "repeats every 2 periods".

    Scatter of ξ₂ about the points of the cycle is its standard deviation. Only evidence shows that the time step causes
    it; without evidence the motion "nearly repeats".
    """
    if found.type in _TYPES:
        return _TYPES[found.type]
    if not found.near_period:
        return "does not repeat"
    cycle, scatter = every(found.near_period), f"±{rounded(found.scatter, 2)} in ξ₂"
    if found.step_noise > 0:
        return f"repeats {cycle}, blurred by the time step ({scatter})"
    return f"repeats {cycle}" if found.period == found.near_period else f"nearly repeats {cycle} ({scatter})"


def difference_in_kind(reference: Motion, penalty: Motion) -> str:
    """What each motion does, if they are of different kind; else empty.

    Motions are of one kind if they repeat after equally many periods, scatter ignored, or if neither repeats.
    """
    if penalty.near_period == reference.near_period and penalty.type is not Kind.DIVERGED:
        return ""
    return f"the penalty solution {repetition(penalty)}, the reference {repetition(reference)}"
