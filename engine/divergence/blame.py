"""The number to blame for a difference, and the one to change first, in words."""

import numpy as np

from ..drivers.step_maps import damps
from ..methods import Newmark, status_of
from ..wording import percent
from .agreement import SAME, is_visible
from .compare import Comparison
from .difference import Difference
from .experiments import HELPS, NEARLY, Experiment, enough_for, equal_damping, round_to_three_digits

PART_OF = {"steps": "time_step", "K": "regularisation", "D": "regularisation", "joint damping": "joint_damping"}
PART_OF |= {"status": "time_step", "integrator": "time_step", "law": "regularisation"}
_OF_STEPS = "status", "integrator"  # what a time step consists of
_NAMES = {"steps": "The time step", "joint damping": "The joint damping", "law": "The damper's jump at touch"}
_STATUSES = {"located": "steps cut where contact changes", "end": "that at the end", "start": "that at the start"}


def best_experiment(comparison: Comparison, experiments: list[Experiment], scatter: float) -> Experiment | None:
    """Return the experiment that leaves least of the difference, None if none helps.

    If the time step scatters the section, the experiment without a time step is preferred: with such a step, what
    other values of K and D leave is partly chance, and the section stays blurred. A difference so small that the curves
    coincide has no cure; then it is the experiment on its largest part.
    """
    difference = comparison.difference
    if difference.total <= difference.chance:
        return None
    if difference.total <= SAME:
        return next((each for each in experiments if PART_OF[each.changed] == difference.largest), None)
    helpful = [each for each in experiments if each.remaining <= HELPS * difference.total]
    without_step = [each for each in helpful if each.changed == "steps"]
    best = helpful[0] if helpful else None
    if without_step and is_visible(scatter, comparison) and without_step[0].remaining <= NEARLY * best.remaining:
        best = without_step[0]
    return _narrowed(best, helpful)


def _narrowed(best: Experiment | None, helpful: list[Experiment]) -> Experiment | None:
    """Return the choice within the time step that does nearly as much as all else, if no time step at all is best."""
    if best is None or best.changed != "steps":
        return best
    enough = enough_for(helpful[0].remaining)
    return next((each for each in helpful if each.changed in _OF_STEPS and each.remaining <= enough), best)


def blame_sentence(comparison: Comparison, experiments: list[Experiment], best: Experiment | None) -> tuple[str, dict]:
    """Return what is to blame and what to change first, as a sentence and as numbers."""
    difference = comparison.difference
    if difference.total <= difference.chance:
        return "Nothing is to blame.", {}
    if difference.total <= SAME:
        return _largest_sentence(difference), {}
    if best is None:
        least = f" (at best {percent(experiments[0].remaining)} is left)" if experiments else ""
        return f"No single number is to blame{least}: change K, D and the step together.", {}
    sentences = {
        "steps": _time_step_sentence,
        "joint damping": _joint_damping_sentence,
        "K": _stiffness_sentence,
        "D": _damping_sentence,
        "status": _status_sentence,
        "integrator": _integrator_sentence,
        "law": _law_sentence,
    }
    name = blamed(comparison, best.changed)
    rest, change = sentences[best.changed](comparison, best)
    tried = next((each for each in experiments if each.changed == "steps" and each.method is not None), None)
    if tried is not None and best is not tried and PART_OF[best.changed] == PART_OF["steps"]:
        rest = rest.removesuffix(".") + _and_more_steps(tried)
    return f"{name} {_role(difference, best)}: {rest}", change


def blamed(comparison: Comparison, changed: str) -> str:
    """Return the words for a number or a choice as the beginning of a sentence."""
    method = comparison.runs.penalty.method
    if changed == "status":
        return f"The contact status at the {status_of(method)} of the step"
    if changed == "integrator":
        of = method.integrator
        return f"The numerical damping of {of.name}" if damps(of) else f"The integrator {of.name}"
    return _NAMES.get(changed, changed)


def _status_sentence(comparison: Comparison, best: Experiment) -> tuple[str, dict]:
    status = status_of(best.method)
    change = {"located": True} if isinstance(best.method, Newmark) else {"status": status}
    return f"{_STATUSES[status]} would leave {percent(best.remaining)}.", change


def _and_more_steps(tried: Experiment) -> str:
    """The difference that more steps leave, for codes that cannot cut a step; the end of a sentence."""
    many = f"{tried.method.steps:,} steps a period"
    return (
        f", {many} {percent(tried.remaining)}." if tried.enough else f"; even {many} leave {percent(tried.remaining)}."
    )


def _integrator_sentence(comparison: Comparison, best: Experiment) -> tuple[str, dict]:
    new = best.method.integrator
    change = {"integrator": new.name, "beta": new.beta, "gamma": new.gamma}
    return f"Newmark's ¼ and ½, which damp nothing, leave {percent(best.remaining)}.", change


def _law_sentence(comparison: Comparison, best: Experiment) -> tuple[str, dict]:
    law = best.method.law
    return f"the law {law}, which has none, leaves {percent(best.remaining)}.", {"law": law}


def _largest_sentence(difference: Difference) -> str:
    if not difference.largest:
        return "So little needs no change."
    return f"Its largest part is that of {_part_text(difference)}."


def _role(difference: Difference, best: Experiment) -> str:
    """Whether the number is to blame, or helps although another part is larger: parts can cancel each other."""
    if not difference.parts or PART_OF[best.changed] == difference.largest:
        return "is to blame"
    return f"counts most, although the part of {_part_text(difference)} is larger"


def _part_text(difference: Difference) -> str:
    return f"{difference.name(difference.largest)} ({percent(difference.parts[difference.largest])})"


def _time_step_sentence(comparison: Comparison, best: Experiment) -> tuple[str, dict]:
    left = percent(best.remaining)
    if best.method is None:
        return f"without it {left} would be left.", {}
    return f"{best.method.steps:,} steps a period leave {left}.", {"steps": best.method.steps}


def _joint_damping_sentence(comparison: Comparison, best: Experiment) -> tuple[str, dict]:
    left = percent(best.remaining)
    return f"without it {left} would be left; the penalty model lacks it, so no K, D or time step mends it.", {}


def _stiffness_sentence(comparison: Comparison, best: Experiment) -> tuple[str, dict]:
    old, new = comparison.runs.penalty.method, best.method
    along = "" if new.damping == old.damping else f" with D = {new.damping:g}"
    text = f"K = {new.stiffness:g}{along} leaves {percent(best.remaining)}."
    return text, {"K": new.stiffness} | ({"D": new.damping} if along else {})


def _damping_sentence(comparison: Comparison, best: Experiment) -> tuple[str, dict]:
    value = best.method.damping
    equal = equal_damping(comparison, best.method)
    right = np.isfinite(equal) and value == round_to_three_digits(equal)
    why = ", which restores the right rebound," if right else ""
    return f"D = {value:g}{why} leaves {percent(best.remaining)}.", {"D": value}
