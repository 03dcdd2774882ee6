"""The numbers of a deck in one consistent system of units, whatever code it is for. No solver is needed."""

import math
from dataclasses import dataclass, replace
from functools import cached_property
from importlib.metadata import version
from types import ModuleType
from typing import NamedTuple

from vibroscope.app.export.scripts import initial_option, penalty_options, system_file_text
from vibroscope.app.runtime.number_text import print_number
from vibroscope.engine import (
    CONTACT_LAWS,
    CONTACT_STATUSES,
    Status,
    System,
    TimeStepping,
    Units,
    simulate,
    with_located_steps,
)
from vibroscope.engine.arguments import whole
from vibroscope.engine.integrators import Integrator
from vibroscope.engine.model import check_eta

PERIODS, KEEP = 300, 20  # to run, and to write the last of
PERIODS_RANGE = (1, 1_000_000)
SAMPLES = 200  # a period, at most
LINEAR = CONTACT_LAWS[0]  # a spring and a damper
_PLAIN = Units(omega1=1.0, m1=1.0, base_amplitude=1e3, system="si")  # in which every number stays as it is


class Load(NamedTuple):
    """The force cosine · cos Ωt + sine · sin Ωt + constant."""

    cosine: float
    sine: float
    constant: float

    def __add__(self, other: "Load") -> "Load":
        return Load(*(one + another for one, another in zip(self, other, strict=True)))


class Body(NamedTuple):
    """A mass, its spring and damper to the base, what drives it, and how it starts."""

    mass: float
    stiffness: float
    damping: float
    load: Load
    displacement: float
    velocity: float

    @property
    def load_from_start(self) -> Load:
        """The load where displacements are counted from the start, with the force that the spring has there."""
        return self.load._replace(constant=self.load.constant - self.stiffness * self.displacement)


