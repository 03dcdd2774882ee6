"""Conversion between the numbers of the model and physical units, as an FE input file needs them.

An FE code has no units: an input file holds numbers of one consistent system, in which force = mass · length / time².
Two systems are in use: SI (m, kg, s, N), and mm-t-s (mm, t, s, N), where stiffnesses are in N/mm.

The model measures time in units of 1/ω₁, length in base amplitudes A_b and mass in units of m₁ (paper, sections 2
and 3). A quantity of the dimension mass^a · length^b · time^c therefore has the unit

    m₁^a · A_b^b · ω₁^(−c).

Dampers need a factor of 2 besides. The model writes the damping forces as 2dᵢξᵢ′ and the contact force as
λ = −K g − 2D g′ with the gap g = ξ₂ − ξ₁. The stiffness and the damper (force per speed) of an FE code are hence

    k = K m₁ω₁²,    c = 2D m₁ω₁.

In a law whose spring has the force Kδⁿ and whose damper 2D δᵐ v, with the penetration δ and its rate v, they are a
force per length to the power n and a force per speed and length to the power m:

    k = K m₁ω₁² A_b^(1−n),    c = 2D m₁ω₁ A_b^(−m),

m = n of Eq. (18), where 2D = hK; (n − 1)/2 of Eqs. (19) and (20); 0 of all others.
"""

import math
import re
from dataclasses import dataclass, replace
from decimal import Decimal
from typing import NamedTuple, TypeVar

import numpy as np
from vibroscope.engine.arguments import one_of
from vibroscope.engine.fields import Range, check_numbers, described
from vibroscope.engine.law_table import CONTACT_LAWS, HERTZ, powers_of
from vibroscope.engine.methods import Method
from vibroscope.engine.model import System, check_eta
from vibroscope.engine.result import Impacts, Trajectory

Numbers = TypeVar("Numbers", float, np.ndarray)

_PLAIN = (1e-4, 1e7)  # numbers that are written without a power of ten
_TIMES = ((1e-6, "µs"), (1e-3, "ms"), (1.0, "s"))
OMEGA1_RANGE = (1e-6, 1e9)  # 1/s
M1_RANGE = (1e-15, 1e12)  # kg
BASE_AMPLITUDE_RANGE = (1e-9, 1e6)  # mm


UNIT_SYSTEMS = {"si": "SI (m, kg, s, N)", "mm-t-s": "mm-t-s (mm, t, s, N)"}
_BASE = {"si": (1.0, 1.0), "mm-t-s": (1e3, 1e-3)}  # units of mass and length in SI units; that of time is the second


class Quantity(NamedTuple):
    """A physical quantity: its unit in each of `UNIT_SYSTEMS`, dimension as exponents, and a conventional factor."""

    units: tuple[str, str]
    mass: int
    length: float
    time: int
    convention: float = 1.0  # factor by which the model's number differs, such as the 2 of 2D


QUANTITIES = {
    "time": Quantity(("s", "s"), 0, 0, 1),
    "angular_frequency": Quantity(("1/s", "1/s"), 0, 0, -1),
    "frequency": Quantity(("Hz", "Hz"), 0, 0, -1, 1 / (2 * math.pi)),  # belongs to η, an angular frequency
    "displacement": Quantity(("m", "mm"), 0, 1, 0),
    "area": Quantity(("m²", "mm²"), 0, 2, 0),
    "velocity": Quantity(("m/s", "mm/s"), 0, 1, -1),
    "acceleration": Quantity(("m/s²", "mm/s²"), 0, 1, -2),
    "mass": Quantity(("kg", "t"), 1, 0, 0),
    "stiffness": Quantity(("N/m", "N/mm"), 1, 0, -2),
    "damping": Quantity(("N·s/m", "N·s/mm"), 1, 0, -1, 2.0),  # of d₁ and μκd₂: the force is 2d₁ times the speed
    # of K and D; of a law that is not linear, `Units` has other ones
    "contact_stiffness": Quantity(("N/m", "N/mm"), 1, 0, -2),
    "contact_damping": Quantity(("N·s/m", "N·s/mm"), 1, 0, -1, 2.0),
    "force": Quantity(("N", "N"), 1, 1, -2),
    "impulse": Quantity(("N·s", "N·s"), 1, 1, -1),
    "energy": Quantity(("J", "mJ"), 1, 2, -2),
}


