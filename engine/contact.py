"""A contact alone: relations between mass, K, D, law and closing speed, and duration, penetration and restitution.

While the pendulums touch and no other force acts, the gap g obeys

    g″ + 2D(1 + 1/μ) g′ + K(1 + 1/μ) g = 0,

an oscillation of frequency ω_c = √(K(1 + 1/μ)) and damping ratio ζ = D(1 + 1/μ)/ω_c = D/√(Kμ/(1 + μ)). A contact that
begins with the closing speed v has, with ω_d = ω_c √(1 − ζ²), the penetration −g = (v/ω_d) exp(−ζω_c t) sin ω_d t.

*Restitution.* The paper's contact ends when g = 0, at ω_d t = π, with g′ = e(ζ) v,

    e(ζ) = exp(−πζ/√(1 − ζ²)).

For ζ ≥ 1 the gap creeps back and e(ζ) = 0.

*Pulling.* Before that, from where g″ = 0 on, the contact force λ = μ/(1 + μ)·g″ is negative: the damper pulls. With
ζ = sin φ, g″ = 0 reads tan ω_d t = −tan 2φ, so that ω_d t = π − 2φ, and there g′ = e°(ζ) v with

    e°(ζ) = exp(−ζ (π − 2 arcsin ζ)/√(1 − ζ²)),        exp(−2ζ arcosh ζ/√(ζ² − 1)) for ζ > 1          (54)

A contact that ended where its force vanishes would deliver e° > e(ζ) (Schwager and Pöschel, Granular Matter 9 (2007)
465).

*Equal restitution.* e(ζ) = e gives ζ(e) = −ln e/√(π² + ln² e) and

    D = ζ(e) √(Kμ/(1 + μ))                                                                        (55)

*Other laws.* Two bodies with the reduced mass m close with the speed v₀. Where the damping ratio alone decides the
restitution, Eqs. (28) to (31) of :mod:`.law_table` give it. In Eq. (18)

    hv₀ − ln(1 + hv₀) = −hev₀ − ln(1 − hev₀)                  for any K, n and m                 (32)

by separating the variables of mv dv = −Kδⁿ(1 + hv) dδ. The other laws are integrated
(:mod:`.kernels.event_driven.law_contact`).

These relations are approximate for the model: the springs and the excitation act during the contact as well, and a time
step resolves it only in part.
"""

import math
from collections.abc import Callable, Sequence
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from vibroscope.engine.arguments import require, shown, whole
from vibroscope.engine.drivers.alone import parameters_alone, restitution_alone
from vibroscope.engine.law_table import (
    HERTZ,
    LAWS,
    critical_damping,
    damper_of,
    deepest_penetration,
    given_gain,
    powers_of,
    ratio_of_restitution,
)
from vibroscope.engine.methods import STEPS_RANGE, ExactPenalty, Method, TimeStepping, contact_ranges
from vibroscope.engine.model import System, check_eta

SPEED_RANGE = (0.0, 1e9)
STEP_SCALE_RANGE = (0.0, 1e6)  # of s in K = s m/Δτ², 0 excluded
SMALL_DAMPING = 1e-5  # hv₀ below which e = 1 − 2hv₀/3 to rounding
LARGEST_DAMPING = 1e6  # damping tried, in units of √(Km)


class ContactUnits(NamedTuple):
    """Units in which mass, closing speed and stiffness of a contact are one: so is every contact one of these."""

    mass: float
    speed: float
    stiffness: float
    exponent: float  # n of its spring

    @property
    def length(self) -> float:
        """(mv₀²/K)^(1/(n + 1))."""
        return (self.mass * self.speed**2 / self.stiffness) ** (1.0 / (self.exponent + 1.0))

    @property
    def time(self) -> float:
        """Length over closing speed."""
        return self.length / self.speed

    @property
    def force(self) -> float:
        """mv₀² over length."""
        return self.mass * self.speed**2 / self.length

    def damping(self, law: str, exponent: float) -> float:
        """D of a damper whose force is 2Dδᵖδ̇: mv₀ over length to the power p + 1."""
        return self.mass * self.speed / self.length ** (powers_of(law, exponent)[1] + 1.0)


# --- how long it lasts ------------------------------------------------------------------------------------------------


def contact_frequency(system: System, stiffness: float) -> float:
    """Return ω_c = √(K(1 + 1/μ)) of a contact."""
    return math.sqrt(stiffness / system.mass_share)


def spring_duration(mass: float, method: Method, closing_speed: float | np.ndarray) -> float | np.ndarray:
    """Return how long a contact of a reduced mass would last without its damper.

    With a force Kδⁿ, whose deepest penetration is δₘ,

    2 (δₘ/v₀) √π Γ(1 + 1/(n + 1))/Γ(½ + 1/(n + 1)),        π/ω_c for n = 1.

    With the stiffness rK beyond d, it takes asin(ω_c d/v₀)/ω_c to the knee and from there, with the speed v_d,
    atan2(√r v_d, ω_c d)/(√r ω_c) to the turn, and as long back.
    """
    if method.stiffening is not None:
        omega, root = math.sqrt(method.stiffness / mass), math.sqrt(method.stiffening)
        knee = np.minimum(omega * method.penetration / closing_speed, 1.0)  # over the speed
        inner = np.arctan2(root * np.sqrt((1.0 - knee) * (1.0 + knee)), knee) / root
        return 2.0 * (np.arcsin(knee) + inner) / omega
    n = method.spring_exponent
    part, depth = 1.0 / (n + 1.0), deepest_penetration(method.stiffness, mass, closing_speed, n)
    return 2.0 * depth / closing_speed * math.sqrt(math.pi) * math.gamma(1.0 + part) / math.gamma(0.5 + part)


