"""The numbers behind a verdict, a sentence each."""

import numpy as np

from .compare import Comparison
from .contact import damping_ratio
from .cures import Cure, equal_damping
from .encounters import delivered_restitution
from .parts import PARTS
from .regularisation import restitution_of


def details_of(found: Comparison, tried: list[Cure]) -> tuple[str, ...]:
    """The numbers behind the headline."""
    method, system = found.runs.penalty.method, found.runs.reference.system
    ratio = damping_ratio(system, method.stiffness, method.damping)
    delivered = delivered_restitution(found.runs.penalty)
    lines = []
    if found.pointwise:
        shares = ", ".join(f"{name.replace('_', ' ')} {percent(getattr(found, name))}" for name in PARTS)
        lines.append(f"Of the {percent(found.total)}: {shares}; these add up at each instant, not as numbers.")
    elif found.motions.reference.period:
        lines.append("Not all four motions repeat: differences at an instant are averages over what does not.")
    lines.append(
        f"The contact's damping ratio is ζ = {ratio:.3g}: restitution {restitution_of(ratio):.3g}"
        f"{'' if np.isnan(delivered) else f', delivered {delivered:.3g}'}, wanted {system.restitution:g}; "
        f"equal restitution wants D = {equal_damping(found, method.stiffness):.3g}."
    )
    if found.encounters is not None:
        met = found.encounters
        late = "" if np.isnan(met.phase_error) else f", {percent(met.phase_error)} of a period apart"
        lines.append(f"Impacts met in a period: {met.matched:.3g}{late}; lost: {met.lost:.3g}; added: {met.added:.3g}.")
    share = [percent(motion.contact_share) for motion in (found.motions.reference, found.motions.penalty)]
    lines.append(f"Contact takes {share[0]} of the time in the reference, {share[1]} in the penalty solution.")
    if tried:
        left = "; ".join(f"{_name(cure)} leaves {percent(cure.left)}" for cure in tried)
        lines.append(f"If one number alone is changed: {left}.")
    return tuple(lines)


def _name(cure: Cure) -> str:
    if cure.method is None:
        return f"no {'time step' if cure.name == 'steps' else 'joint damping'}"
    return f"K = {cure.method.stiffness:g}, D = {cure.method.damping:.3g}"


def percent(share: float) -> str:
    """A share in two digits; what rounding leaves is nothing."""
    if share < 1e-7:
        return "0 %"
    return f"{100 * share:.2g} %" if share < 0.995 else f"{100 * share:.0f} %"


def number(count: float, noun: str) -> str:
    """A count with its noun."""
    return f"{count:.3g} {noun}{'' if count == 1 else 's'}"
