"""What regularisation by K and D is made of: the contact takes time, its restitution is another, and it pulls.

An isolated contact that begins with the closing speed v is an oscillation of the gap, of frequency ω_c and damping
ratio ζ (:mod:`.contact`): with ω_d = ω_c √(1 − ζ²) the penetration is p = (v/ω_d) exp(−ζω_c t) sin ω_d t.

*Restitution.* The paper's contact ends when p = 0, at ω_d t = π, with p′ = −v exp(−πζ/√(1 − ζ²)) = −e(ζ) v.

*Pulling.* Before that, from where p″ = 0 on, the damper pulls: the force μ/(1 + μ)·(−p″) is negative. With ζ = sin δ,
p″ = 0 reads tan ω_d t = −tan 2δ, so that ω_d t = π − 2δ, and there p′ = −e°(ζ) v with

    e°(ζ) = exp(−ζ (π − 2 arcsin ζ)/√(1 − ζ²)),        exp(−2ζ arcosh ζ/√(ζ² − 1)) for ζ > 1.

A contact that lets go where its force vanishes would deliver e° > e(ζ). (Schwager and Pöschel, Granular Matter 9 (2007)
465, give the same.) For ζ ≥ 1 the gap creeps back and e(ζ) = 0.

So two more references tell three parts that add up to the regularisation, all with derived joint damping:

    exact penalty(K, D) − reference(e) =  [exact penalty(K, D) − reference(e(ζ))]   finite contact time
                                        + [reference(e(ζ)) − reference(e°(ζ))]      pulling at the end of contact
                                        + [reference(e°(ζ)) − reference(e)]         restitution of the damper alone

The last two together are what a wrong restitution e(ζ) ≠ e does; at equal restitution they cancel each other, since
D = ζ(e)√(Kμ/(1 + μ)) counts on the pull. The first also holds all that impacts know nothing of: contacts that follow
each other before the first has ended, or are pressed by the springs besides; so it is a remainder as well.
"""

import math
from dataclasses import dataclass, replace

import numpy as np

from ..methods import ExactPenalty
from ..motions.section import repeats_after
from ..result import Record, Response
from ..simulate import simulate
from .contact import damping_ratio
from .grid import laid_over
from .parts import Parts


def restitution_of(ratio: float) -> float:
    """e(ζ) = exp(−πζ/√(1 − ζ²)) that a contact of damping ratio ζ delivers; 0 for ζ ≥ 1."""
    return math.exp(-math.pi * ratio / math.sqrt((1 - ratio) * (1 + ratio))) if ratio < 1 else 0.0


def restitution_without_pull(ratio: float) -> float:
    """e°(ζ), were the contact to end where its force vanishes (see the module)."""
    root = math.sqrt(abs(1 - ratio) * (1 + ratio))
    if root < 1e-6:
        return math.exp(-2.0)
    return math.exp(-2 * ratio * (math.acos(ratio) if ratio < 1 else math.acosh(ratio)) / root)


@dataclass(frozen=True)
class Regularisation:
    """Finite contact time, pulling and the damper's restitution; they add up to the regularisation.

    Attributes
    ----------
    ratio : float
        ζ of the contact.
    restitution, without_pull : float
        e(ζ) and e°(ζ).
    contact_time, pulling, damper : (4, n) ndarray
        The parts on the grid of :class:`.parts.Parts`: ξ₁, ξ₂, ξ₁′, ξ₂′; nan where a reference ended early.
    in_step : bool
        Whether the two further references repeat after as many periods as the one with e; else they mean little.
    """

    ratio: float
    restitution: float
    without_pull: float
    contact_time: np.ndarray
    pulling: np.ndarray
    damper: np.ndarray
    in_step: bool

    @property
    def wrong_restitution(self) -> np.ndarray:
        """Reference(e(ζ)) − reference(e): pulling and the damper together."""
        return self.pulling + self.damper


def split_regularisation(parts: Parts, exact: ExactPenalty, derived: Response, grid: Record) -> Regularisation:
    """Split the regularisation of a comparison; it runs the reference twice.

    Parameters
    ----------
    parts : Parts
    exact : ExactPenalty
    derived : Response
        Of the reference with derived joint damping: its run is repeated with e(ζ) and e°(ζ).
    grid : Record
        Of one period of the parts.
    """
    ratio = damping_ratio(derived.system, exact.stiffness, exact.damping)
    values = restitution_of(ratio), restitution_without_pull(ratio)
    fixed = parts.runs.derived.reshape(4, derived.keep, -1)
    found, periods = [], {repeats_after(derived.section)}
    for restitution in values:
        run = _with_restitution(derived, restitution)
        period = repeats_after(run.section) if run.ok else 0
        periods.add(period)
        found.append(laid_over(run, period, fixed, grid)[0].reshape(4, -1))
    delivered, unpulled = found
    return Regularisation(
        ratio,
        *values,
        contact_time=parts.runs.exact - delivered,
        pulling=delivered - unpulled,
        damper=unpulled - parts.runs.derived,
        in_step=len(periods) == 1 and 0 not in periods,
    )


def _with_restitution(derived: Response, restitution: float) -> Response:
    system = replace(derived.system, restitution=restitution)
    return simulate(system, derived.eta, derived.method, periods=derived.periods, keep=derived.keep)
