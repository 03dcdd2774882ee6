"""The restitution that a contact law gives, and the damping that gives a restitution.

A contact is looked at alone: two bodies with the reduced mass m close with the speed v₀; no other force acts. Eqs. (28)
to (31) of :mod:`.law_table` give the restitution where the damping ratio alone decides it. In Eq. (18)

    hv₀ − ln(1 + hv₀) = −hev₀ − ln(1 − hev₀)                  for any K, n and m                 (32)

by separating the variables of mv dv = −Kδⁿ(1 + hv) dδ. The other laws are integrated
(:mod:`.kernels.event_driven.law_contact`). Where the springs of the bodies act during a contact too, it gives another.
"""

import math
from collections.abc import Callable, Sequence
from functools import lru_cache

import numpy as np

from .checks import require
from .drivers.law_driven import restitution_by_steps
from .law_table import HERTZ, LAWS, powers_of
from .laws import damper_of, given_gain
from .methods import ExactPenalty, Newmark, TimeStepping
from .model import System

SPEED_RANGE = (0.0, 1e9)
SMALL_DAMPING = 1e-5  # hv₀ below which e = 1 − 2hv₀/3 to rounding
LARGEST_DAMPING = 1e6  # damping tried, in units of √(Km)


def effective_restitution(
    system: System, method: ExactPenalty | Newmark | TimeStepping, closing_speed: float | Sequence[float]
) -> float | np.ndarray:
    """Return the restitution that a contact of this method gives, at one closing speed or at many.

    Where D is None it is what the law's formula makes of the restitution that it promises, ``system.restitution``.

    Parameters
    ----------
    system : System
    method : ExactPenalty, Newmark or TimeStepping
        Its law and the numbers of that.
    closing_speed : float or (n,) array_like
        v₀ > 0.

    Raises
    ------
    ValueError
        If a closing speed is not positive.

    Examples
    --------
    >>> from vibroscope.engine import ExactPenalty, System, effective_restitution
    >>> asked = System(restitution=0.2)
    >>> round(effective_restitution(asked, ExactPenalty(1000, None, "lankarani-nikravesh"), closing_speed=1.0), 3)
    0.672
    """
    gain, relative = damper_of(system, method)
    contact = method.limit
    speeds = [_speed(each) for each in np.atleast_1d(np.asarray(closing_speed, dtype=object))]
    found = [_given(contact, gain / v if relative else gain, system.mass_share, v) for v in speeds]
    return found[0] if np.ndim(closing_speed) == 0 else np.array(found)


def restitution_of_damping(
    law: str,
    damping: float,
    stiffness: float,
    *,
    mass: float = 1.0,
    closing_speed: float = 1.0,
    exponent: float = HERTZ,
    penetration: float | None = None,
) -> float:
    """Return the restitution that a contact law gives.

    Parameters
    ----------
    law : str
        One of :data:`engine.CONTACT_LAWS`.
    damping, stiffness
        D and K.
    mass : float
        Reduced mass, :attr:`System.mass_share`.
    closing_speed : float
        v₀, without effect on the laws of (28) to (31).
    exponent, penetration
        As those of :class:`engine.ExactPenalty`.

    Raises
    ------
    ValueError
        If a number is out of range.

    Examples
    --------
    >>> from vibroscope.engine import restitution_of_damping
    >>> round(restitution_of_damping("kelvin-voigt", 1.712, 584.0), 3)
    0.8
    """
    method = ExactPenalty(stiffness, damping, law, exponent, penetration)
    return _given(method, given_gain(method), _mass(mass), _speed(closing_speed))


def damping_of_restitution(
    law: str,
    restitution: float,
    stiffness: float,
    *,
    mass: float = 1.0,
    closing_speed: float = 1.0,
    exponent: float = HERTZ,
    penetration: float | None = None,
) -> float:
    """Return the D with which a contact law really gives a restitution, the inverse of `restitution_of_damping`.

    Parameters
    ----------
    law : str
        One of :data:`engine.CONTACT_LAWS`.
    restitution : float
        e, 0 to 1.
    stiffness, mass, closing_speed, exponent, penetration
        As those of :func:`restitution_of_damping`.

    Raises
    ------
    ValueError
        If a number is out of range, or no D gives so small a restitution.

    Examples
    --------
    >>> from vibroscope.engine import damping_of_restitution
    >>> round(damping_of_restitution("kelvin-voigt", 0.8, 584.0), 3)
    1.712
    >>> round(damping_of_restitution("flores", 0.8, 584.0, closing_speed=2.0), 3)
    54.479
    """
    e = require("restitution", restitution, 0.0, 1.0, "give the restitution that the contact shall have")
    method = ExactPenalty(stiffness, 0.0, law, exponent, penetration)
    mass, speed = _mass(mass), _speed(closing_speed)
    n, power = powers_of(law, exponent)
    length = (mass * speed**2 / method.stiffness) ** (1.0 / (n + 1.0))
    found = _unit_damping(law, e, exponent, None if penetration is None else penetration / length)
    return found * mass * speed / length ** (power + 1.0)


@lru_cache(maxsize=1000)
def _unit_damping(law: str, e: float, exponent: float, penetration: float | None) -> float:
    """D for K, mass and closing speed of one.

    With lengths in (mv₀²/K)^(1/(n + 1)) and times in that length over v₀, every contact is this one, and D that of
    another mass, length and speed: the damper's force cδᵖδ̇ makes it m v₀ over that length to the power p + 1.
    """

    def given(damping: float) -> float:
        return restitution_of_damping(law, damping, 1.0, exponent=exponent, penetration=penetration)

    if given(0.0) <= e:
        return 0.0
    high = 1.0
    while given(high) > e:
        high *= 2.0
        if high > LARGEST_DAMPING:
            raise ValueError(f"restitution = {e:g} is less than any damping gives with law {law!r}: take a larger one")
    return _bisect(lambda damping: given(damping) - e, 0.0, high)


def _given(method: ExactPenalty, gain: float, mass: float, closing: float) -> float:
    """E of a law, Eqs. (28) to (32); ``gain``: c or h, whatever D the method has."""
    law = LAWS[method.law]
    if law.restitution:
        return law.restitution(gain / (2.0 * math.sqrt(method.stiffness * mass)), method.spring_exponent)
    if law.relative:
        return _ratio_law(gain * closing)
    return restitution_by_steps(method, gain, mass, closing)


def _ratio_law(x: float) -> float:
    """E of Eq. (32) with x = hv₀."""
    if x < SMALL_DAMPING:
        return 1.0 - 2.0 * x / 3.0
    wanted = x - math.log1p(x)
    return _bisect(lambda u: wanted + u + math.log1p(-u), 0.0, min(x, 1.0 - 2.0**-53)) / x


def _bisect(f: Callable[[float], float], low: float, high: float) -> float:
    """Zero of a function that falls from f(low) > 0 to f(high) ≤ 0."""
    for _ in range(100):
        middle = 0.5 * (low + high)
        if not low < middle < high:
            break
        low, high = (middle, high) if f(middle) > 0.0 else (low, middle)
    return high


def _speed(value: float) -> float:
    return require("closing_speed", value, *SPEED_RANGE, "give the speed at touch", open_low=True)


def _mass(value: float) -> float:
    return require("mass", value, 1e-12, 1e12, "give the reduced mass, System.mass_share")
