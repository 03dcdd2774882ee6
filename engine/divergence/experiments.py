"""Experiments that change one number alone and measure what remains of a difference.

The largest part of a difference (:mod:`.parts`) need not be what a change removes, since parts can cancel each other,
and the parts do not separate K from D. So experiments decide which number is to blame:

- no time step: the exact penalty solution, which has been run already;
- no joint damping of its own, where it has one: the reference with derived joint damping, which has been run already;
- D of equal restitution, D = ζ(e) √(Kμ/(1 + μ)), or that of another law at the mean closing speed of the reference;
  if a law has none half D and twice D: Newmark is run again;
- ten times K, once with D kept, and once with D growing as √K (as K where the law's damper is a factor of
  the spring's force), which keeps the restitution: Newmark is run twice more.

Where the law takes its damper from the restitution, there is no D to change.

The choices that codes differ in are tried, too, each alone; the paper's Newmark is a choice of each:

- its contact status: steps that are located, and if those do not do, the other one of start and end;
- its integrator: Newmark's method, α = ½, β = ¼, which damps nothing;
- a contact law without the damper's jump where the bodies touch.

Status and integrator are what a time step consists of: they are tried only where no time step would help, in a run that
begins where the exact penalty solution ends. A law is stepped only where K, D and law are the largest part, and the law
helps more than all else without a step.

What remains is the error of :class:`.error.Target`, or if the reference does not repeat itself, the distance between
sections (:mod:`.statistics`).
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

import numpy as np

from ..integrators import NewmarkBeta
from ..law_table import LAWS, RATIO_LAWS
from ..methods import STEPS_RANGE, STIFFNESS_RANGE, ExactPenalty, Newmark, TimeStepping, is_located
from ..result import Checkpoint, Record
from ..simulate import simulate
from .agreement import SAME
from .compare import Comparison
from .contact import damping_of_law
from .encounters import mean_closing_speed
from .error import Target
from .statistics import long_section, wasserstein_distance
from .time_step import with_located_steps

HELPS = 0.75  # an experiment that leaves more than this of the difference is no help
NEARLY = 1.3  # times as much may remain with a choice, or a number of steps, that stands for no time step at all
STEPS_FACTOR = 3.0  # a time-step part of a third of the rest adds 5 % to the root of the sum of squares
MOST_STEPS = 20.0  # times as many steps as the penalty solution has are tried at most
SETTLING = 150  # periods of a run that begins where the exact penalty solution ends
STIFFER = 10.0
EQUAL = 0.01  # relative: D as close as this to equal restitution is not changed
SAMPLES = 100  # per period
WITHOUT_JUMP = "limited"  # the law of the same spring and damper without that


@dataclass(frozen=True)
class Experiment:
    """Outcome of changing one number.

    Attributes
    ----------
    changed : {"steps", "K", "D", "joint damping", "status", "integrator", "law"}
    remaining : float
        What remains of the difference, relative to the reference.
    method : Newmark, TimeStepping or None
        What was run; None for the limits without a time step, and without a joint damping of its own.
    enough : bool
        Of a number of steps: whether it leaves nearly as little as the best experiment.
    """

    changed: str
    remaining: float
    method: Newmark | TimeStepping | None = None
    enough: bool = True


def run_experiments(comparison: Comparison, cancelled: Callable[[], bool] | None = None) -> list[Experiment]:
    """Change every number alone, by three runs or more; the experiment that leaves least comes first.

    Parameters
    ----------
    comparison : Comparison
        With ``parts``: Newmark and the reference reached their ends.
    """
    limits = {"time_step": "steps", "joint_damping": "joint damping"}
    experiments = [
        Experiment(changed, _remaining_without(comparison, part))
        for part, changed in limits.items()
        if part in comparison.part_names
    ]
    experiments += [
        Experiment(name, _remaining_with(comparison, method, cancelled), method)
        for name, method in _changed_methods(comparison)
    ]
    experiments += _of_choices(comparison, experiments, cancelled)
    return by_remaining(experiments)


def by_remaining(experiments: list[Experiment]) -> list[Experiment]:
    """Return those whose runs did not end early, the one that leaves least first."""
    known = [experiment for experiment in experiments if np.isfinite(experiment.remaining)]
    return sorted(known, key=lambda experiment: experiment.remaining)


def _of_choices(comparison: Comparison, others: list[Experiment], cancelled) -> Iterator[Experiment]:
    """Change the choices that can be worth it by what the other experiments leave."""
    least = min((each.remaining for each in others if np.isfinite(each.remaining)), default=np.inf)
    by_contact = comparison.difference.largest in ("regularisation", "")
    without_step = next((each.remaining for each in others if each.changed == "steps"), np.inf)
    step_helps = without_step <= HELPS * comparison.difference.total
    done = False
    for name, method in changed_choices(comparison.runs.penalty.method):
        if name == "law":
            worth = by_contact and _remaining_with(comparison, method.limit, cancelled, settled=True) <= HELPS * least
        else:
            worth = step_helps and not (name == "status" and done)
        if worth:
            left = _remaining_with(comparison, method, cancelled, settled=name != "law")
            done = done or (name == "status" and left <= enough_for(min(least, left)))
            yield Experiment(name, left, method)


def enough_for(least: float) -> float:
    """Return what a change of the time step may leave to do as well as the best experiment, which leaves ``least``."""
    return max(NEARLY * least, SAME)


def with_enough_steps(comparison: Comparison, experiments: list[Experiment], cancelled=None) -> Experiment:
    """Try more steps, twice as many each time, until they leave nearly as little as the best experiment.

    The first number is estimated. If MOST_STEPS times as many do not do, the last experiment has no ``enough``.
    """
    method = comparison.runs.penalty.method
    left = next(each.remaining for each in experiments if each.changed == "steps")
    part = comparison.difference.parts.get("time_step", comparison.difference.total)
    most = int(min(MOST_STEPS * method.steps, STEPS_RANGE[1]))
    steps = _rounded_up(method.steps * max(2.0, STEPS_FACTOR * part / max(left, 1e-6)))
    while True:
        tried = replace(method, steps=min(steps, most))
        remaining = _remaining_with(comparison, tried, cancelled, settled=True)
        enough = remaining <= min(enough_for(experiments[0].remaining), HELPS * comparison.difference.total)
        if enough or steps >= most:
            return Experiment("steps", remaining, tried, enough)
        steps *= 2


def equal_damping(comparison: Comparison, method: Newmark | TimeStepping) -> float:
    """Return the D with which a contact of a method's K and law delivers the reference's restitution.

    With a law that depends on it, at the mean closing speed of the reference. nan where the law takes its damper from
    the restitution, where nothing collides, and where no D gives so small a restitution.
    """
    system = comparison.runs.reference.system
    if method.damping is None:
        return np.nan
    return damping_of_law(system, method, method.stiffness, mean_closing_speed(comparison.runs.reference))


def _remaining_without(comparison: Comparison, part: str) -> float:
    """The difference that remains without the time step, or without the joint damping."""
    if comparison.motions.reference.period:
        return comparison.parts.without(part)
    statistics = comparison.statistics
    sections = statistics.sections
    pairs = {
        "time_step": (sections.exact, sections.reference),
        "joint_damping": (sections.penalty, sections.derived),
    }
    return wasserstein_distance(*pairs[part]) / statistics.size


def _as_time_stepping(method: Newmark | TimeStepping) -> TimeStepping:
    """Return the method itself, or the same steps as Newmark's under the name that has all choices."""
    if isinstance(method, TimeStepping):
        return method
    return TimeStepping(method.stiffness, method.damping, method.steps, law=method.law, every_step=method.every_step)


