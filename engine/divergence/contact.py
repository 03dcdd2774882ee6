"""The penalty contact as a damped oscillator: closed-form relations that steer the choice of K, D and Δτ.

While the pendulums touch and nothing else counts, the gap obeys g″ + 2D(1 + 1/μ)g′ + K(1 + 1/μ)g = 0: an oscillation of
the frequency ω_c = √(K(1 + 1/μ)) and the damping ratio ζ = D(1 + 1/μ)/ω_c (MODEL.md, "Penalty"). A contact lasts about
half of it, π/ω_c, and returns the share exp(−πζ/√(1 − ζ²)) of the closing speed. These are no more than guides: the
springs and the excitation act during the contact as well, and a step resolves it only in part.
"""

import math

import numpy as np

from ..model import System


def stiffness_for(system: System, eta: float, steps: int, contact: float) -> float:
    """K for which half an oscillation of the contact, π/ω_c, takes so many steps Δτ = 2π/(ηn)."""
    return system.mass_share * (eta * steps / (2 * contact)) ** 2


def damping_ratio_for(restitution: float) -> float:
    """ζ with exp(−πζ/√(1 − ζ²)) = e: 0 for e = 1, 1 for e = 0."""
    if restitution == 0:
        return 1.0
    logarithm = -math.log(restitution)
    return logarithm / math.hypot(math.pi, logarithm)


def damping_for(system: System, stiffness: float, ratio: float) -> float:
    """D = ζ√(Kμ/(1 + μ)), the contact damping of the damping ratio ζ."""
    return ratio * math.sqrt(stiffness * system.mass_share)


def equal_restitution_damping(system: System, stiffness: float | np.ndarray) -> float | np.ndarray:
    """D = ζ(e) √(Kμ/(1 + μ)), with which a single contact of stiffness K returns the share e of the closing speed."""
    return damping_ratio_for(system.restitution) * np.sqrt(stiffness * system.mass_share)


def damping_ratio(system: System, stiffness: float, damping: float) -> float:
    """ζ = D/√(Kμ/(1 + μ)): the inverse of :func:`damping_for`."""
    return damping / math.sqrt(stiffness * system.mass_share)