@dataclass(frozen=True)
class DeckProblem:
    """System, method and duration of the run that a deck describes.

    Attributes
    ----------
    system : System
    eta : float
    method : TimeStepping
        The contact's numbers and law, the time step, the integrator and the contact status. That from the start of the
        step, the default, which no deck has, leaves the status to the code.
    units : Units, optional
        Units of the deck; None: without dimension, ω₁ = 1 rad/s, the unit of length 1 and m₁ = 1.
    initial : tuple of float, optional
        ξ₁, ξ₁′, ξ₂, ξ₂′ at τ = 0; by default the static equilibrium.
    periods, keep : int
        Excitation periods to run, and the last of them to write.
    name : str
        Of the deck's file without its suffix, which its comments mention.

    Raises
    ------
    ValueError
        If a number is out of range.
    """

    system: System
    eta: float
    method: TimeStepping
    units: Units | None = None
    initial: tuple[float, float, float, float] | None = None
    periods: int = PERIODS
    keep: int = KEEP
    name: str = "two_bodies"

    def __post_init__(self):
        check_eta(self.eta)
        advice = "give the excitation periods to run"
        object.__setattr__(self, "periods", whole("periods", self.periods, *PERIODS_RANGE, advice))
        advice = "give the last periods to write, at most those that are run"
        object.__setattr__(self, "keep", whole("keep", self.keep, 1, self.periods, advice))

    # --- numbers in the deck's units ----------------------------------------------------------------------------------

    @property
    def scale(self) -> Units:
        """The units that numbers are converted with."""
        return self.units or _PLAIN

    @property
    def angular_frequency(self) -> float:
        """Ω."""
        return self.scale.physical("angular_frequency", self.eta)

    @property
    def period(self) -> float:
        """T."""
        return self.scale.physical("time", 2.0 * math.pi / self.eta)

    @property
    def step(self) -> float:
        """Δt = T/n."""
        return self.period / self.method.steps

    @property
    def every(self) -> int:
        """Steps from one sample of the result to the next."""
        return max(1, self.method.steps // SAMPLES)

    @property
    def steps(self) -> int:
        """Duration of the whole run."""
        return self.periods * self.method.steps

    @property
    def first(self) -> float:
        """The time from which on samples are kept: half a step before the first of them."""
        return (self.periods - self.keep) * self.method.steps * self.step - 0.5 * self.step

    @property
    def end(self) -> float:
        """The time at which the run ends."""
        return self.periods * self.period

    @property
    def length(self) -> float:
        """The unit of length."""
        return self.scale.physical("displacement", 1.0)

    @property
    def clearance(self) -> float:
        """The gap where both springs are relaxed."""
        return self.scale.physical("displacement", self.system.clearance)

    @property
    def contact(self) -> tuple[float, float]:
        """K and c of the contact in the units of its law; c is 0 where it follows from the restitution."""
        method, units = self.method, self.scale.of_contact(self.method)
        damper = 0.0 if method.damping is None else method.damping
        return units.physical("contact_stiffness", method.stiffness), units.physical("contact_damping", damper)

    @property
    def start(self) -> tuple[float, float, float, float]:
        """ξ₁, ξ₁′, ξ₂, ξ₂′ at τ = 0, without dimension."""
        return self.initial or self.system.rest

    @property
    def displacements(self) -> tuple[float, float]:
        """Those of both bodies at the start."""
        return tuple(self.scale.physical("displacement", self.start[place]) for place in (0, 2))

    @cached_property
    def bodies(self) -> tuple[Body, ...]:
        """Both bodies, or one beside a wall."""
        parts = self.scale.pendulums(replace(self.system, wall=False, spring1=1.0) if self.system.wall else self.system)
        parts["k1"] *= self.system.spring1 if self.system.wall else 1.0
        count = 1 if self.system.wall else 2
        return tuple(self._body(i, *(parts[f"{letter}{i}"] for letter in "mkc")) for i in range(1, count + 1))

    def _body(self, i: int, mass: float, stiffness: float, damping: float) -> Body:
        """Body 1 or 2."""
        drive, force = self.system.excitation, self.scale.factor("force")
        share = mass / self.scale.factor("mass")
        inertia = (share * self.eta**2 * number for number in drive.harmonic("base", self.eta))
        own = Load(*drive.harmonic(f"force{i}", self.eta), getattr(drive, f"constant{i}"))
        load = Load(*(force * number for number in Load(*inertia, 0.0) + own))
        x, v = self.start[2 * i - 2 : 2 * i]
        scale = self.scale
        return Body(mass, stiffness, damping, load, scale.physical("displacement", x), scale.physical("velocity", v))

    @property
    def second_contact(self) -> tuple[float, float]:
        """K and c of the second stop, as :attr:`contact`."""
        factors = self.system.stiffness_factor2, self.system.damping_factor2
        return tuple(factor * number for factor, number in zip(factors, self.contact, strict=True))

    @property
    def second_clearance(self) -> float:
        """By how much the bodies move apart, from where both springs are relaxed, until they meet the second stop."""
        return self.scale.physical("displacement", self.system.clearance2)

    @property
    def gap(self) -> float:
        """The gap at the start."""
        return self.scale.physical("displacement", self.system.gap(self.start[0], self.start[2]))

    @property
    def second_gap(self) -> float:
        """The gap of the second stop at the start."""
        return self.clearance + self.second_clearance - self.gap

    def accelerations(self) -> tuple[float, ...]:
        """Accelerations of the bodies at the start, by the equations of motion, or zero if the method says so."""
        if self.method.initial_acceleration == "zero":
            return (0.0,) * len(self.bodies)
        gap, push, speeds = self.gap, 0.0, [*(body.velocity for body in self.bodies), 0.0]
        if gap <= 0.0 and self.method.linear:  # another one is zero at touch
            k, c = self.contact
            push = -k * gap - c * (speeds[1] - speeds[0])
        elif self.system.two_stops and (gap := self.second_gap) <= 0.0 and self.method.linear:
            k, c = self.second_contact
            push = k * gap - c * (speeds[1] - speeds[0])
        own = [
            b.load.cosine + b.load.constant - b.stiffness * b.displacement - b.damping * b.velocity for b in self.bodies
        ]
        return tuple(
            (force + sign * push) / b.mass for b, force, sign in zip(self.bodies, own, (-1.0, 1.0), strict=False)
        )

    # --- words --------------------------------------------------------------------------------------------------------

    @property
    def integrator(self) -> Integrator:
        """The integrator of the method."""
        return self.method.integrator

    @property
    def status(self) -> str | None:
        """The contact status that the method asks for: "end" or "located"; None: it is left to the code."""
        status = self.method.status
        return None if status == CONTACT_STATUSES[0] else status

    @property
    def header(self) -> str:
        """First line of the result, as ``vibroscope compare --measured`` reads it."""
        time, length = ("-", "-") if self.units is None else (self.scale.unit("time"), self.scale.unit("displacement"))
        return f"time [{time}], xi1 [{length}], xi2 [{length}]"

    def words(self, code: ModuleType) -> list[str]:
        """The first lines of the deck of a code, which describe it, in ASCII."""
        method, system = self.method, self.system
        bodies = "A body and a wall" if system.wall else "Two bodies"
        damper = "D from the restitution" if method.damping is None else f"D = {method.damping!r}"
        units = self.scale
        counted = (
            "Units: none; omega1 = 1 rad/s, m1 = 1, and displacements in the unit of length of the system."
            if self.units is None
            else f"Units: {', '.join(units.unit(name) for name in ('time', 'displacement', 'mass', 'force'))}."
        )
        return [
            f"{bodies} that may touch, for {code.NAME}. Written by Vibroscope {version('vibroscope')}.",
            f"eta = {self.eta!r}, K = {method.stiffness!r}, {damper}, {method.steps} steps per period, "
            f"contact law {method.law}.",
            counted,
            "Displacements are relative to the base, whose motion acts as forces on the masses.",
            *self._warning(code.STATUS),
        ]

    def parts(self, code: ModuleType) -> dict[str, object]:
        """What the templates of all decks have: ``p``, this problem, words in comments, and x₁ and x₂ at the start."""
        words = f"\n{code.COMMENT}".join(self.words(code))
        compare = f"\n{code.COMMENT or '  '}  ".join(self.compare(code))  # a docstring has no marks of comments
        x1, x2 = self.displacements
        return {"p": self, "words": words, "compare": compare, "x1": x1, "x2": x2}

    def _stepping(self, status: str) -> TimeStepping:
        """The method with the contact status of a code."""
        found = replace(self.method, status=CONTACT_STATUSES[0], resolves_contacts=False)
        return with_located_steps(found) if status == "located" else replace(found, status=status)

    def _warning(self, status: str) -> list[str]:
        """A line if a step of the run has no solution with the contact status of the code."""
        if status != "end" or self.integrator.explicit:
            return []
        method = replace(self._stepping(status), integrator=self.integrator, every_step=False)
        run = simulate(self.system, self.eta, method, periods=self.periods, keep=1, initial=self.initial)
        if run.status is not Status.WITHOUT_SOLUTION:
            return []
        return [f"WARNING: with the contact status of this code {run.message.what}: it cuts the step, or stops there."]

    def compare(self, code: ModuleType) -> list[str]:
        """The lines of the deck of a code with the commands that lay the result over ours.

        The system file that they need stands in the deck itself, in lines that begin with a bar.
        """
        found, lines = self._stepping(code.STATUS), []
        options = f"--eta {print_number(self.eta)}{penalty_options(found)}{initial_option(self.initial)}"
        if text := system_file_text(self.system, self.units):
            lines = [f"| {line}" for line in text.split("\n")]
            lines.append(f"sed -n 's,^[*!/ ]*| ,,p' {self.name}.{code.SUFFIX} > {self.name}.toml")
            options += f" --system {self.name}.toml"
        options += "" if self.units is None else f" --units {self.units.system}"
        return [*lines, f"vibroscope compare --measured {self.name}.csv {options}"]


def refuse(code: str, what: str, advice: str) -> ValueError:
    """The error for what a code of this name cannot express."""
    return ValueError(f"{code} cannot express {what}: {advice}")


def alpha_of(problem: DeckProblem, code: str) -> float:
    """α of HHT, 0 of the average acceleration; raises ValueError for other numbers of Newmark's method."""
    integrator = problem.integrator
    if integrator.name == "newmark" and (integrator.beta, integrator.gamma) != (0.25, 0.5):
        raise refuse(code, "other numbers of Newmark's method", "leave out --beta and --gamma, or take hht")
    return getattr(integrator, "alpha", 0.0)


def check(problem: DeckProblem, code: ModuleType) -> None:
    """Raise ValueError, in one line, for a law, an integrator or a contact status that a code does not have."""
    law, name = problem.method.law, problem.integrator.name
    if law not in code.LAWS:
        raise refuse(code.NAME, f"law = {law!r}", f"this deck has {', '.join(code.LAWS)}")
    if name not in code.INTEGRATORS:
        raise refuse(code.NAME, f"integrator = {name!r}", f"this deck has {', '.join(code.INTEGRATORS)}")
    if problem.status not in (None, code.STATUS):
        raise refuse(code.NAME, f"status = {problem.status!r}", f"it has {code.STATUS!r}; give that, or none")
    if (without := problem.method.without_solution) != "stop":
        raise refuse(code.NAME, f"without_solution = {without!r}", "the deck's step is constant")
