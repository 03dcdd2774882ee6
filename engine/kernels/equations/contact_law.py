"""Contact laws: the force λ between the bodies, ≥ 0 where it pushes.

**Penalty contact** (g ≤ 0), a spring K and a damper D; the factor 2 follows the convention of 2dᵢ:

    λ = −K g − 2D g′                    "kelvin-voigt": may pull near the end of a contact         (5)
    λ = max(0, −K g − 2D g′)            "cut": Kelvin–Voigt cut at zero                            (6)

Both are linear where they push. In them the gap oscillates, or creeps, as the *contact mode*: with M = 1 + 1/μ the
inverse of the reduced mass, its eigenvalues obey

    s² + 2DM s + KM = 0                                                                            (7)

(the bodies' own springs and dampers left out), that is frequency ω_c = √(KM) and damping ratio ζ = DM/ω_c.

**Permanent contact** (reference): the force that keeps the bodies together is −μ̂ times the gap acceleration (3) that
the free motion would have, μ̂ the reduced mass, so that release is smooth by construction,

    λ = μ̂ [(κ² − 1)(ξ − ξ₁ₛ) + 2(d₂κ − d₁) ξ′ − κ² gₛ − f(τ)]                                       (8)

with the static equilibrium ξ₁ₛ, gₛ of the separated bodies and the force f(τ) that drives the gap; in the paper's
system these three are zero. At a wall, where κ = 1 and d₂ = d₁, only the last two terms are left.

It amounts to sharing the extra joint damping between the bodies by mass. Shared otherwise, bodies would part into each
other.
"""

import math

from ..compile.options import jit, jit_inlined, jit_uncontracted

LAWS = ("kelvin-voigt", "cut")  # a law is given to kernels as its index in here
KELVIN_VOIGT, CUT = range(len(LAWS))


@jit_uncontracted
def force(stiffness, damping, gap, rate):
    """λ of a spring and a damper, Eq. (5)."""
    return -stiffness * gap - 2.0 * damping * rate


@jit_inlined
def force_of_law(law, linear):
    """λ of a penalty law, from what Eq. (5) gives.

    An implicit step finds λ = L/(1 + S) with S ≥ 0 from the linear force L after a step without contact. It has the
    sign of L, so that cutting it at zero is exact. A law with another slope where it pushes needs another S.
    """
    return max(linear, 0.0) if law == CUT else linear  # Eqs. (5) and (6)


@jit
def joint_force(p):
    """Factors of ξ and ξ′ in Eq. (8), as μ/(1 + μ)·(κ² − 1) = κ₃² − 1."""
    return (p.kappa3 - 1.0) * (p.kappa3 + 1.0), p.mass_share * 2.0 * (p.d2 * p.kappa - p.d1)


@jit
def joint_force_constant(p):
    """What Eq. (8) has without ξ, ξ′ and f."""
    return -(joint_force(p)[0] * p.free_position + p.mass_share * p.kappa * p.kappa * p.free_gap)


@jit
def contact_rate(stiffness, damping, inverse_mass):
    """|s| of the faster eigenvalue of the contact mode, Eq. (7)."""
    decay, square = damping * inverse_mass, stiffness * inverse_mass
    return decay + math.sqrt(decay * decay - square) if decay * decay > square else math.sqrt(square)