def contact_time(mass: float, method: Method, closing_speed: float) -> float:
    """Return how long a contact lasts, as steps in it are counted.

    The half cycle of the damped contact π/(ω_c√(1 − ζ²)) of a linear spring; of other laws, and where the gap creeps
    back, that of the spring alone.
    """
    alone, ratio = spring_duration(mass, method, closing_speed), ratio_of_method(mass, method)
    damped = method.spring_exponent == 1.0 and ratio < 1.0
    return alone / math.sqrt((1 - ratio) * (1 + ratio)) if damped else alone


def spring_energy(method: Method, gap: np.ndarray) -> np.ndarray:
    """Energy that the contact spring stores at each gap, Kδⁿ⁺¹/(n + 1), of Eq. (60) ½(r − 1)K(δ − d)² more beyond d."""
    n = method.spring_exponent
    stored = method.stiffness * np.maximum(-gap, 0.0) ** (n + 1.0) / (n + 1.0)
    if method.stiffening is None:
        return stored
    beyond = np.maximum(-gap - method.penetration, 0.0)
    return stored + 0.5 * (method.stiffening - 1.0) * method.stiffness * beyond**2


def stiffness_for(system: System, eta: float, steps: int, contact_steps: float) -> float:
    """Return the K whose contact, half an oscillation π/ω_c, lasts ``contact_steps`` steps Δτ = 2π/(ηn).

    Parameters
    ----------
    steps : int
        n, steps per excitation period.
    """
    return system.mass_share * (eta * steps / (2 * contact_steps)) ** 2


def stiffness_of_step(system: System, eta: float, steps: float, scale: float) -> float:
    """Return K = s m/Δτ², the contact stiffness that follows the step Δτ = 2π/(ηn), as with SOFT = 1 in LS-DYNA.

    Half the step gives four times K: with a smaller step it is another model. m is the mass of the lighter body, and s
    = SOFSCL, 0.1 by default (FAQ of LSTC, contact.soft1: m* = min(m_master_nodes, m_slave_node)).

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
    4208
    """
    step = 2.0 * math.pi / check_eta(eta) / whole("steps", steps, *STEPS_RANGE, "give steps per excitation period")
    why = "give the share s of m/Δτ², 0.05 to 1 in codes"
    s = require("stiffness_of_step", scale, *STEP_SCALE_RANGE, why, open_low=True)
    return s * system.lighter_mass / step**2


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


# --- spring and damper ------------------------------------------------------------------------------------------------


def damping_for(system: System, stiffness: float | np.ndarray, ratio: float) -> float | np.ndarray:
    """Return D = ζ√(Kμ/(1 + μ)), the contact damping of the damping ratio ζ."""
    return ratio * critical_damping(stiffness, system.mass_share)


def damping_ratio(system: System, stiffness: float, damping: float) -> float:
    """Return ζ = D/√(Kμ/(1 + μ)), the inverse of :func:`damping_for`."""
    return damping / critical_damping(stiffness, system.mass_share)


def ratio_of_method(mass: float, method: Method) -> float:
    """Return ζ = D/√(Km); nan of a law whose spring or damper is none that is constant, or without a D."""
    if method.damping is None or powers_of(method.law, method.exponent) != (1.0, 0.0):
        return math.nan
    return method.damping / critical_damping(method.stiffness, mass)


def equal_restitution_damping(system: System, stiffness: float | np.ndarray) -> float | np.ndarray:
    """Return the D with which a contact of stiffness K has the system's restitution: e(ζ) = e.

    Parameters
    ----------
    system : System
    stiffness : float or (n,) ndarray
        K of the spring and damper of the paper; other laws: :func:`engine.damping_of_restitution`.

    Returns
    -------
    float or (n,) ndarray

    Raises
    ------
    ValueError
        If K is no number, negative or infinite.

    Examples
    --------
    >>> from vibroscope.engine import System, equal_restitution_damping
    >>> round(float(equal_restitution_damping(System(wall=True, restitution=0.8), 584.0)), 3)
    1.712
    """
    try:
        known = np.isfinite(stiffness) & (np.asarray(stiffness) >= 0)
    except (TypeError, OverflowError):
        known = np.array(False)
    if not known.all():
        raise ValueError(f"K = {shown(stiffness)} is no contact stiffness: give positive numbers")
    return damping_for(system, stiffness, ratio_of_restitution(system.restitution))


# --- any law ----------------------------------------------------------------------------------------------------------


