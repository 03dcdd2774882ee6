"""The search over K, D and the time step, each alone, everything else as it is, and over the choices.

A curve marks the value of equal restitution, D_e(K) or K_e(D) (:mod:`.conditions`), and the largest K, or the least
number of steps, with RESOLVED steps in a contact. Steps are halved and doubled; their limit is the solution without a
step. The choices that codes differ in are changed alone, too: the contact status, the integrator, and a law without the
damper's jump at touch.

Where no number alone does, two and three are changed together: K with D at equal restitution, and both with a step that
resolves the contact.
"""

import math
from collections.abc import Callable, Iterator
from dataclasses import replace

import numpy as np
from vibroscope.engine.contact import damping_for, equal_damping, equal_stiffness, ratio_of_method
from vibroscope.engine.divergence.alone import Alone, Change
from vibroscope.engine.divergence.compare import Comparison
from vibroscope.engine.divergence.conditions import conditions, with_equal_damping
from vibroscope.engine.divergence.number_search import FINE, GridSearch, StepSearch, TogetherSearch
from vibroscope.engine.divergence.remaining import Remaining
from vibroscope.engine.divergence.tolerances import AMPLE, LEAST_IN_CONTACT, LESS, RESOLVED
from vibroscope.engine.integrators import NewmarkBeta
from vibroscope.engine.law_table import LAWS
from vibroscope.engine.methods import (
    DAMPING_RANGE,
    STEPS_RANGE,
    STIFFNESS_RANGE,
    TimeStepping,
    with_located_steps,
)
from vibroscope.engine.model import System
from vibroscope.engine.wording import rounded_up

STIFFNESS_DECADES = 6  # of K above the stiffer of both springs
DAMPING_DECADES = 3  # of D on each side of equal restitution
MOST_TIMES_THE_STEPS = 64  # times as many steps as the penalty solution has are tried at most


def search_alone(
    comparison: Comparison, remaining: Remaining, progress: Callable[[Alone], None] = lambda found: None
) -> Alone:
    """Change every number alone.

    Parameters
    ----------
    comparison : Comparison
        With ``parts``.
    remaining : Remaining
        Makes the runs; may raise `Cancelled`.
    progress : callable, optional
        Called with the coarse curves, one more each time, and with each curve whose lowest point is known.
    """
    total, floor = comparison.difference.total, joint_damping_part(comparison)
    searches, curves = _searches(comparison, remaining), {}
    for name, search in searches.items():
        search.run_coarse()
        curves[name] = search.curve()
        progress(Alone(total, floor, dict(curves)))
    for name, search in searches.items():
        best = search.best()
        curves[name] = replace(search.curve(), best=best if best and best.left < LESS * total else None)
        progress(Alone(total, floor, dict(curves)))
    return Alone(total, floor, curves, tuple(_choices(comparison, remaining)), done=True)


def search_together(comparison: Comparison, remaining: Remaining, with_step: bool = False) -> Change | None:
    """Change K with D at equal restitution, and ``with_step`` with a step that takes AMPLE steps in a contact.

    None where the law takes its damper from the restitution.
    """
    run, speed = comparison.runs.penalty, comparison.closing_speed
    if run.method.damping is None:
        return None

    def make(stiffness: float) -> TimeStepping:
        fitting = with_equal_damping(run.system, run.method, stiffness, speed)
        if not with_step:
            return fitting
        steps = conditions(run.system, run.eta, fitting, speed).steps
        enough = fitting.steps * AMPLE / steps if steps > 0 else math.inf
        most = min(MOST_TIMES_THE_STEPS * fitting.steps, STEPS_RANGE[1])
        return replace(fitting, steps=math.ceil(rounded_up(min(max(fitting.steps, enough), most))))

    name = "K, D and the step" if with_step else "K and D"
    search = TogetherSearch(name, make, remaining, stiffness_ends(comparison))
    found = search.search(comparison.difference.total)
    return found and (replace(found, changed="K and D") if found.method.steps == run.method.steps else found)


def joint_damping_part(comparison: Comparison) -> float:
    """The part of the joint damping, which neither K nor D nor the step has; 0 if there is none, or it is not known."""
    return comparison.difference.parts.get("joint_damping", 0.0)


def enough_steps(comparison: Comparison, remaining: Remaining, most_left: float) -> Change | None:
    """The least doubled number of steps with which, and with twice as many, no more is left; None if there is none."""
    search = StepSearch(comparison.runs.penalty.method, remaining, math.nan)
    return search.enough(most_left)


