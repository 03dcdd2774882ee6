"""The equations of MODEL.md solved to as many digits as asked for, apart from the engine and by other means.

Motion. Between events each phase (flight, joined, penalty contact) is one linear system y′ = Ay with

    y = (ξ₁, ξ₁′, g, g′, η² cos ητ, η² sin ητ),        g = ξ₂ − ξ₁.

Its Taylor series yⱼ₊₁ = A yⱼ/(j + 1) is summed over steps h with ‖A‖h ≤ REACH. There is no formula for modes or steady
motion, so nothing degenerates at resonance, at ζ = 1, without damping or for κ → 1. Gap and gap rate are part of the
state, so the flights of a chatter keep all their digits. Steps end at every multiple of T, where the excitation is set
to (η², 0) anew.

Only for a contact so stiff that ‖A‖ is above STIFF are the same Taylor coefficients summed from the eigenvectors of A,
so that a mode that has died away no longer holds the step down; what is left out is added to the remainder.

Events. Each phase ends at the first zero of f = g (flight), −g (penalty contact) or λ (joined). On each step f is a
polynomial of known remainder R. Its Bernstein coefficients b on the step enclose it: all b > R, no zero; one change of
sign and none of them within R of zero, exactly one (Descartes). Otherwise the step is halved (de Casteljau), the left
half first. So no zero is passed, however shallow the dip, and an undecidable one raises. The coefficients are integers
in units of 2^-BITS; their rounding is part of R. Where a phase starts on the surface f ~ tᵐ, and f/tᵐ is searched.

All parameters are the exact values of the double-precision numbers that the engine is given.
"""

from .model import Problem
from .run import IMPACT, solve

__all__ = ["IMPACT", "Problem", "solve"]
