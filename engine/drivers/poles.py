"""How fast things oscillate or decay: what the spacing of tables is chosen by."""

import math

from ..model import System


def free_pole(system: System, eta: float) -> float:
    """Largest |λ| of the separated pendulums and the excitation."""
    return max(1.0, system.kappa, eta)


def pressed_pole(system: System, eta: float, stiffness: float, damping: float) -> float:
    """A bound of the largest |λ| with the pendulums pressed together.

    The relative motion on the contact spring has λ² + 2D(1 + 1/μ)λ + K(1 + 1/μ) = 0; the pendulums' own springs and the
    coupling of the two motions add no more than the free poles.
    """
    share = 1 / system.mass_share
    half, square = damping * share, stiffness * share
    contact = half + math.sqrt(half * half - square) if half * half > square else math.sqrt(square)
    return free_pole(system, eta) + contact
