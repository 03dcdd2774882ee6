"""Contact laws: the force λ between the bodies, ≥ 0 where it pushes.

**Penalty contact** (g ≤ 0), a spring K and a damper D; the factor 2 follows the convention of 2dᵢ:

    λ = −K g − 2D g′                    "kelvin-voigt": may pull near the end of a contact         (5)
    λ = max(0, −K g − 2D g′)            "cut": Kelvin–Voigt cut at zero                            (6)

Both are linear where they push. With the penetration δ = −g, its rate v = −g′ and c = 2D three more are piecewise
linear (:data:`PIECES`),

    λ = Kδ + min(max(cv, −Kδ), Kδ)      "limited": neither jumps nor pulls                         (16)
    λ = Kδ + c max(v, 0)                "compression": the damper acts while the bodies close      (17)
    λ = Kδ + (r − 1)K max(δ − d, 0) + cv    "bilinear": beyond the penetration d the stiffness is rK  (60)

and these are smooth where the bodies overlap; h and c may depend on the closing speed at touch (:func:`gain_at`):

    λ = Kδⁿ(1 + hv)                     "hunt-crossley", "lankarani-nikravesh", "flores"           (18)
    λ = Kδ^1.5 + c δ^¼ max(v, 0)        "jankowski"                                                (19)
    λ = Kδⁿ + c δ^((n−1)/2) v           "constant-restitution"                                     (20)
    λ = max(0, Kδⁿ + c S(δ/d) v)        "impact": S(x) = x²(3 − 2x), 1 beyond the penetration d    (21)

Sources: Modelica Standard Library, Mechanics.Translational ElastoGap (16); Mahmoud & Jankowski, Eng. Struct. 33 (2011)
(17); Hunt & Crossley, J. Appl. Mech. 42 (1975), Lankarani & Nikravesh, J. Mech. Des. 112 (1990), Flores et al.,
Multibody Syst. Dyn. 25 (2011) (18); Jankowski, Earthq. Eng. Struct. Dyn. 34 (2005) (19); arXiv 2603.27764 (20); the
function IMPACT of Adams and MotionSolve (21).

In (5) and (6) the gap oscillates, or creeps, as the *contact mode*: with M = 1 + 1/μ the
inverse of the reduced mass, its eigenvalues obey

    s² + 2DM s + KM = 0                                                                            (7)

(the bodies' own springs and dampers left out), that is frequency ω_c = √(KM) and damping ratio ζ = DM/ω_c.

**Permanent contact** (reference): the force that keeps the bodies together is −μ̂ times the gap acceleration (3) that
the free motion would have, μ̂ the reduced mass, so that release is smooth by construction,

    λ = μ̂ [(κ² − 1)(ξ − ξ₁ₛ) + 2(d₂κ − d₁) ξ′ − κ² gₛ − f(τ)]                                       (8)

with the static equilibrium ξ₁ₛ, gₛ of the separated bodies and the force f(τ) that drives the gap; in the paper's
system these three are zero. At a wall only the last two terms are left; where motions are counted from touch, κ²gₛ is
the pull (:mod:`..parameters`).

It amounts to sharing the extra joint damping between the bodies by mass. Shared otherwise, bodies would part into each
other.

A power that compiled code computes where it is needed and nowhere else.

LLVM takes a power, ``x**n``, for as cheap as a product. So it does not branch around one: whatever has a power in one
of its cases computes it in all of them, which takes twice the time of a whole step. A call of the C library's function
stays where it is written. It gives the same bits.
"""

import math
from typing import NamedTuple

import numpy as np
from llvmlite import ir
from numba import types
from numba.core.cgutils import get_or_insert_function
from numba.extending import intrinsic, overload
from vibroscope.engine.kernels.compile.options import jit, jit_inlined, jit_no_alloc, jit_uncontracted

_REAL = ir.DoubleType()


@intrinsic
def _library_pow(typing_context, base, exponent):
    def generate(context, builder, signature, arguments):
        function = get_or_insert_function(builder.module, ir.FunctionType(_REAL, [_REAL, _REAL]), "pow")
        return builder.call(function, arguments)

    return types.float64(types.float64, types.float64), generate


def to_power(base, exponent):
    """baseᵉˣᵖᵒⁿᵉⁿᵗ of two floats."""
    return base**exponent


@overload(to_power)
def _to_power_compiled(base, exponent):
    return lambda base, exponent: _library_pow(base, exponent)


LAWS = range(11)  # the laws by their places in engine/law_table.py, which names them
KELVIN_VOIGT, CUT, LIMITED, COMPRESSION = LAWS[:4]
HUNT_CROSSLEY, _, FLORES, JANKOWSKI, CONSTANT, IMPACT, BILINEAR = LAWS[4:]

