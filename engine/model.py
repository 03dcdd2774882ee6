"""The system: two neighbouring pendulums on a shaken base (paper, section 2 and Table 1).

Everything is non-dimensional: τ = ω₁t, lengths in base amplitudes, ξ′ = dξ/dτ, excitation period T = 2π/η.
"""

import math
from dataclasses import dataclass, fields

from .arguments import shown

ETA_RANGE = (1e-3, 1e3)


def require(name: str, value: float, low: float, high: float, advice: str, *, open_low=False, open_high=False) -> float:
    """``value`` as float if it is finite and lies between low and high.

    Raises
    ------
    ValueError
        Naming the value, the allowed range and what to do.
    """
    try:
        number = float(value)
    except (TypeError, ValueError, OverflowError):
        number = math.nan
    above = number > low if open_low else number >= low
    below = number < high if open_high else number <= high
    if not (math.isfinite(number) and above and below):
        span = f"{'(' if open_low else '['}{low:g}, {high:g}{')' if open_high else ']'}"
        raise ValueError(f"{name} = {shown(value)} is outside {span}: {advice}")
    return number


def whole(name: str, value: float, low: int, high: int, advice: str) -> int:
    """``value`` as int if it is a whole number between low and high.

    Raises
    ------
    ValueError
        Naming the value, the allowed range and what to do.
    """
    number = require(name, value, low, high, advice)
    if number != int(number):
        raise ValueError(f"{name} = {shown(value)} is not a whole number: {advice}")
    return int(number)


def one_of(name: str, value: str, allowed: tuple[str, ...]) -> str:
    """``value`` if it is one of the texts allowed; else a ValueError names them."""
    if not isinstance(value, str) or value not in allowed:
        raise ValueError(f"{name} = {shown(value)} is not one of {', '.join(allowed)}")
    return value


def flag(name: str, value: bool) -> bool:
    """``value`` as bool if it is True or False, NumPy's included; else a ValueError."""
    if type(value).__name__ not in ("bool", "bool_"):
        raise ValueError(f"{name} = {shown(value)} is not True or False")
    return bool(value)


@dataclass(frozen=True)
class System:
    """Two neighbouring pendulums that can touch (paper, Table 1); all numbers without dimension.

    Attributes
    ----------
    kappa : float
        κ = ω₂/ω₁, frequency ratio of pendulum 2.
    d1, d2 : float
        Damping ratios of the separate pendulums, 0 ≤ d < 1.
    kappa3 : float
        κ₃ = ω₃/ω₁, frequency ratio of the joined pendulums; strictly between 1 and κ.
    d3 : float
        Measured damping ratio of the joined pendulums, 0 ≤ d₃ < 1.
    restitution : float
        Coefficient of restitution e, 0 ≤ e ≤ 1.

    Raises
    ------
    ValueError
        If a value is out of range.
    """

    kappa: float = 2.41
    d1: float = 0.0033
    d2: float = 0.0120
    kappa3: float = 1.80
    d3: float = 0.0330
    restitution: float = 0.5

    def __post_init__(self):
        under = "the pendulums must be underdamped, give a ratio of at least 0 and below 1"
        checked = {
            "kappa": require("kappa", self.kappa, 1e-3, 1e3, "give the frequency ratio ω₂/ω₁"),
            "d1": require("d1", self.d1, 0, 1, under, open_high=True),
            "d2": require("d2", self.d2, 0, 1, under, open_high=True),
            "kappa3": require("kappa3", self.kappa3, 1e-3, 1e3, "give the frequency ratio ω₃/ω₁"),
            "d3": require("d3", self.d3, 0, 1, under, open_high=True),
            "restitution": require("restitution", self.restitution, 0, 1, "give a coefficient of restitution"),
        }
        low, high = sorted((1.0, checked["kappa"]))
        require(
            "kappa3",
            checked["kappa3"],
            low,
            high,
            "joined pendulums swing between the frequencies of the separate ones; the mass ratio follows from it",
            open_low=True,
            open_high=True,
        )
        for name, value in checked.items():
            object.__setattr__(self, name, value)

    @classmethod
    def from_mass_ratio(cls, mass_ratio: float, *, kappa: float = 2.41, **others) -> "System":
        """The system with μ = m₂/m₁ given instead of κ₃: κ₃² = (1 + μκ²)/(1 + μ)."""
        mu = require("mass_ratio", mass_ratio, 1e-9, 1e9, "give m₂/m₁")
        return cls(kappa=kappa, kappa3=math.sqrt((1 + mu * kappa**2) / (1 + mu)), **others)

    @property
    def mass_ratio(self) -> float:
        """μ = m₂/m₁ = (κ₃² − 1)/(κ² − κ₃²): two springs joined on one mass (docs/theory/model.md)."""
        # products, not squares: they keep their digits where the frequencies lie close together
        k, k3 = self.kappa, self.kappa3
        return (k3 - 1) * (k3 + 1) / ((k - k3) * (k + k3))

    @property
    def mass_share(self) -> float:
        """μ/(1 + μ), the reduced mass of the two pendulums in units of m₁."""
        k, k3 = self.kappa, self.kappa3
        return (k3 - 1) * (k3 + 1) / ((k - 1) * (k + 1))

    @property
    def derived_joint_damping(self) -> float:
        """d₃ if the joint held the two dampers and nothing else: (d₁ + μd₂κ)/((1 + μ)κ₃)."""
        mu = self.mass_ratio
        return (self.d1 + mu * self.d2 * self.kappa) / ((1 + mu) * self.kappa3)

    def joint_damping(self, kind: str) -> float:
        """d₃ as measured (``"table"``) or as it follows from the dampers (``"derived"``)."""
        return self.d3 if kind == "table" else self.derived_joint_damping

    def as_dict(self) -> dict[str, float]:
        """The constants by name."""
        return {field.name: getattr(self, field.name) for field in fields(self)}


def check_eta(eta: float) -> float:
    """η as float.

    Raises
    ------
    ValueError
        Outside the allowed range.
    """
    return require("eta", eta, *ETA_RANGE, "give the excitation frequency Ω/ω₁; the paper uses 1.08 to 3.25")
