"""The numbers behind a verdict, a sentence each."""

import math

import numpy as np

from ..methods import CONTACT_LAWS, is_located
from ..motions.words import touching
from ..restitution import effective_restitution
from ..wording import percent, rounded
from .compare import Comparison
from .contact import contact_frequency, damping_ratio, restitution_of
from .encounters import delivered_restitution, mean_closing_speed
from .experiments import Experiment, equal_damping


def detail_sentences(comparison: Comparison, experiments: list[Experiment]) -> tuple[str, ...]:
    """Return the numbers behind the headline of a verdict as sentences."""
    difference, lines = comparison.difference, []
    if comparison.pointwise:
        parts = ", ".join(f"{difference.name(name)} {percent(value)}" for name, value in difference.parts.items())
        lines.append(f"Of the {percent(difference.total)}: {parts}; these add up at each instant, not as numbers.")
    elif difference.measure == "displacements":
        lines.append(_why_no_parts(comparison))
    if not touching(comparison.penalty) or not touching(comparison.reference):  # else nothing meets
        lines += [*_restitution_sentences(comparison), *duration_sentences(comparison)]
    if comparison.encounters is not None:
        matches = comparison.encounters
        late = "" if np.isnan(matches.phase_error) else f", {percent(matches.phase_error)} of a period apart"
        lines.append(
            f"Impacts met in a period: {matches.matched:.3g}{late}; lost: {matches.lost:.3g}; "
            f"added: {matches.added:.3g}."
        )
    shares = [percent(motion.contact_share) for motion in (comparison.reference, comparison.penalty)]
    lines.append(f"Contact takes {shares[0]} of the time in the reference, {shares[1]} in the penalty solution.")
    if experiments:
        left = "; ".join(f"{_leaves(each)} {percent(each.remaining)}" for each in experiments)
        lines.append(f"If one number alone is changed: {left}.")
    return tuple(lines)


def _why_no_parts(comparison: Comparison) -> str:
    """Which motions the kept periods do not show to repeat: a blurred one does, over more periods."""
    names = {
        "penalty": "the penalty solution",
        "exact": "the penalty solution without a time step",
        "derived": "the reference with the joint damping of the penalty model",
    }
    far = [text for name, text in names.items() if not getattr(comparison.motions, name).near_period]
    which = f"{' and '.join(far)} {'does' if len(far) == 1 else 'do'}"
    return (
        f"Over the {comparison.runs.penalty.keep} kept periods {which} not come close to repeating, so that the "
        "difference, an average over them, has no parts."
    )


def _restitution_sentences(comparison: Comparison) -> tuple[str, ...]:
    """Return how fast the bodies part, measured or as a contact alone has it; nothing if nothing collides."""
    run = comparison.runs.penalty
    method, system, bounce = run.method, run.system, delivered_restitution(run)
    asked = f"the restitution e asks for {rounded(system.restitution, 2)}"
    equal = equal_damping(comparison, method)
    if method.damping is None:
        asked += f", from which the law {method.law} takes its damper"
    elif np.isfinite(equal):
        asked += f", which D = {equal:.3g} would give"
    if method.law == CONTACT_LAWS[0]:
        ratio = damping_ratio(system, method.stiffness, method.damping)
        bounce = restitution_of(ratio) if np.isnan(bounce) else bounce
        asked += f" (damping ratio of the contact ζ = {rounded(ratio, 2)})"
    elif np.isnan(bounce):
        speed = mean_closing_speed(comparison.runs.reference)
        if np.isnan(speed):
            return ()
        bounce = effective_restitution(system, method, speed)
    return (f"The bodies part with {rounded(bounce, 2)} of the speed at which they meet; {asked}.",)


def duration_sentences(comparison: Comparison) -> tuple[str, ...]:
    """Return how long a contact lasts, half an oscillation of its mode, and how many steps; nothing if it creeps."""
    run = comparison.runs.penalty
    if run.method.law != CONTACT_LAWS[0]:
        return ()
    ratio = damping_ratio(run.system, run.method.stiffness, run.method.damping)
    if ratio >= 1:
        return ()
    duration = math.pi / (contact_frequency(run.system, run.method.stiffness) * math.sqrt((1 - ratio) * (1 + ratio)))
    steps = duration * run.eta * run.method.steps / (2 * math.pi)
    return (f"A contact of this K and D lasts τ = {duration:.4g}: {rounded(steps, 2)} steps.",)


def _leaves(experiment: Experiment) -> str:
    if experiment.method is not None and experiment.changed == "steps":
        return f"{experiment.method.steps:,} steps leave"
    return f"{_name(experiment)} leaves"


def _name(experiment: Experiment) -> str:
    if experiment.method is None:
        return f"no {'time step' if experiment.changed == 'steps' else 'joint damping'}"
    if experiment.changed in ("status", "integrator", "law"):
        name = "status" if is_located(experiment.method) else experiment.changed
        value = "located" if is_located(experiment.method) else getattr(experiment.method, experiment.changed)
        return f"{name} {getattr(value, 'name', value)}"
    damping = experiment.method.damping
    return f"K = {experiment.method.stiffness:g}" + ("" if damping is None else f", D = {damping:.3g}")