# A contact consists of *pieces*, in each of which the force has one formula. Flight is one, too. MAIN is that of spring
# and damper. From there a kink leads to OTHER, or a second one to BEYOND, and each of these back to MAIN.
FREE, MAIN, OTHER, BEYOND = range(4)
SMALLER, LARGER = -1.0, 1.0
# Of a law that is piecewise linear, the pieces from OTHER on: a, b and f of their force aKδ + bcv + fKd, whether the
# law takes the smaller or the larger of that and of the force so far, and what r times is added to a and to f; d and r
# are the penetration and the stiffening of the law
_PIECES = {
    KELVIN_VOIGT: (),
    CUT: ((0.0, 0.0, 0.0, LARGER, 0.0, 0.0),),  # Eq. (6)
    LIMITED: ((2.0, 0.0, 0.0, SMALLER, 0.0, 0.0), (0.0, 0.0, 0.0, LARGER, 0.0, 0.0)),  # Eq. (16)
    COMPRESSION: ((1.0, 0.0, 0.0, LARGER, 0.0, 0.0),),  # Eq. (17)
    BILINEAR: ((0.0, 1.0, 1.0, LARGER, 1.0, -1.0),),  # Eq. (60): rKδ + cv + (1 − r)Kd
}
PIECES = np.zeros((len(LAWS), 4, 6))  # of a law and a piece, as above
PIECES[:, MAIN, :2] = 1.0
KINKS = np.zeros(len(LAWS), dtype=np.int64)  # of a law
KINKS[[JANKOWSKI, IMPACT]] = 1  # of their own kinds: :mod:`..time_stepping.law_pieces`
PIECEWISE_LINEAR = np.zeros(len(LAWS), dtype=np.bool_)
for _law, _rows in _PIECES.items():
    KINKS[_law], PIECEWISE_LINEAR[_law] = len(_rows), True
    for _piece, _row in enumerate(_rows, OTHER):
        PIECES[_law, _piece] = _row


class ContactLaw(NamedTuple):
    """The numbers of a contact law, as in :class:`..parameters.Parameters`; each law reads its own."""

    kind: int  # of LAWS
    stiffness: float  # K
    exponent: float
    penetration: float
    stiffening: float
    gain: float
    relative: float


@jit_inlined
def contact_law_of(p):
    """The contact law, from :class:`..parameters.Parameters`."""
    return ContactLaw(int(p.law), p.stiffness, p.exponent, p.penetration, p.stiffening, p.gain, p.relative)


@jit_uncontracted
def force(stiffness, damping, gap, rate):
    """λ of a spring and a damper, Eq. (5)."""
    return -stiffness * gap - 2.0 * damping * rate  # Eq. (5)


@jit_inlined
def force_of_law(kind, linear):
    """λ of a penalty law, from what Eq. (5) gives.

    An implicit step finds λ = L/(1 + S) with S ≥ 0 from the linear force L after a step without contact. It has the
    sign of L, so that cutting it at zero is exact. Other laws are solved for (:mod:`..time_stepping.law_step`).
    """
    return max(linear, 0.0) if kind == CUT else linear  # Eqs. (5) and (6)


@jit_inlined
def is_piecewise_linear(kind):
    """Whether a law is a spring, a damper and a constant in each of its pieces, all of them in :data:`PIECES`."""
    return PIECEWISE_LINEAR[int(kind)]


@jit_inlined
def factors(law, piece):
    """The factors a, b and f in the force aKδ + bcv + fKd of a piece."""
    i = law.kind
    spring = PIECES[i, piece, 0] + PIECES[i, piece, 4] * law.stiffening
    return spring, PIECES[i, piece, 1], PIECES[i, piece, 2] + PIECES[i, piece, 5] * law.stiffening


@jit_inlined
def takes_larger(kind, piece):
    """Whether the law takes the larger of a piece's force and of that without this piece, or the smaller."""
    return PIECES[int(kind), piece, 3] == LARGER


@jit_inlined
def count_kinks(kind):
    """How many pieces there are beyond MAIN."""
    return KINKS[int(kind)]


@jit_inlined
def of_both(kind, piece, before, own):
    """The force of a law that is ``before`` without a piece and ``own`` in it; likewise what a step gives."""
    return max(before, own) if takes_larger(kind, piece) else min(before, own)


@jit_inlined
def kink(law, piece, spring, damper, knee):
    """What falls below zero where a law goes from MAIN to a piece, of Kδ, cv and Kd."""
    a, b, f = factors(law, piece)
    found = (1.0 - a) * spring + (1.0 - b) * damper - f * knee
    return found if takes_larger(law.kind, piece) else -found


