"""The numbers and properties of each contact law beside K and D, and its damper; all others read this table.

The force of each is in :mod:`.kernels.equations.contact_law`. Where D is given, its damper is c = 2D, or h = 2D/K in
Eq. (18). Where it is not, a formula gives it from the restitution e that is wanted, with the closing speed v₀ at each
touch and the reduced mass m:

    h = 3(1 − e)/(2v₀)                          Hunt & Crossley, J. Appl. Mech. 42 (1975) 440            (22)
    h = 3(1 − e²)/(4v₀)                         Lankarani & Nikravesh, J. Mech. Des. 112 (1990) 369      (23)
    h = 8(1 − e)/(5ev₀)                         Flores et al., Multibody Syst. Dyn. 25 (2011) 357        (24)
    c = √(Km) · 9√5 (1 − e²)/(e(e(9π − 16) + 16))      Jankowski, Earthq. Eng. Struct. Dyn. 35 (2006) 517   (25)
    c = √(Km) · √(2(n + 1)) (−ln e)/√(π² + ln² e)      arXiv 2603.27764; exact, at any v₀                   (26)

(22) to (25) are approximations: :func:`engine.effective_restitution` says what a contact really gives. The damping
ratio ζ = c/(2√(Km)) alone, with φ = arccos ζ, decides it in

    e = exp(−πζ/√(1 − ζ²))                                    "kelvin-voigt"                     (28)
    e = exp(−2ζφ/√(1 − ζ²))                                   "cut"                              (29)
    e = exp(−ζφ/√(1 − ζ²))                                    "compression"                      (30)
    e by (28) with ζ = c/√(2(n + 1)Km)                        "constant-restitution"             (31)

(31) from arXiv 2603.27764.
"""

import math
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from vibroscope.engine.model import System

HERTZ = 1.5
LAW_NUMBERS = "exponent", "penetration", "stiffening"  # beside K and D, by their names in `ExactPenalty`
NEEDED = None  # in place of the default of a number that must be given


def restitution_of(ratio: float) -> float:
    """Return e(ζ) of Eq. (28), the restitution of spring and damper; 0 for ζ ≥ 1."""
    return math.exp(-math.pi * ratio / math.sqrt((1 - ratio) * (1 + ratio))) if ratio < 1 else 0.0


def restitution_without_pull(ratio: float) -> float:
    """Return e(ζ) of Eq. (29), the restitution of spring and damper cut at zero."""
    root = math.sqrt(abs(1 - ratio) * (1 + ratio))
    if root < 1e-6:
        return math.exp(-2.0)
    return math.exp(-2 * ratio * (math.acos(ratio) if ratio < 1 else math.acosh(ratio)) / root)


def ratio_of_restitution(e: float) -> float:
    """Return the ζ with the restitution e by Eq. (28): 0 for 1, and 1 for 0."""
    if e in (0, 1):
        return 1.0 - e
    logarithm = -math.log(e)
    return logarithm / math.hypot(math.pi, logarithm)


def critical_damping(stiffness: float | np.ndarray, mass: float) -> float | np.ndarray:
    """Return √(Km), the D of the damping ratio ζ = 1 of a reduced mass m: D = ζ√(Km)."""
    found = np.sqrt(stiffness * mass)
    return float(found) if np.ndim(found) == 0 else found


def deepest_penetration(
    stiffness: float, mass: float, closing_speed: float | np.ndarray, exponent: float
) -> float | np.ndarray:
    """Return the δₘ that the spring's force Kδⁿ alone stops a reduced mass at: ½mv₀² = Kδₘⁿ⁺¹/(n + 1)."""
    return ((exponent + 1.0) * mass * closing_speed**2 / (2.0 * stiffness)) ** (1.0 / (exponent + 1.0))


def _jankowski(e: float, n: float) -> float:
    return 9.0 * math.sqrt(5.0) * (1.0 - e * e) / (e * (e * (9.0 * math.pi - 16.0) + 16.0))  # Eq. (25)


def _constant_restitution(e: float, n: float) -> float:
    return math.sqrt(2.0 * (n + 1.0)) * ratio_of_restitution(e)  # Eq. (26)