def effective_restitution(
    system: System, method: ExactPenalty | TimeStepping, closing_speed: float | Sequence[float]
) -> float | np.ndarray:
    """Return the restitution that a contact of this method gives, at one closing speed or at many.

    Where D is None it is what the law's formula makes of the restitution that it promises, ``system.restitution``.

    Parameters
    ----------
    system : System
    method : ExactPenalty or TimeStepping
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
    speeds = [check_speed(each) for each in np.atleast_1d(np.asarray(closing_speed, dtype=object))]
    found = [_given(contact, gain / v if relative else gain, system.mass_share, v) for v in speeds]
    return found[0] if np.ndim(closing_speed) == 0 else np.array(found)


def restitution_of_units(method: ExactPenalty, asked: float) -> float:
    """The same where mass, K and closing speed are one; ``asked``: of which the law makes a damper that is left out."""
    return effective_restitution(System(wall=True, restitution=asked), method, 1.0)


def restitution_of_damping(
    law: str,
    damping: float,
    stiffness: float,
    *,
    mass: float = 1.0,
    closing_speed: float = 1.0,
    exponent: float = HERTZ,
    penetration: float | None = None,
    stiffening: float | None = None,
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
    exponent, penetration, stiffening
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
    method = ExactPenalty(stiffness, damping, law, exponent, penetration, stiffening)
    return _given(method, given_gain(method), check_mass(mass), check_speed(closing_speed))


def damping_of_restitution(
    law: str,
    restitution: float,
    stiffness: float,
    *,
    mass: float = 1.0,
    closing_speed: float = 1.0,
    exponent: float = HERTZ,
    penetration: float | None = None,
    stiffening: float | None = None,
) -> float:
    """Return the D with which a contact law really gives a restitution, the inverse of `restitution_of_damping`.

    Parameters
    ----------
    law : str
        One of :data:`engine.CONTACT_LAWS`.
    restitution : float
        e, 0 to 1.
    stiffness, mass, closing_speed, exponent, penetration, stiffening
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
    method = ExactPenalty(stiffness, 0.0, law, exponent, penetration, stiffening)
    units = ContactUnits(check_mass(mass), check_speed(closing_speed), method.stiffness, method.spring_exponent)
    found = _unit_damping(law, e, exponent, None if penetration is None else penetration / units.length, stiffening)
    return found * units.damping(law, exponent)


def equal_damping(system: System, method: Method, stiffness: float, closing_speed: float) -> float:
    """Return D_e(K), with which a contact of K and the method's law has the restitution of the reference, Eq. (55).

    nan where there is none: the law takes its damper from the restitution, nothing collides so that there is no closing
    speed (nan), or the restitution is smaller than any damping gives.
    """
    if method.damping is None:
        return math.nan
    if method.linear:
        return equal_restitution_damping(system, stiffness)
    if math.isnan(closing_speed):
        return math.nan
    numbers = method.law_numbers | {"mass": system.mass_share, "closing_speed": closing_speed}
    try:
        return damping_of_restitution(method.law, system.restitution, stiffness, **numbers)
    except ValueError:
        return math.nan


def equal_stiffness(system: System, method: Method, closing_speed: float) -> float:
    """Return K_e(D), the inverse of :func:`equal_damping`: (D/ζ(e))²(1 + 1/μ) of the first law.

    nan where there is none within the range of K. D_e(K) is a power of K for every law whose numbers K and D scale
    alone; of the others it is nearly one, so that the power is found again from where it leads.
    """
    if not method.damping:
        return math.nan
    stiffness, (least, most) = method.stiffness, contact_ranges(method.law)[0]
    for _ in range(4):
        here, there = (equal_damping(system, method, factor * stiffness, closing_speed) for factor in (1.0, 2.0))
        if not (here > 0.0 and there > here):
            return math.nan
        stiffness *= (method.damping / here) ** (1.0 / math.log2(there / here))
        if not least <= stiffness <= most / 2:
            return math.nan
    return stiffness


@lru_cache(maxsize=1000)
def _unit_damping(law: str, e: float, exponent: float, penetration: float | None, stiffening: float | None) -> float:
    """D for K, mass and closing speed of one."""
    if LAWS[law].linear:
        return ratio_of_restitution(e)

    def given(damping: float) -> float:
        numbers = {"exponent": exponent, "penetration": penetration, "stiffening": stiffening}
        return restitution_of_damping(law, damping, 1.0, **numbers)

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
        return law.restitution(0.5 * gain / critical_damping(method.stiffness, mass), method.spring_exponent)
    if law.relative:
        return _ratio_law(gain * closing)
    if gain == 0.0:  # no damper, no loss
        return 1.0
    alone = parameters_alone(method)._replace(gain=gain, mu=mass)
    return min(restitution_alone(alone, closing), 1.0)  # but for rounding


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


def check_speed(value: float) -> float:
    """The closing speed as a number; raises ValueError where it is none or not positive."""
    return require("closing_speed", value, *SPEED_RANGE, "give the speed at touch", open_low=True)


def check_mass(value: float) -> float:
    """The reduced mass as a number; raises ValueError where it is none or out of range."""
    return require("mass", value, 1e-12, 1e12, "give the reduced mass of the two bodies, m1 m2/(m1 + m2)")
