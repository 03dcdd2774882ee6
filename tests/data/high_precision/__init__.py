"""The equations of motion solved to any number of digits, independently of the engine and by other means.

Motion. Between events each phase (flight, permanent contact, penalty contact) is one linear system y′ = Ay with

    y = (ξ₁, ξ₁′, g, g′, cos ητ, sin ητ, 1),        g = clearance + ξ₂ − ξ₁.

Its Taylor series yⱼ₊₁ = A yⱼ/(j + 1) is summed over steps h with ‖A‖h ≤ REACH. No modes or steady amplitudes are
computed, so that nothing degenerates at resonance, at ζ = 1, without damping or for κ → 1. Gap and gap rate are part of
the state, so that the flights of a chatter keep all their digits. Steps end at every sample, where cos ητ and sin ητ
are set anew: to (1, 0) at a multiple of T.

For a contact so stiff that ‖A‖ is above STIFF, the same Taylor coefficients are computed from the eigenvectors of A.
Modes that have died away then no longer limit the step; their omitted amplitudes are added to the remainder.

Events. Each phase ends at the first zero of f = g (flight), −g (penalty contact) or λ (permanent contact). On each step
f is a polynomial with a known remainder R. Its Bernstein coefficients b on the step enclose it: if all b > R, it has no
zero; with one change of sign and no b within R of zero, it has exactly one (Descartes). Otherwise the step is halved
(de Casteljau), the left half first. So no zero is missed, however shallow the dip, and an undecidable one raises. The
coefficients are integers in units of 2^-BITS; their rounding is part of R. Where a phase starts with f = 0, f ~ tᵐ, and
the zeros of f/tᵐ are searched.

Bodies with or without springs, two stops, pulses and records: :mod:`.bodies` and :mod:`.between_stops`, by the same
series and zeros.

All parameters are the exact values of the double-precision numbers given to the engine.
"""

from mpmath import mp, mpf

from high_precision.between_stops import solve_case
from high_precision.model import Problem
from high_precision.run import IMPACT, solve

__all__ = ["IMPACT", "Problem", "format_number", "solve", "solve_case"]
DIGITS = 25


def format_number(x, digits=DIGITS):
    """A number to so many digits."""
    return mp.nstr(mpf(x), digits, min_fixed=-4, max_fixed=digits)