class Law(NamedTuple):
    """Properties of a contact law; those of a linear law that is integrated by steps are the defaults."""

    exponent: float = 1.0  # n of its spring's force Kδⁿ; the default where the law takes n
    takes_exponent: bool = False
    penetration: str = ""  # what happens beyond the penetration that it takes, if it takes one
    takes_stiffening: bool = False  # r, the ratio of its spring's stiffness there to K
    relative: bool = False  # whether its damper is a factor of the spring's force, h = 2D/K, instead of c = 2D
    damper: Callable[[float, float], float] | None = None  # of e and n: hv₀ or c/√(Km), where D is left out
    divides: bool = False  # whether that formula has no value for e = 0
    restitution: Callable[[float, float], float] | None = None  # of ζ and n, which alone decide it
    linear: bool = False  # a spring and a damper as long as the bodies overlap
    closed_form: bool = False  # piecewise linear, with its pieces in kernels/equations/contact_law.py
    graded: bool = False  # whether its damper is c δ^((n − 1)/2) v
    jumps: bool = False  # whether its damper acts in full as soon as the bodies touch
    without_jump: str = ""  # of a law that jumps: the same where the damper grows, if there is such a law
    newmark: bool = False  # taken by `Newmark`, too


_BY_PIECES = Law(closed_form=True, jumps=True, without_jump="limited")
_RATIO = Law(HERTZ, takes_exponent=True, relative=True)
LAWS = {
    "kelvin-voigt": _BY_PIECES._replace(linear=True, newmark=True, restitution=lambda zeta, n: restitution_of(zeta)),
    "cut": _BY_PIECES._replace(newmark=True, restitution=lambda zeta, n: restitution_without_pull(zeta)),
    "limited": Law(closed_form=True),
    "compression": _BY_PIECES._replace(restitution=lambda zeta, n: math.sqrt(restitution_without_pull(zeta))),
    "hunt-crossley": _RATIO._replace(damper=lambda e, n: 1.5 * (1.0 - e)),
    "lankarani-nikravesh": _RATIO._replace(damper=lambda e, n: 0.75 * (1.0 - e * e)),
    "flores": _RATIO._replace(damper=lambda e, n: 1.6 * (1.0 - e) / e, divides=True),
    "jankowski": Law(HERTZ, damper=_jankowski, divides=True, graded=True),
    "constant-restitution": Law(
        HERTZ,
        takes_exponent=True,
        damper=_constant_restitution,
        divides=True,
        restitution=lambda zeta, n: restitution_of(2.0 * zeta / math.sqrt(2.0 * (n + 1.0))),
        graded=True,
    ),
    "impact": Law(HERTZ, takes_exponent=True, penetration="the damper acts in full"),
    "bilinear": Law(closed_form=True, jumps=True, penetration="the spring has the stiffness rK", takes_stiffening=True),
}
LAWS_BY_RESTITUTION = tuple(name for name, law in LAWS.items() if law.damper)
CONTACT_LAWS = tuple(LAWS)
RATIO_LAWS = tuple(name for name, law in LAWS.items() if law.relative)
NEWMARK_LAWS = tuple(name for name, law in LAWS.items() if law.newmark)


def numbers_of(law: str) -> dict[str, float | None]:
    """The numbers that a law takes beside K and D, by their names in `ExactPenalty`, each with its default."""
    own = LAWS[law]
    numbers = {"exponent": own.exponent} if own.takes_exponent else {}
    numbers |= {"penetration": NEEDED} if own.penetration else {}
    return numbers | {"stiffening": NEEDED} if own.takes_stiffening else numbers


def powers_of(law: str, exponent: float) -> tuple[float, float]:
    """The powers of the penetration δ in the spring's force Kδⁿ and in the damper's, of a law with this exponent n.

    A law that takes no exponent has its own n, whatever is given.
    """
    own = LAWS[law]
    n = exponent if own.takes_exponent else own.exponent
    return n, n if own.relative else (n - 1.0) / 2.0 if own.graded else 0.0


def laws_with(number: str) -> tuple[str, ...]:
    """The laws that take a number of :data:`LAW_NUMBERS`."""
    return tuple(law for law in LAWS if number in numbers_of(law))


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
    return (factor, True) if own.relative else (factor * critical_damping(stiffness, mass), False)
