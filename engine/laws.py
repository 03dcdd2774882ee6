"""The damper of a contact law: by D, or by the formula of its authors.

The formulas are those of :data:`.law_table.LAWS`.
"""

import math
from typing import Any

from .checks import require, whole
from .law_table import LAWS
from .methods import STEPS_RANGE
from .model import System, check_eta

STEP_SCALE_RANGE = (0.0, 1e6)  # of s in K = s m/Δτ², 0 excluded


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
    own = LAWS[law]
    if e == 0.0 and own.divides:
        raise ValueError(f"restitution = 0 gives the law {law!r} no damper, since its formula divides by it: give D")
    factor = own.damper(e, exponent)
    return (factor, True) if own.relative else (factor * math.sqrt(stiffness * mass), False)


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
