"""The question: two bodies of a reduced mass meet with a closing speed; a contact, and how it is solved.

All numbers are in one consistent system of units, dimensionless ones included. In units of mass, speed and length in
which the reduced mass, the closing speed and the spring's force at a penetration of one are one, a contact depends on
the damper, the step and the constant force alone (:class:`..contact.ContactUnits`).
"""

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property

from vibroscope.engine.arguments import require, set_fields
from vibroscope.engine.contact import (
    ContactUnits,
    check_mass,
    check_speed,
    contact_time,
    damping_of_restitution,
    ratio_of_method,
    restitution_of_units,
)
from vibroscope.engine.drivers.alone import Course, Touches, course_alone, parameters_alone, touches_alone
from vibroscope.engine.law_table import powers_of
from vibroscope.engine.methods import ExactPenalty, TimeStepping

STEP_RANGE = (0.0, 1e12)
FORCE_RANGE = (0.0, 1e12)
NO_STEPS = 4  # of a method in a question, whose number of steps has no meaning
MOST_STEPS_PER_CONTACT = 1e5
STEP_ADVICE = "give the time step in the unit of time of the other numbers"


def set_checked(question: object, *, has_step: bool = False) -> None:
    """Set the numbers that all questions have to floats within their ranges.

    ``has_step``: whether a step of 0, as a method without one has it, is out of range.

    Raises
    ------
    ValueError
        If a number is out of range; if the step is so long that the force makes the speed.
    """
    one, advice = question, "give a constant force that presses the bodies together, or 0"
    set_fields(
        question,
        speed=check_speed(one.speed),
        mass=check_mass(one.mass),
        time_step=require("time_step", one.time_step, *STEP_RANGE, STEP_ADVICE, open_low=has_step),
        force=require("force", one.force, *FORCE_RANGE, advice),
        restitution=require("restitution", one.restitution, 0.0, 1.0, "give the restitution asked for"),
    )
    if one.force * one.time_step >= one.mass * one.speed:
        longest = one.mass * one.speed / one.force
        raise ValueError(
            f"time_step = {one.time_step:g}: within it the force makes the speed; take less than {longest:g}"
        )


@dataclass(frozen=True)
class Impact:
    """Two bodies meet; no force acts but that of the contact and, where given, a constant one.

    Attributes
    ----------
    method : ExactPenalty, Newmark or TimeStepping
        Law, K and D, and where there is a step integrator and contact status. Its steps per period have no meaning.
        Contacts of located steps are not resolved by shorter ones.
    speed : float
        Closing speed at touch, v₀ > 0.
    mass : float
        Reduced mass m₁m₂/(m₁ + m₂); at a wall that of the body.
    time_step : float
        Δt; 0 of a method without one.
    force : float
        Constant force that presses the bodies together, such as a weight.
    restitution : float
        From which the law takes its damper where D is left out.

    Raises
    ------
    ValueError
        If a number is out of range; if the step is so long or so short, or the force so large, that no contact is
        followed.

    Examples
    --------
    >>> from vibroscope.engine import Impact, TimeStepping
    >>> question = Impact(TimeStepping(1e6, 50, 4), speed=1.0, time_step=1e-4)
    >>> round(question.steps_per_contact, 1)
    31.5
    """

    method: ExactPenalty | TimeStepping
    speed: float
    mass: float = 1.0
    time_step: float = 0.0
    force: float = 0.0
    restitution: float = 1.0

    def __post_init__(self):
        if self.method.rigid:
            raise ValueError("the method has no contact spring: give ExactPenalty, Newmark or TimeStepping")
        set_checked(self)
        if self.method.has_step != (self.time_step > 0.0):
            has = "has" if self.method.has_step else "has not"
            raise ValueError(
                f"time_step = {self.time_step:g} with a method that {has} one: {STEP_ADVICE}, or leave both"
            )
        if self.time_step and self.steps_per_contact > MOST_STEPS_PER_CONTACT:
            shortest = self.contact_time / MOST_STEPS_PER_CONTACT
            raise ValueError(f"time_step = {self.time_step:g} is too short to follow: take at least {shortest:g}")

    @cached_property
    def units(self) -> ContactUnits:
        """In which the contact is solved."""
        return ContactUnits(self.mass, self.speed, self.method.stiffness, self.method.spring_exponent)

    @cached_property
    def unit_method(self) -> ExactPenalty | TimeStepping:
        """The method in these units."""
        method, numbers = self.method, self.method.law_numbers
        if numbers["penetration"] is not None:
            numbers["penetration"] /= self.units.length
        damping = method.damping
        if damping is not None:
            damping /= self.units.damping(method.law, method.exponent)
        if not method.has_step:
            return ExactPenalty(1.0, damping, method.law, **numbers)
        choices = {name: getattr(method, name) for name in ("integrator", "status", "without_solution", "law")}
        return TimeStepping(1.0, damping, NO_STEPS, **choices, **numbers)

    @cached_property
    def without_step(self) -> Course:
        """What the contact gives without a time step, in the units of the question; restitution in closed form."""
        method, u = self.unit_method.limit, self.units
        found = course_alone(parameters_alone(method, self.restitution, push=self.force / u.force))
        if not self.force:
            found = found._replace(restitution=restitution_of_units(method, self.restitution))
        return Course(found.restitution, found.penetration * u.length, found.force * u.force, found.time * u.time)

    @property
    def touches(self) -> Touches:
        """Its contacts with the step, in its units."""
        return self.touches_with(self.time_step)

    def touches_with(self, time_step: float) -> Touches:
        """Its contacts with another step, in its units."""
        return self._touches(time_step / self.units.time)

    @cached_property
    def _touches(self) -> Callable[[float], Touches]:
        return touches_alone(self.unit_method, self.restitution, self.force / self.units.force)

    @property
    def depends_on_speed(self) -> bool:
        """Whether the restitution does; else it is the same at each, and penetration and force grow with the speed."""
        constants = powers_of(self.method.law, self.method.exponent) == (1.0, 0.0)  # spring and damper
        return bool(self.force) or not constants or self.method.penetration is not None

    @property
    def ratio(self) -> float:
        """ζ = D/√(Km); nan of a law whose spring or damper is none that is constant, or without a D."""
        return ratio_of_method(self.mass, self.method)

    @cached_property
    def contact_time(self) -> float:
        """How long a contact lasts, as steps in it are counted: :func:`..contact.contact_time`."""
        return contact_time(self.mass, self.method, self.speed)

    @property
    def scheme(self) -> tuple[str, str]:
        """Integrator and contact status of the steps."""
        return self.method.integrator.name, self.method.status

    @property
    def steps_per_contact(self) -> float:
        """Time steps in :attr:`contact_time`; inf without a step."""
        return self.contact_time / self.time_step if self.time_step else math.inf

    def with_steps_per_contact(self, steps: float) -> "Impact":
        """The same with a time step of which so many are in a contact."""
        return replace(self, time_step=self.contact_time / steps)

    def with_contact(self, stiffness: float | None = None, damping: float | None = None) -> "Impact":
        """The same with another K or D."""
        given = {"stiffness": stiffness, "damping": damping}
        return replace(self, method=replace(self.method, **{k: v for k, v in given.items() if v is not None}))

    def with_restitution(self, restitution: float) -> "Impact":
        """The same with the D that gives a restitution without a step."""
        method = self.method
        numbers = method.law_numbers | {"mass": self.mass, "closing_speed": self.speed}
        return self.with_contact(damping=damping_of_restitution(method.law, restitution, method.stiffness, **numbers))
