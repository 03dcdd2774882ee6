"""Which number is to blame for a difference, and what to change first, in words."""

from collections.abc import Callable

import numpy as np

from .agreement import SAME, shows
from .compare import Comparison
from .cures import HELPS, Cure, difference
from .details import percent

NEARLY = 1.3  # times as much is left
THIRD = 3.0  # a time step that adds a third of what K and D do hardly shows in the root of the sum of squares
MOST_STEPS = 10_000_000


def best_cure(found: Comparison, tried: list[Cure], total: float, scatter: float) -> Cure | None:
    """The cure that leaves least; the step's, if the step scatters the section and its cure leaves hardly more.

    For what K and D leave at such a step is scattered too, a matter of chance, and the section stays a blot with them.
    """
    limit = [cure for cure in tried if cure.name == "steps"]
    if limit and shows(found, scatter) and limit[0].left <= min(NEARLY * tried[0].left, total):
        return limit[0]
    return tried[0] if tried and tried[0].left <= HELPS * total else None


def blamed(found: Comparison, total: float, best: Cure | None) -> tuple[str, dict]:
    """What is to blame and the first thing to change, as a sentence and as numbers."""
    if not found.motions.reference.period and found.statistics.alike:
        return "Nothing is to blame.", {}
    if best is None:
        return "No single number is to blame: parts of it cancel; change K, D and the step together.", {}
    if total <= SAME:
        name = {"steps": "the time step", "joint damping": "the joint damping"}.get(best.name, best.name)
        return f"The largest share is that of {name}: without it, {percent(best.left)} would be left.", {}
    say: dict[str, Callable] = {"steps": _steps, "joint damping": _joint, "K": _stiffness, "D": _damping}
    return say[best.name](found, best)


def _steps(found: Comparison, best: Cure) -> tuple[str, dict]:
    method = found.runs.penalty.method
    part = found.time_step if found.motions.reference.period else found.statistics.time_step
    steps = _rounded(method.steps * max(2.0, THIRD * part / max(best.left, 1e-6)))
    way = f"about {steps:,} steps" if method.located else f"the located step, or about {steps:,} steps"
    change = {"steps": steps} if method.located else {"located": True}
    blame = "is to blame" if best.left <= HELPS * difference(found) else "comes first, since it hides what K and D do"
    return f"The time step {blame}: without it {percent(best.left)} would be left; take {way}.", change


def _joint(found: Comparison, best: Cure) -> tuple[str, dict]:
    return (
        f"The joint damping is to blame: without it {percent(best.left)} would be left; the penalty model has no "
        "place for it, so no K, D or time step mends it.",
        {},
    )


def _stiffness(found: Comparison, best: Cure) -> tuple[str, dict]:
    now, new = found.runs.penalty.method, best.method
    along = "" if new.damping == now.damping else f" with D = {new.damping:.3g}"
    text = f"K is to blame: K = {new.stiffness:g}{along} leaves {percent(best.left)}."
    return text, {"K": new.stiffness} | ({"D": new.damping} if along else {})


def _damping(found: Comparison, best: Cure) -> tuple[str, dict]:
    value = best.method.damping
    return f"D is to blame: D = {value:.3g}, of equal restitution, leaves {percent(best.left)}.", {"D": value}


def _rounded(steps: float) -> int:
    """Up to the next number of one digit."""
    digit = 10 ** np.floor(np.log10(steps))
    return int(min(np.ceil(steps / digit) * digit, MOST_STEPS))
