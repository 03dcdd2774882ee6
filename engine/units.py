"""Conversion between the numbers of the model and physical units, as an FE input file needs them.

The model measures time in units of 1/ω₁, length in base amplitudes A and mass in units of m₁ (paper, sections 2
and 3). A quantity of the dimension mass^a · length^b · time^c therefore has the unit

    m₁^a · A^b · ω₁^(−c).

Dampers need a factor of 2 besides. The model writes the damping forces as 2dᵢξᵢ′ and the contact force as
λ = −K g − 2D g′ with the gap g = ξ₂ − ξ₁. The stiffness and the damper (force per speed) of an FE code are hence

    k = K m₁ω₁²,    c = 2D m₁ω₁.
"""

import math
from dataclasses import dataclass, replace
from typing import NamedTuple, TypeVar

import numpy as np

from .methods import Method, Newmark, Reference
from .model import System, check_eta, require
from .result import Impacts, Trajectory

Numbers = TypeVar("Numbers", float, np.ndarray)

OMEGA1_RANGE = (1e-6, 1e9)  # 1/s
M1_RANGE = (1e-9, 1e12)  # kg
BASE_AMPLITUDE_RANGE = (1e-9, 1e6)  # mm


class Quantity(NamedTuple):
    """A physical quantity: its unit, that unit in SI units, its dimension as exponents, and a conventional factor."""

    unit: str
    size: float  # of the unit, in SI units
    mass: int
    length: int
    time: int
    convention: float = 1.0  # factor by which the model's number differs, such as the 2 of 2D


QUANTITIES = {
    "time": Quantity("s", 1.0, 0, 0, 1),
    "angular_frequency": Quantity("1/s", 1.0, 0, 0, -1),
    "frequency": Quantity("Hz", 1.0, 0, 0, -1, 1 / (2 * math.pi)),  # belongs to η, an angular frequency
    "displacement": Quantity("mm", 1e-3, 0, 1, 0),
    "velocity": Quantity("mm/s", 1e-3, 0, 1, -1),
    "acceleration": Quantity("mm/s²", 1e-3, 0, 1, -2),
    "mass": Quantity("kg", 1.0, 1, 0, 0),
    "stiffness": Quantity("N/m", 1.0, 1, 0, -2),
    "damping": Quantity("N·s/m", 1.0, 1, 0, -1, 2.0),  # of D and dᵢ: the force is 2D times the speed
    "force": Quantity("N", 1.0, 1, 1, -2),
    "impulse": Quantity("N·s", 1.0, 1, 1, -1),
    "energy": Quantity("J", 1.0, 1, 2, -2),
    "power": Quantity("W", 1.0, 1, 2, -3),
}


@dataclass(frozen=True)
class Units:
    """The physical units of time, mass and length that the non-dimensional numbers are multiples of.

    Attributes
    ----------
    omega1 : float
        ω₁ in 1/s, angular frequency of pendulum 1 without its damper.
    m1 : float
        m₁ in kg, (modal) mass of pendulum 1.
    base_amplitude : float
        A in mm, amplitude of the base (paper, section 3: 1.07 mm).

    Raises
    ------
    ValueError
        If a value is out of range.
    """

    omega1: float = 1.0
    m1: float = 1.0
    base_amplitude: float = 1.07

    def __post_init__(self):
        for name, allowed, advice in (
            ("omega1", OMEGA1_RANGE, "give the angular frequency ω₁ in 1/s"),
            ("m1", M1_RANGE, "give the mass m₁ in kg"),
            ("base_amplitude", BASE_AMPLITUDE_RANGE, "give the amplitude of the base in mm"),
        ):
            object.__setattr__(self, name, require(name, getattr(self, name), *allowed, advice))

    def factor(self, quantity: str) -> float:
        """Return the physical value of a non-dimensional 1 of this quantity, in the unit that :meth:`unit` names.

        Raises
        ------
        ValueError
            If the quantity is unknown.
        """
        kind = _quantity(quantity)
        si = self.m1**kind.mass * (self.base_amplitude * 1e-3) ** kind.length / self.omega1**kind.time
        return kind.convention * si / kind.size

    def unit(self, quantity: str) -> str:
        """Return the name of the physical unit, such as ``"N/m"``; raises as :meth:`factor`."""
        return _quantity(quantity).unit

    def physical(self, quantity: str, value: Numbers) -> Numbers:
        """Convert a number or an array of the model to physical units; raises as :meth:`factor`."""
        return value * self.factor(quantity)

    def model(self, quantity: str, value: Numbers) -> Numbers:
        """Convert a number or an array in physical units to those of the model; raises as :meth:`factor`."""
        return value / self.factor(quantity)

    def trajectory(self, trajectory: Trajectory) -> Trajectory:
        """Convert a trajectory to s, mm, mm/s and N."""
        return Trajectory(
            time=self.physical("time", trajectory.time),
            displacement=self.physical("displacement", trajectory.displacement),
            velocity=self.physical("velocity", trajectory.velocity),
            force=self.physical("force", trajectory.force),
        )

    def impacts(self, impacts: Impacts) -> Impacts:
        """Convert impacts to s, mm, mm/s and N·s."""
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
        """Return masses in kg, springs in N/m and dampers in N·s/m of both pendulums, as an FE model needs them.

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
            "k1": self.physical("stiffness", 1.0),
            "k2": self.physical("stiffness", mu * kappa**2),
            "c1": self.physical("damping", system.d1),
            "c2": self.physical("damping", mu * system.d2 * kappa),
        }

    def settings(self, eta: float, method: Method) -> dict[str, float]:
        """Return the numbers of an FE input file for one run.

        Parameters
        ----------
        eta : float
            Excitation frequency η = Ω/ω₁.
        method : Reference, ExactPenalty or Newmark

        Returns
        -------
        dict
            ``excitation`` in Hz, ``period`` in s; for the penalty model ``stiffness`` in N/m and ``damping`` in N·s/m;
            for Newmark ``time_step`` in s.

        Raises
        ------
        ValueError
            If η is out of range.
        """
        eta = check_eta(eta)
        period = self.physical("time", 2 * math.pi / eta)
        numbers = {"excitation": self.physical("frequency", eta), "period": period}
        if not isinstance(method, Reference):
            numbers["stiffness"] = self.physical("stiffness", method.stiffness)
            numbers["damping"] = self.physical("damping", method.damping)
        if isinstance(method, Newmark):
            numbers["time_step"] = period / method.steps
        return numbers


def _quantity(name: str) -> Quantity:
    if name not in QUANTITIES:
        raise ValueError(f"quantity = {name!r} is not one of {', '.join(QUANTITIES)}")
    return QUANTITIES[name]
