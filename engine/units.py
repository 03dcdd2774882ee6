"""Physical units: the same numbers as they go into an FE input file, and back.

The model counts time in 1/ω₁, length in base amplitudes A and mass in m₁ (paper, sections 2 and 3). A quantity of the
dimension mass^a · length^b · time^c therefore has the unit

    m₁^a · A^b · ω₁^(−c).

One convention comes on top: the contact force is λ = Kg + 2Dg′ (g the penetration here), as the pendulums' dampers
are 2dᵢ. The damper that an FE code wants, in force per speed, is hence 2D of these units:

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
    """A kind of number: its unit outside, the size of that unit in SI, its dimension, and what convention adds."""

    unit: str
    size: float
    mass: int
    length: int
    time: int
    convention: float = 1.0


QUANTITIES = {
    "time": Quantity("s", 1.0, 0, 0, 1),
    "angular_frequency": Quantity("1/s", 1.0, 0, 0, -1),
    "frequency": Quantity("Hz", 1.0, 0, 0, -1, 1 / (2 * math.pi)),  # of η, which is an angular frequency
    "displacement": Quantity("mm", 1e-3, 0, 1, 0),
    "velocity": Quantity("mm/s", 1e-3, 0, 1, -1),
    "acceleration": Quantity("mm/s²", 1e-3, 0, 1, -2),
    "mass": Quantity("kg", 1.0, 1, 0, 0),
    "stiffness": Quantity("N/m", 1.0, 1, 0, -2),
    "damping": Quantity("N·s/m", 1.0, 1, 0, -1, 2.0),  # D and dᵢ: the force is 2D times the speed
    "force": Quantity("N", 1.0, 1, 1, -2),
    "impulse": Quantity("N·s", 1.0, 1, 1, -1),
    "energy": Quantity("J", 1.0, 1, 2, -2),
    "power": Quantity("W", 1.0, 1, 2, -3),
}


@dataclass(frozen=True)
class Units:
    """What the non-dimensional numbers are counted in.

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
        for name, span, advice in (
            ("omega1", OMEGA1_RANGE, "give the angular frequency ω₁ in 1/s"),
            ("m1", M1_RANGE, "give the mass m₁ in kg"),
            ("base_amplitude", BASE_AMPLITUDE_RANGE, "give the amplitude of the base in mm"),
        ):
            object.__setattr__(self, name, require(name, getattr(self, name), *span, advice))

    def factor(self, quantity: str) -> float:
        """What one non-dimensional unit of the quantity is, in the unit that :meth:`unit` names.

        Raises
        ------
        ValueError
            If there is no such quantity.
        """
        q = _quantity(quantity)
        si = self.m1**q.mass * (self.base_amplitude * 1e-3) ** q.length / self.omega1**q.time
        return q.convention * si / q.size

    def unit(self, quantity: str) -> str:
        """Name of the physical unit, such as ``"N/m"``; ValueError as for :meth:`factor`."""
        return _quantity(quantity).unit

    def physical(self, quantity: str, value: Numbers) -> Numbers:
        """The number, or array of numbers, in physical units; ValueError as for :meth:`factor`."""
        return value * self.factor(quantity)

    def model(self, quantity: str, value: Numbers) -> Numbers:
        """The way back, from physical units to those of the model; ValueError as for :meth:`factor`."""
        return value / self.factor(quantity)

    def trajectory(self, trajectory: Trajectory) -> Trajectory:
        """The same samples in s, mm, mm/s and N."""
        return Trajectory(
            time=self.physical("time", trajectory.time),
            displacement=self.physical("displacement", trajectory.displacement),
            velocity=self.physical("velocity", trajectory.velocity),
            force=self.physical("force", trajectory.force),
        )

    def impacts(self, impacts: Impacts) -> Impacts:
        """The same impacts in s, mm, mm/s and N·s."""
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
        """Masses in kg, springs in N/m and dampers in N·s/m of the two pendulums, as an FE model needs them.

        They obey mᵢẍᵢ + cᵢẋᵢ + kᵢxᵢ = mᵢAΩ² cos Ωt ∓ F, x relative to the base.

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
        """The numbers of an FE input file for one run.

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
        eta = check_eta(eta, System())
        period = self.physical("time", 2 * math.pi / eta)
        found = {"excitation": self.physical("frequency", eta), "period": period}
        if not isinstance(method, Reference):
            found["stiffness"] = self.physical("stiffness", method.stiffness)
            found["damping"] = self.physical("damping", method.damping)
        if isinstance(method, Newmark):
            found["time_step"] = period / method.steps
        return found


def _quantity(name: str) -> Quantity:
    if name not in QUANTITIES:
        raise ValueError(f"quantity = {name!r} is not one of {', '.join(QUANTITIES)}")
    return QUANTITIES[name]
