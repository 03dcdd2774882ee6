"""How fast a motion can be: bounds of the eigenvalues |ν| by which tables choose their spacing and steps their size."""

from vibroscope.engine.kernels.compile.options import jit
from vibroscope.engine.kernels.equations.contact_law import contact_rate


@jit
def load_rate(p):
    """Frequency of the load: η, or that of a pulse; 0 where it is linear in time (:mod:`..event_driven.load`)."""
    return p.eta if p.pulse < 0.0 else p.pulse


@jit
def free_rate(p):
    """Largest |ν| of the separated bodies and the excitation."""
    damper = 2.0 * p.damper2 if p.kappa < 1.0 else 0.0  # no spring need be stronger than it
    return max(1.0, p.kappa, load_rate(p), damper, 2.0 * p.d1 if p.spring1 == 0.0 else 0.0)


@jit
def pressed_rate(p):
    """A bound of the largest |ν| of the bodies pressed together.

    The bodies' own springs, and the coupling of the relative to the common motion, add to the contact mode at most the
    largest |ν| of the separated bodies.
    """
    return free_rate(p) + contact_rate(p.stiffness, p.damping, 1.0 / p.mass_share)
