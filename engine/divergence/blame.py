"""Which number is to blame for a difference, and what to change first, in words."""

import numpy as np

from ..wording import percent
from .agreement import SAME, is_visible
from .compare import Comparison
from .experiments import Experiment, total_difference

HELPS = 0.9  # an experiment that leaves more than this of the difference is no help
NEARLY = 1.3  # times as much may remain without the time step, if the step scatters the section
THIRD = 3.0  # a time-step part of a third of the rest adds 5 % to the root of the sum of squares
MOST_STEPS = 10_000_000


def best_experiment(
    comparison: Comparison, experiments: list[Experiment], total: float, scatter: float
) -> Experiment | None:
    """Return the experiment that leaves least of the difference, None if none helps.

    If the time step scatters the section, the experiment without a time step is preferred: with such a step, what
    other values of K and D leave is partly chance, and the section stays blurred.
    """
    without_step = [each for each in experiments if each.changed == "steps"]
    if without_step and is_visible(scatter, comparison):
        remaining = without_step[0].remaining
        if remaining <= min(NEARLY * experiments[0].remaining, total):
            return without_step[0]
    return experiments[0] if experiments and experiments[0].remaining <= HELPS * total else None


def blame_sentence(comparison: Comparison, total: float, best: Experiment | None) -> tuple[str, dict]:
    """Return what is to blame and what to change first, as a sentence and as numbers."""
    if not comparison.motions.reference.period and comparison.statistics.alike:
        return "Nothing is to blame.", {}
    if best is None:
        return "No single number is to blame: parts of it cancel; change K, D and the step together.", {}
    if total <= SAME:
        name = {"steps": "the time step", "joint damping": "the joint damping"}.get(best.changed, best.changed)
        return f"The largest share is that of {name}: without it, {percent(best.remaining)} would be left.", {}
    sentences = {
        "steps": _time_step_sentence,
        "joint damping": _joint_damping_sentence,
        "K": _stiffness_sentence,
        "D": _damping_sentence,
    }
    return sentences[best.changed](comparison, best)


def _time_step_sentence(comparison: Comparison, best: Experiment) -> tuple[str, dict]:
    method = comparison.runs.penalty.method
    part = comparison.time_step if comparison.motions.reference.period else comparison.statistics.time_step
    steps = _rounded_up(method.steps * max(2.0, THIRD * part / max(best.remaining, 1e-6)))
    way = f"about {steps:,} steps" if method.located else f"the located step, or about {steps:,} steps"
    change = {"steps": steps} if method.located else {"located": True}
    helps = best.remaining <= HELPS * total_difference(comparison)
    blame = "is to blame" if helps else "comes first, since it hides what K and D do"
    return f"The time step {blame}: without it {percent(best.remaining)} would be left; take {way}.", change


def _joint_damping_sentence(comparison: Comparison, best: Experiment) -> tuple[str, dict]:
    return (
        f"The joint damping is to blame: without it {percent(best.remaining)} would be left; the penalty model has no "
        "place for it, so no K, D or time step mends it.",
        {},
    )


def _stiffness_sentence(comparison: Comparison, best: Experiment) -> tuple[str, dict]:
    old, new = comparison.runs.penalty.method, best.method
    along = "" if new.damping == old.damping else f" with D = {new.damping:.3g}"
    text = f"K is to blame: K = {new.stiffness:g}{along} leaves {percent(best.remaining)}."
    return text, {"K": new.stiffness} | ({"D": new.damping} if along else {})


def _damping_sentence(comparison: Comparison, best: Experiment) -> tuple[str, dict]:
    value = best.method.damping
    return f"D is to blame: D = {value:.3g}, of equal restitution, leaves {percent(best.remaining)}.", {"D": value}


def _rounded_up(steps: float) -> int:
    """Round up to one significant digit."""
    digit = 10 ** np.floor(np.log10(steps))
    return int(min(np.ceil(steps / digit) * digit, MOST_STEPS))