@jit_inlined
def gain_at(law, closing):
    """c, or h of Eq. (18), of a contact that closed with a speed; 0 where it closed without and they depend on it."""
    if law.relative == 0.0:
        return law.gain
    return law.gain / closing if closing > 0.0 else 0.0


@jit_inlined
def power(depth, exponent):
    """δⁿ, of Hertz at a fifth of the cost of a power."""
    return depth * math.sqrt(depth) if exponent == 1.5 else to_power(depth, exponent)


@jit_inlined
def damper_growth(depth, exponent):
    """δ to half of n − 1, by which the damper of Eq. (20) grows."""
    return math.sqrt(math.sqrt(depth)) if exponent == 1.5 else to_power(depth, 0.5 * (exponent - 1.0))


@jit_inlined
def full_damping(share):
    """S(x) of Eq. (21) up to x = 1."""
    return share * share * (3.0 - 2.0 * share)


@jit_no_alloc
def law_force(law, gain, depth, speed):
    """λ of any law, Eqs. (5), (6), (16) to (21) and (60), from δ = ``depth`` and v = ``speed``.

    Beyond δ = 0 a law that jumps there, Eqs. (5), (6), (17), (60) and (20) with n = 1, goes on; the others are zero.
    ``law``: a :class:`ContactLaw`; ``gain``: c, or h of Eq. (18).
    """
    kind, stiffness, exponent = law.kind, law.stiffness, law.exponent
    if is_piecewise_linear(kind) or (kind == CONSTANT and exponent == 1.0):
        spring, damper, knee = stiffness * depth, gain * speed, stiffness * law.penetration
        found = spring + damper
        for piece in range(OTHER, OTHER + count_kinks(kind)):  # Eqs. (6), (16), (17) and (60)
            a, b, f = factors(law, piece)
            found = of_both(kind, piece, found, a * spring + b * damper + f * knee)
        return found
    if not depth > 0.0:
        return 0.0
    spring = stiffness * power(depth, exponent)
    if kind <= FLORES:
        return spring * (1.0 + gain * speed)  # Eq. (18)
    if kind == JANKOWSKI:
        return spring + gain * math.sqrt(math.sqrt(depth)) * max(speed, 0.0)  # Eq. (19)
    if kind == CONSTANT:
        return spring + gain * damper_growth(depth, exponent) * speed  # Eq. (20)
    return max(spring + gain * full_damping(min(depth / law.penetration, 1.0)) * speed, 0.0)  # Eq. (21)


@jit_no_alloc
def law_slopes(law, gain, depth, speed):
    """∂λ/∂δ and ∂λ/∂v of Eqs. (18) to (21) where δ > 0, as :func:`law_force`; at a kink that of one of its sides."""
    kind, exponent = law.kind, law.exponent
    spring = law.stiffness * power(depth, exponent)
    growth = exponent * spring / depth
    if kind <= FLORES:
        return growth * (1.0 + gain * speed), gain * spring
    if kind == JANKOWSKI:
        damper = gain * math.sqrt(math.sqrt(depth)) if speed > 0.0 else 0.0
        return growth + 0.25 * damper * speed / depth, damper
    if kind == CONSTANT:
        damper = gain * damper_growth(depth, exponent)
        return growth + 0.5 * (exponent - 1.0) * damper * speed / depth, damper
    share = min(depth / law.penetration, 1.0)
    damper = gain * full_damping(share)
    if not spring + damper * speed > 0.0:
        return 0.0, 0.0
    return growth + 6.0 * gain * share * (1.0 - share) / law.penetration * speed, damper


@jit
def joint_force(p):
    """Factors of ξ and ξ′ in Eq. (8), as μ/(1 + μ)·(κ² − k₁) = κ₃² − k₁."""
    stiffening = p.kappa3 * p.kappa3 if p.spring1 == 0.0 else (p.kappa3 - 1.0) * (p.kappa3 + 1.0)
    return stiffening, p.mass_share * 2.0 * (p.damper2 - p.d1)


@jit
def joint_force_constant(p):
    """What Eq. (8) has without ξ, ξ′ and f."""
    by_gap = p.mass_share * p.kappa * p.kappa * p.free_gap
    return -(joint_force(p)[0] * p.free_position + by_gap + p.mass_share * p.pull)


@jit
def contact_rate(stiffness, damping, inverse_mass):
    """|s| of the faster eigenvalue of the contact mode, Eq. (7)."""
    decay, square = damping * inverse_mass, stiffness * inverse_mass
    return decay + math.sqrt(decay * decay - square) if decay * decay > square else math.sqrt(square)
