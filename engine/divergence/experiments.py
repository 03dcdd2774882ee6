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

Of :class:`engine.TimeStepping` the choices of a code are tried, too, each alone:

- its contact status: steps that are located, and the other one of start and end;
- its integrator: Newmark's method, α = ½, β = ¼, which damps nothing;
- a contact law without the damper's jump where the bodies touch.

What remains is the error of :class:`.error.Target`, or if the reference does not repeat itself, the distance between
sections (:mod:`.statistics`).
"""

import contextlib
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

import numpy as np

from ..integrators import NewmarkBeta
from ..laws import RATIO_LAWS
from ..methods import CONTACT_LAWS, CONTACT_STATUSES, STIFFNESS_RANGE, Newmark, TimeStepping, is_located
from ..result import Record
from ..simulate import simulate
from .compare import Comparison
from .contact import damping_of_law
from .encounters import mean_closing_speed
from .error import Target
from .statistics import long_section, wasserstein_distance
from .time_step import with_located_steps

STIFFER = 10.0
EQUAL = 0.01  # relative: D as close as this to equal restitution is not changed
SAMPLES = 100  # per period
JUMPS = "kelvin-voigt", "cut", "compression"  # laws whose damper pushes as soon as the bodies touch
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
    """

    changed: str
    remaining: float
    method: Newmark | TimeStepping | None = None


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
        for name, method in [*_changed_methods(comparison), *changed_choices(comparison.runs.penalty.method)]
    ]
    known = [experiment for experiment in experiments if np.isfinite(experiment.remaining)]
    return sorted(known, key=lambda experiment: experiment.remaining)


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
    """What remains without the time step, or without the joint damping."""
    if comparison.motions.reference.period:
        return comparison.parts.without(part)
    statistics = comparison.statistics
    sections = statistics.sections
    pairs = {
        "time_step": (sections.exact, sections.reference),
        "joint_damping": (sections.penalty, sections.derived),
    }
    return wasserstein_distance(*pairs[part]) / statistics.size


def without_jump(method: Newmark | TimeStepping) -> Newmark | TimeStepping | None:
    """Return a method with a contact law whose damper does not jump where the bodies touch; None if there is none."""
    if method.law not in JUMPS or not method.damping or WITHOUT_JUMP not in CONTACT_LAWS:
        return None
    try:
        return replace(method, law=WITHOUT_JUMP)
    except ValueError:
        return None


def changed_choices(method: Newmark | TimeStepping) -> Iterator[tuple[str, Newmark | TimeStepping]]:
    """Yield the name of a choice that codes differ in, and the method with this choice changed."""
    if isinstance(method, Newmark):
        return
    if not is_located(method):
        with contextlib.suppress(ValueError):
            yield "status", with_located_steps(method)
        if not method.integrator.explicit:
            (other,) = (status for status in CONTACT_STATUSES if status not in (method.status, "located"))
            yield "status", replace(method, status=other)
    if method.integrator != NewmarkBeta():
        yield "integrator", replace(method, integrator=NewmarkBeta())
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


def _remaining_with(comparison: Comparison, method: Newmark | TimeStepping, cancelled) -> float:
    """What remains with another method; nan or inf if its run ends early."""
    run, period = comparison.runs.penalty, comparison.motions.reference.period
    record = Record(run.keep, SAMPLES) if period else None
    options = {"periods": run.periods, "keep": run.keep, "initial": comparison.start, "record": record}
    changed = simulate(run.system, run.eta, method, **options, cancelled=cancelled)
    if period:
        return Target(comparison.runs.reference, period).error(changed, cancelled)
    return comparison.statistics.total_of(long_section(changed, cancelled))


def round_to_three_digits(value: float) -> float:
    """Round a K or D that may be proposed to three significant digits, few enough to read."""
    return float(f"{value:.3g}")