def without_jump(method: Newmark | TimeStepping) -> TimeStepping | None:
    """Return a method with a contact law whose damper does not jump where the bodies touch; None if there is none."""
    if is_located(method) or not LAWS[method.law].jumps or not method.damping:
        return None
    return replace(_as_time_stepping(method), law=WITHOUT_JUMP)


def changed_choices(method: Newmark | TimeStepping) -> Iterator[tuple[str, Newmark | TimeStepping]]:
    """Yield the name of a choice that codes differ in, and the method with this choice changed."""
    own = _as_time_stepping(method)
    if not is_located(method):
        yield "status", with_located_steps(method)
        if not own.integrator.explicit:
            yield "status", replace(own, status="start" if own.status == "end" else "end")
    if own.integrator != NewmarkBeta():
        yield "integrator", replace(own, integrator=NewmarkBeta())
    if (smooth := without_jump(method)) is not None:
        yield "law", smooth


def _changed_methods(comparison: Comparison) -> Iterator[tuple[str, Newmark | TimeStepping]]:
    """Yield the name of a number, and the method with this number changed, to one of three digits."""
    method = comparison.runs.penalty.method
    equal = equal_damping(comparison, method)
    if np.isfinite(equal):
        if abs(method.damping - equal) > EQUAL * equal:
            yield "D", replace(method, damping=round_to_three_digits(equal))
    elif method.damping:
        for factor in (0.5, 2.0):
            yield "D", replace(method, damping=round_to_three_digits(factor * method.damping))
    stiffer = round_to_three_digits(STIFFER * method.stiffness)
    if stiffer <= STIFFNESS_RANGE[1]:
        yield "K", replace(method, stiffness=stiffer)
        if method.damping:
            power = 1.0 if method.law in RATIO_LAWS else 0.5
            damping = round_to_three_digits(STIFFER**power * method.damping)
            yield "K", replace(method, stiffness=stiffer, damping=damping)


def _remaining_with(
    comparison: Comparison, method: ExactPenalty | Newmark | TimeStepping, cancelled, settled: bool = False
) -> float:
    """The difference that remains with another method; nan or inf if its run ends early.

    ``settled``: run it from where the exact penalty solution is after all periods, which takes fewer of them.
    """
    run, exact, period = comparison.runs.penalty, comparison.runs.exact, comparison.motions.reference.period
    record = Record(run.keep, SAMPLES) if period else None
    options = {"periods": run.periods, "initial": comparison.start}
    if settled and exact.ok:
        start = Checkpoint(run.system, run.eta, method, 0, exact.section[-1])  # it may lie anywhere
        options = {"periods": min(run.periods, run.keep + SETTLING), "initial": start}
    changed = simulate(run.system, run.eta, method, keep=run.keep, record=record, **options, cancelled=cancelled)
    if period:
        return Target(comparison.runs.reference, period).error(changed, cancelled)
    return comparison.statistics.total_of(long_section(changed, cancelled))


def round_to_three_digits(value: float) -> float:
    """Round a K or D that may be proposed to three significant digits, few enough to read."""
    return float(f"{value:.3g}")


def _rounded_up(steps: float) -> int:
    """Round up to one significant digit."""
    digit = 10 ** np.floor(np.log10(steps))
    return int(min(np.ceil(steps / digit) * digit, STEPS_RANGE[1]))
