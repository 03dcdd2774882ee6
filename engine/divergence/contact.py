"""The penalty contact as a damped oscillator: relations between K, D, duration and restitution in closed form.

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

These relations are approximate for the model: the springs and the excitation act during the contact as well, and a time
step resolves it only in part.
"""

import math

import numpy as np

from ..arguments import shown
from ..law_table import restitution_of, restitution_without_pull
from ..methods import Method
from ..model import System
from ..restitution import damping_of_restitution

__all__ = [
    "contact_duration",
    "contact_frequency",
    "damping_for",
    "damping_of_law",
    "damping_ratio",
    "damping_ratio_for",
    "equal_restitution_damping",
    "restitution_of",
    "restitution_without_pull",
    "stiffness_for",
]


def contact_frequency(system: System, stiffness: float) -> float:
    """Return ω_c = √(K(1 + 1/μ)) of a contact."""
    return math.sqrt(stiffness / system.mass_share)


def damping_of_law(system: System, method: Method, stiffness: float, closing_speed: float) -> float:
    """Return the D with which a contact of K and the method's law has the system's restitution, at a closing speed.

    nan where there is none: no closing speed (nan), or a restitution smaller than any damping gives.
    """
    if method.linear:
        return float(equal_restitution_damping(system, stiffness))
    if math.isnan(closing_speed):
        return math.nan
    numbers = method.law_numbers | {"mass": system.mass_share, "closing_speed": closing_speed}
    try:
        return damping_of_restitution(method.law, system.restitution, stiffness, **numbers)
    except ValueError:
        return math.nan


def contact_duration(system: System, method: Method, closing_speed: float | np.ndarray) -> float | np.ndarray:
    """Return how long a contact would last without its damper.

    With a force Kδⁿ, and from ½mv₀² = Kδₘⁿ⁺¹/(n + 1):

    2 (δₘ/v₀) √π Γ(1 + 1/(n + 1))/Γ(½ + 1/(n + 1)),        π/ω_c for n = 1.
    """
    n = method.spring_exponent
    part = 1.0 / (n + 1.0)
    depth = ((n + 1.0) * system.mass_share * closing_speed**2 / (2.0 * method.stiffness)) ** part
    return 2.0 * depth / closing_speed * math.sqrt(math.pi) * math.gamma(1.0 + part) / math.gamma(0.5 + part)


def stiffness_for(system: System, eta: float, steps: int, contact_steps: float) -> float:
    """Return the K whose contact, half an oscillation π/ω_c, lasts ``contact_steps`` steps Δτ = 2π/(ηn).

    Parameters
    ----------
    steps : int
        n, steps per excitation period.
    """
    return system.mass_share * (eta * steps / (2 * contact_steps)) ** 2


def damping_ratio_for(restitution: float) -> float:
    """Return the ζ with e(ζ) = ``restitution``: 0 for 1, and 1 for 0."""
    if restitution in (0, 1):
        return 1.0 - restitution
    logarithm = -math.log(restitution)
    return logarithm / math.hypot(math.pi, logarithm)


def damping_for(system: System, stiffness: float, ratio: float) -> float:
    """Return D = ζ√(Kμ/(1 + μ)), the contact damping of the damping ratio ζ."""
    return ratio * math.sqrt(stiffness * system.mass_share)


def damping_ratio(system: System, stiffness: float, damping: float) -> float:
    """Return ζ = D/√(Kμ/(1 + μ)), the inverse of :func:`damping_for`."""
    return damping / math.sqrt(stiffness * system.mass_share)


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
    return damping_ratio_for(system.restitution) * np.sqrt(stiffness * system.mass_share)
