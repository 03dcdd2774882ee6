"""The numbers behind a verdict, a sentence each."""

import numpy as np

from ..wording import percent
from .compare import Comparison
from .contact import damping_ratio, restitution_of
from .encounters import delivered_restitution
from .experiments import Experiment, equal_damping
from .parts import PARTS


def detail_sentences(comparison: Comparison, experiments: list[Experiment]) -> tuple[str, ...]:
    """Return the numbers behind the headline of a verdict as sentences."""
    method, system = comparison.runs.penalty.method, comparison.runs.reference.system
    ratio = damping_ratio(system, method.stiffness, method.damping)
    delivered = delivered_restitution(comparison.runs.penalty)
    lines = []
    if comparison.pointwise:
        parts = ", ".join(f"{name.replace('_', ' ')} {percent(getattr(comparison, name))}" for name in PARTS)
        lines.append(f"Of the {percent(comparison.total)}: {parts}; these add up at each instant, not as numbers.")
    elif comparison.motions.reference.period:
        lines.append("Not all four motions repeat: differences at an instant are averages over what does not.")
    lines.append(
        f"The contact's damping ratio is ζ = {ratio:.3g}: restitution {restitution_of(ratio):.3g}"
        f"{'' if np.isnan(delivered) else f', delivered {delivered:.3g}'}, wanted {system.restitution:g}; "
        f"equal restitution wants D = {equal_damping(comparison, method.stiffness):.3g}."
    )
    if comparison.encounters is not None:
        matches = comparison.encounters
        late = "" if np.isnan(matches.phase_error) else f", {percent(matches.phase_error)} of a period apart"
        lines.append(
            f"Impacts met in a period: {matches.matched:.3g}{late}; lost: {matches.lost:.3g}; "
            f"added: {matches.added:.3g}."
        )
    shares = [percent(motion.contact_share) for motion in (comparison.motions.reference, comparison.motions.penalty)]
    lines.append(f"Contact takes {shares[0]} of the time in the reference, {shares[1]} in the penalty solution.")
    if experiments:
        left = "; ".join(f"{_name(each)} leaves {percent(each.remaining)}" for each in experiments)
        lines.append(f"If one number alone is changed: {left}.")
    return tuple(lines)


def _name(experiment: Experiment) -> str:
    if experiment.method is None:
        return f"no {'time step' if experiment.changed == 'steps' else 'joint damping'}"
    return f"K = {experiment.method.stiffness:g}, D = {experiment.method.damping:.3g}"
