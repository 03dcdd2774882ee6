"""The damper of a contact law: by D, or by the formula of its authors.

λ of each law is Eqs. (5), (6) and (16) to (21) of :mod:`.kernels.equations.contact_law`. Where D is given, its damper
is c = 2D, or h = 2D/K in Eq. (18). Where it is not, a formula gives it from the restitution e that is wanted, with the
closing speed v₀ at each touch and the reduced mass m:

    h = 3(1 − e)/(2v₀)                          Hunt & Crossley, J. Appl. Mech. 42 (1975) 440            (22)
    h = 3(1 − e²)/(4v₀)                         Lankarani & Nikravesh, J. Mech. Des. 112 (1990) 369      (23)
    h = 8(1 − e)/(5ev₀)                         Flores et al., Multibody Syst. Dyn. 25 (2011) 357        (24)
    c = √(Km) · 9√5 (1 − e²)/(e(e(9π − 16) + 16))      Jankowski, Earthq. Eng. Struct. Dyn. 35 (2006) 517   (25)
    c = √(Km) · √(2(n + 1)) (−ln e)/√(π² + ln² e)      arXiv 2603.27764; exact, at any v₀                   (26)

(22) to (25) are approximations: :func:`engine.effective_restitution` says what a contact really gives.
"""

import math
from typing import Any

from .checks import require, whole
from .law_table import LAWS
from .methods import STEPS_RANGE
from .model import System, check_eta

STEP_SCALE_RANGE = (0.0, 1e6)  # of s in K = s m/Δτ², 0 excluded
DIVIDING = "flores", "jankowski", "constant-restitution"  # whose formula has no value for e = 0


def damper_of(system: System, method: Any) -> tuple[float, bool]:
    """c, or h of Eq. (18), of a penalty method, and whether it is still to be divided by the closing speed.

    Raises
    ------
    ValueError
        If D is to follow from a restitution of 0, and the formula divides by it.
    """
    if method.damping is not None:
        return given_gain(method), False
    n = method.spring_exponent
    return formula_damper(method.law, system.restitution, method.stiffness, system.mass_share, n)


def given_gain(method: Any) -> float:
    """c, or h of Eq. (18), of a penalty method whose D is given."""
    return 2.0 * method.damping / (method.stiffness if LAWS[method.law].relative else 1.0)


def formula_damper(law: str, e: float, stiffness: float, mass: float, exponent: float) -> tuple[float, bool]:
    """The damper by the formula of the law's authors, Eqs. (22) to (26); see :func:`damper_of`."""
    if e == 0.0 and law in DIVIDING:
        raise ValueError(f"restitution = 0 gives the law {law!r} no damper, since its formula divides by it: give D")
    if law == "hunt-crossley":
        return 1.5 * (1.0 - e), True  # Eq. (22)
    if law == "lankarani-nikravesh":
        return 0.75 * (1.0 - e * e), True  # Eq. (23)
    if law == "flores":
        return 1.6 * (1.0 - e) / e, True  # Eq. (24)
    critical = math.sqrt(stiffness * mass)
    if law == "jankowski":
        # Eq. (25)
        return 9.0 * math.sqrt(5.0) * (1.0 - e * e) / (e * (e * (9.0 * math.pi - 16.0) + 16.0)) * critical, False
    logarithm = -math.log(e)  # Eq. (26)
    return math.sqrt(2.0 * (exponent + 1.0)) * logarithm / math.hypot(math.pi, logarithm) * critical, False


def stiffness_of_step(system: System, eta: float, steps: float, scale: float) -> float:
    """Return K = s m/Δτ², the contact stiffness that follows the step Δτ = 2π/(ηn), as with SOFT = 1 in LS-DYNA.

    Half the step gives four times K: with a smaller step it is another model. m is the reduced mass; LS-DYNA takes a
    share of the smaller nodal mass instead, and s = SOFSCL, 0.1 by default (FAQ of LSTC, contact.soft1).

    Parameters
    ----------
    steps : float
        n, steps per excitation period.
    scale : float
        s > 0.

    Raises
    ------
    ValueError
        If a number is out of range.

    Examples
    --------
    >>> from vibroscope.engine import System, stiffness_of_step
    >>> round(stiffness_of_step(System(), 2.76, 500, 0.1))
    2247
    """
    step = 2.0 * math.pi / check_eta(eta) / whole("steps", steps, *STEPS_RANGE, "give steps per excitation period")
    why = "give the share s of m/Δτ², 0.05 to 1 in codes"
    s = require("stiffness_of_step", scale, *STEP_SCALE_RANGE, why, open_low=True)
    return s * system.mass_share / step**2


def stiffness_of_duration(system: System, share: float = 0.01) -> float:
    """Return K = μ̂(ω/2s)², with which an undamped contact lasts the share s of the shorter natural period, 2π/ω.

    A stiffness to begin with: the contact is short beside the motion, and some twenty steps of T/2000 long.

    Parameters
    ----------
    system : System
    share : float
        s, above 0 and at most 1.

    Raises
    ------
    ValueError
        If the share is out of range.

    Examples
    --------
    >>> from vibroscope.engine import System, stiffness_of_duration
    >>> stiffness_of_duration(System(wall=True))
    2500.0
    """
    s = require("share", share, 0.0, 1.0, "give the share of a natural period that a contact lasts", open_low=True)
    return system.mass_share * (max(system.frequencies) / (2.0 * s)) ** 2


def restitution_of(ratio: float) -> float:
    """Return e(ζ) = exp(−πζ/√(1 − ζ²)), the restitution of spring and damper; 0 for ζ ≥ 1."""
    return math.exp(-math.pi * ratio / math.sqrt((1 - ratio) * (1 + ratio))) if ratio < 1 else 0.0


def restitution_without_pull(ratio: float) -> float:
    """Return e°(ζ), the restitution of spring and damper cut at zero (see :mod:`.divergence.contact`)."""
    root = math.sqrt(abs(1 - ratio) * (1 + ratio))
    if root < 1e-6:
        return math.exp(-2.0)
    return math.exp(-2 * ratio * (math.acos(ratio) if ratio < 1 else math.acosh(ratio)) / root)