def stiffness_ends(comparison: Comparison) -> tuple[float, float]:
    """The range of K that is searched: from the stiffer spring of the bodies on, and about the present one.

    Between two stops no contact is shorter than LEAST_IN_CONTACT steps: one of a step or two gains energy without a
    bound, since the play never grows, and crosses it at every step.
    """
    run, speed = comparison.runs.penalty, comparison.closing_speed
    system, present = run.system, run.method.stiffness
    soft = system.stiffer_spring
    ends = min(soft, present / 10.0), max(soft * 10.0**STIFFNESS_DECADES, present * 10.0)
    if system.two_stops and not run.method.located:
        steps = conditions(system, run.eta, run.method, speed).steps
        ends = ends[0], min(ends[1], max(present, _stiffness_with(LEAST_IN_CONTACT, system, run.method, steps)))
    return max(ends[0], STIFFNESS_RANGE[0]), min(ends[1], STIFFNESS_RANGE[1])


def _searches(comparison: Comparison, remaining: Remaining) -> dict[str, "GridSearch | StepSearch"]:
    run = comparison.runs.penalty
    system, method, speed = run.system, run.method, comparison.closing_speed

    def holds(changed: TimeStepping) -> bool:
        return conditions(system, run.eta, changed, speed).hold

    equal = equal_stiffness(system, method, speed)
    steps = conditions(system, run.eta, method, speed).steps
    resolved = math.nan if method.located else _stiffness_with(RESOLVED, system, method, steps)
    searches: dict[str, GridSearch | StepSearch] = {
        "K": GridSearch(
            "K", lambda k: replace(method, stiffness=k), remaining, stiffness_ends(comparison), holds, equal, resolved
        )
    }
    if method.damping is not None:
        equal = equal_damping(system, method, method.stiffness, speed)
        middle = equal if equal > 0 else damping_for(system, method.stiffness, 1.0)
        ends = [middle * 10.0**power for power in (-DAMPING_DECADES, DAMPING_DECADES)]
        if method.damping > 0:
            ends = min(ends[0], method.damping), max(ends[1], method.damping)
        ends = max(ends[0], 1e-9), min(ends[1], DAMPING_RANGE[1])
        searches["D"] = GridSearch("D", lambda d: replace(method, damping=d), remaining, ends, holds, equal)
    least = math.nan if method.located else method.steps * RESOLVED / steps
    return searches | {"steps": StepSearch(method, remaining, least)}


def _stiffness_with(wanted: float, system: System, method: TimeStepping, steps: float) -> float:
    """The K with as many steps in a contact as are wanted, where the present one has ``steps``.

    A contact of the force Kδⁿ lasts as K^(-1/(n + 1)), a damped one of a linear spring as (K - D²/m)^(-1/2).
    """
    ratio = ratio_of_method(system.mass_share, method)
    damped = method.stiffness * ratio**2 if method.spring_exponent == 1.0 and ratio < 1.0 else 0.0
    return damped + (method.stiffness - damped) * (steps / wanted) ** (method.spring_exponent + 1.0)


# --- choices ----------------------------------------------------------------------------------------------------------


def changed_choices(method: TimeStepping) -> Iterator[tuple[str, TimeStepping]]:
    """Yield the name of a choice that codes differ in, and the method with this choice changed."""
    if not method.located:
        yield "status", with_located_steps(method)
        if not method.integrator.explicit:
            yield "status", replace(method, status="start" if method.status == "end" else "end")
    if method.integrator != NewmarkBeta():
        yield "integrator", replace(method, integrator=NewmarkBeta())
    if (smooth := without_jump(method)) is not None:
        yield "law", smooth


def without_jump(method: TimeStepping) -> TimeStepping | None:
    """Return a method with a contact law whose damper does not jump where the bodies touch; None if there is none."""
    law = LAWS[method.law].without_jump
    if method.located or not law or not method.damping:
        return None
    return replace(method, law=law)


def _choices(comparison: Comparison, remaining: Remaining) -> Iterator[Change]:
    changed = list(changed_choices(comparison.runs.penalty.method))
    remaining.run_ahead((method for _, method in changed), whole=True)
    remaining.run_ahead(each for _, method in changed for each in _beside(method))
    for name, method in changed:
        left, around = remaining.whole(method), [remaining(each) for each in _beside(method)]
        if math.isfinite(left):
            yield Change(name, left, float(np.median([left, *around])), method)
    if "joint_damping" in comparison.part_names:
        left = remaining.without_joint_damping()
        yield Change("joint damping", left, left)


def _beside(method: TimeStepping) -> list[TimeStepping]:
    """The method with neighbours of its K."""
    beside = (min(max(method.stiffness * FINE**step, STIFFNESS_RANGE[0]), STIFFNESS_RANGE[1]) for step in (-1, 1))
    return [replace(method, stiffness=stiffness) for stiffness in beside]