@dataclass(frozen=True)
class Units:
    """The physical units of time, mass and length that the non-dimensional numbers are multiples of.

    Attributes
    ----------
    omega1 : float
        ω₁ in 1/s, angular frequency of pendulum 1 without its damper; without its spring 1 over the unit of time.
    m1 : float
        m₁ in kg, (modal) mass of pendulum 1.
    base_amplitude : float
        A_b in mm, amplitude of the base (paper, section 3: 1.07 mm).
    system : {"si", "mm-t-s"}
        Units of the results; the three numbers above are in 1/s, kg and mm in any case.
    law : str
        Contact law whose K and D are converted; :meth:`of_contact` takes that of a method.
    exponent : float
        n of its spring, where the law takes it.

    Raises
    ------
    ValueError
        If a value is out of range, or the system is unknown.

    Examples
    --------
    >>> from vibroscope.engine import Units
    >>> units = Units(omega1=62.8, m1=25.0, base_amplitude=0.25)
    >>> round(units.model("stiffness", 5.76e7)), round(units.physical("damping", 2.0))
    (584, 6280)
    >>> units.text("force", 1.0)
    '24.65 N'
    >>> Units(law="hunt-crossley").unit("contact_stiffness"), Units(law="hunt-crossley").unit("contact_damping")
    ('N/m^1.5', 'N·s/m^2.5')
    """

    omega1: float = described(
        *(1.0, "angular frequency of body 1", "1/s", Range(*OMEGA1_RANGE)),
        "give the angular frequency ω₁ in 1/s",
    )
    m1: float = described(1.0, "mass of body 1", "kg", Range(*M1_RANGE), "give the mass m₁ in kg")
    base_amplitude: float = described(
        *(1.07, "unit of length: amplitude of the base, if it moves", "mm", Range(*BASE_AMPLITUDE_RANGE)),
        "give the amplitude of the base in mm",
    )
    system: str = "si"
    law: str = CONTACT_LAWS[0]
    exponent: float = HERTZ

    def __post_init__(self):
        one_of("system", self.system, tuple(UNIT_SYSTEMS))
        one_of("law", self.law, CONTACT_LAWS)
        check_numbers(self)

    def of_contact(self, method: Method) -> "Units":
        """The same units, in which K and D are those of the contact law of a method."""
        return self if method.rigid else replace(self, law=method.law, exponent=method.exponent)

    def quantity(self, name: str) -> Quantity:
        """The quantity of this name, K and D (``"contact_stiffness"``, ``"contact_damping"``) those of the law.

        Raises
        ------
        ValueError
            If the quantity is unknown.
        """
        kind = QUANTITIES[one_of("quantity", name, tuple(QUANTITIES))]
        if not name.startswith("contact_"):
            return kind
        spring, damper = powers_of(self.law, self.exponent)
        power = spring - 1.0 if name == "contact_stiffness" else damper  # of length, beyond that of a linear law
        if not power:
            return kind
        return kind._replace(units=tuple(f"{unit}^{1.0 + power:.6g}" for unit in kind.units), length=-power)

    def factor(self, quantity: str) -> float:
        """Return the physical value of a non-dimensional 1 of this quantity, in the unit that :meth:`unit` names.

        Raises
        ------
        ValueError
            If the quantity is unknown.
        """
        kind = self.quantity(quantity)
        mass, length = _BASE[self.system]
        scale = (self.m1 / mass) ** kind.mass * (self.base_amplitude * 1e-3 / length) ** kind.length
        return kind.convention * scale / self.omega1**kind.time

    def unit(self, quantity: str) -> str:
        """Return the name of the physical unit, such as ``"N/m"``; raises as :meth:`factor`."""
        return self.quantity(quantity).units[list(UNIT_SYSTEMS).index(self.system)]

    def text(self, quantity: str, value: float, digits: int = 4) -> str:
        """Write a number of the model in physical units, with its unit; raises as :meth:`factor`."""
        return f"{written(self.physical(quantity, value), digits)} {self.unit(quantity)}"

    def physical(self, quantity: str, value: Numbers) -> Numbers:
        """Convert a number or an array of the model to physical units; raises as :meth:`factor`."""
        return value * self.factor(quantity)

    def model(self, quantity: str, value: Numbers) -> Numbers:
        """Convert a number or an array in physical units to those of the model; raises as :meth:`factor`."""
        return value / self.factor(quantity)

    def trajectory(self, trajectory: Trajectory) -> Trajectory:
        """Convert a trajectory to units of time, length, velocity and force."""
        return Trajectory(
            time=self.physical("time", trajectory.time),
            displacement=self.physical("displacement", trajectory.displacement),
            velocity=self.physical("velocity", trajectory.velocity),
            force=self.physical("force", trajectory.force),
        )

    def impacts(self, impacts: Impacts) -> Impacts:
        """Convert impacts to units of time, length, velocity and impulse."""
        return replace(
            impacts,
            time=self.physical("time", impacts.time),
            position=self.physical("displacement", impacts.position),
            velocity_before=self.physical("velocity", impacts.velocity_before),
            velocity_after=self.physical("velocity", impacts.velocity_after),
            impulse=self.physical("impulse", impacts.impulse),
            closing_speed=self.physical("velocity", impacts.closing_speed),
        )

    def pendulums(self, system: System) -> dict[str, float]:
        """Return masses, springs and dampers of both pendulums, as an FE model needs them.

        The equations of motion are mᵢẍᵢ + cᵢẋᵢ + kᵢxᵢ = mᵢAΩ² cos Ωt ∓ F, with x relative to the base and the
        contact force F.

        Returns
        -------
        dict
            ``m1``, ``m2``, ``k1``, ``k2``, ``c1``, ``c2``.
        """
        mu, kappa = system.mass_ratio, system.kappa
        return {
            "m1": self.physical("mass", 1.0),
            "m2": self.physical("mass", mu),
            "k1": self.physical("stiffness", system.spring1),
            "k2": self.physical("stiffness", mu * kappa**2),
            "c1": self.physical("damping", system.d1),
            "c2": self.physical("damping", mu * system.damper2),
        }

    def settings(self, eta: float, method: Method) -> dict[str, float]:
        """Return the numbers of an FE input file for one run.

        Parameters
        ----------
        eta : float
            Excitation frequency η = Ω/ω₁.
        method : Method

        Returns
        -------
        dict
            ``excitation`` in Hz, ``period`` in s; for the penalty model ``stiffness``, and ``damping`` unless it
            follows from the restitution; with a time step ``time_step`` in s.

        Raises
        ------
        ValueError
            If η is out of range.
        """
        eta = check_eta(eta)
        period = self.physical("time", 2 * math.pi / eta)
        numbers = {"excitation": self.physical("frequency", eta), "period": period}
        if not method.rigid:
            contact = self.of_contact(method)
            numbers["stiffness"] = contact.physical("contact_stiffness", method.stiffness)
            if method.damping is not None:
                numbers["damping"] = contact.physical("contact_damping", method.damping)
        if method.has_step:
            numbers["time_step"] = period / method.steps
        return numbers


def written(value: float, digits: int = 4) -> str:
    """A number with so many significant digits, such as "0.0153", "2400" or "1.2e-5"; with units or without them.

    Examples
    --------
    >>> from vibroscope.engine import written
    >>> written(12000.0), written(1.5e-7), written(1234567.0)
    ('12000', '1.5e-7', '1235000')
    """
    text = f"{value:.{digits}g}"
    size = abs(float(text))
    if size == 0 or _PLAIN[0] <= size < _PLAIN[1]:
        plain = format(Decimal(text), "f")
        return plain.rstrip("0").rstrip(".") if "." in plain else plain
    return re.sub(r"e\+?(-?)0*", r"e\1", text)


def time_text(seconds: float) -> str:
    """A time in the unit that suits it, as in "25 µs"."""
    size, unit = next(((size, unit) for size, unit in _TIMES if abs(seconds) < 1e3 * size), _TIMES[-1])
    return f"{written(seconds / size)} {unit}"
