"""The numbers behind a verdict, a sentence each."""

import numpy as np

from ..wording import percent, rounded
from .compare import Comparison
from .contact import damping_ratio, restitution_of
from .difference import PART_NAMES
from .encounters import delivered_restitution
from .experiments import Experiment, equal_damping


def detail_sentences(comparison: Comparison, experiments: list[Experiment]) -> tuple[str, ...]:
    """Return the numbers behind the headline of a verdict as sentences."""
    method, system = comparison.runs.penalty.method, comparison.runs.reference.system
    ratio = damping_ratio(system, method.stiffness, method.damping)
    delivered = delivered_restitution(comparison.runs.penalty)
    bounce = restitution_of(ratio) if np.isnan(delivered) else delivered
    difference, lines = comparison.difference, []
    if comparison.pointwise:
        parts = ", ".join(f"{PART_NAMES[name]} {percent(value)}" for name, value in difference.parts.items())
        lines.append(f"Of the {percent(difference.total)}: {parts}; these add up at each instant, not as numbers.")
    elif difference.measure == "displacements":
        lines.append("Not all four motions repeat, so that the difference, an average, has no parts.")
    lines.append(
        f"The bodies part with {rounded(bounce, 2)} of the speed at which they meet; the restitution e asks for "
        f"{rounded(system.restitution, 2)}, which D = {equal_damping(comparison, method.stiffness):.3g} would give "
        f"(damping ratio of the contact ζ = {rounded(ratio, 2)})."
    )
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
        left = "; ".join(f"{_name(each)} leaves {percent(each.remaining)}" for each in experiments)
        lines.append(f"If one number alone is changed: {left}.")
    return tuple(lines)


def _name(experiment: Experiment) -> str:
    if experiment.method is None:
        return f"no {'time step' if experiment.changed == 'steps' else 'joint damping'}"
    return f"K = {experiment.method.stiffness:g}, D = {experiment.method.damping:.3g}"
