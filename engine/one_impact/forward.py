"""The answer: what a contact gives, without a step and with it.

It is a span of restitutions over the instant of touch (:class:`Span`), and the contact force over time
(:func:`force_courses`): of the touch closest to what was asked, of the farthest, and without a step.

Codes without a contact spring apply Newton's impact law at the velocities of each step, a nonsmooth step.

The θ-method of Moreau and Jean, with the velocity v and the gap g of a reduced mass, a constant force F that closes the
gap, and the impulse P of the contact over a step,

    m(v₁ − v₀) = P − hF,        g₁ = g₀ + h(θv₁ + (1 − θ)v₀),

    v₁ + ev₀ ≥ 0,  P ≥ 0,  (v₁ + ev₀) P = 0  where  g₀ + hv₀/2 ≤ 0,  else P = 0:

one contact has v₁ = max(v₀ − hF/m, −ev₀) there. The gap itself bounds nothing: without F bodies of closing speed v
overlap by up to hv times the larger of ½ and 1½ − θ(1 + e), and with e = 0 they stay so. The contact creates no energy
for ½ ≤ θ ≤ 1/(1 + e).

Jean, Comput. Methods Appl. Mech. Eng. 177 (1999) 235–257; Acary & Brogliato, Numerical Methods for Nonsmooth Dynamical
Systems (2008); energy: Acary, ZAMM 96 (2016) 585–603. The MoreauJeanOSI of Siconos predicts the gap so, by its γ = ½
(user's guide: Event-Capturing schemes).
"""

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from vibroscope.engine.arguments import require, set_fields
from vibroscope.engine.contact import ContactUnits
from vibroscope.engine.drivers.alone import (
    BLOWN_UP,
    CODE,
    DEPTH,
    FOUND,
    GAP,
    PARTED,
    PUSH,
    SPEED,
    STEPS,
    STUCK,
    force_alone,
    parameters_alone,
)
from vibroscope.engine.one_impact.instants import FULL, SHORT, Fineness, Instants, over_instants
from vibroscope.engine.one_impact.question import Impact, set_checked

THETA_RANGE = (0.5, 1.0)
MOST_STEPS = 10_000  # of a contact with a force, after which it stays
PREDICTED = 0.5  # of a step, at which the gap decides whether there is contact
GAINED = 1e-9  # restitution beyond one that is not rounding
CONTACT_TIMES = 2.0  # after so many a contact that has not ended is not followed further
MOST_GIVEN = 1000  # steps that are given; of more, each second, third, …


@dataclass(frozen=True)
class MoreauJean:
    """Two bodies meet in a code with an impact law and a time step; a question for :func:`impact`.

    Attributes
    ----------
    restitution : float
        e of Newton's law.
    time_step : float
        h.
    speed, mass, force
        As those of :class:`Impact`.
    theta : float
        θ, ½ to 1.

    Raises
    ------
    ValueError
        If a number is out of range; if the step is so long that the force makes the speed.

    Examples
    --------
    >>> from vibroscope.engine import MoreauJean, impact
    >>> found = impact(MoreauJean(0.5, time_step=1e-3))
    >>> [round(e, 6) for e in found.restitution]  # whatever the step
    [0.5, 0.5, 0.5]
    >>> round(found.penetration / 1e-3, 6)  # of a step of flight at the speed 1
    0.75
    """

    restitution: float
    time_step: float
    speed: float = 1.0
    mass: float = 1.0
    force: float = 0.0
    theta: float = 0.5

    def __post_init__(self):
        set_checked(self, has_step=True)
        why = "1/2 conserves energy in flight, 1 is Euler's"
        set_fields(self, theta=require("theta", self.theta, *THETA_RANGE, why))

    @property
    def scheme(self) -> tuple[str, str]:
        """Its name, as that of an integrator; it has no contact status."""
        return "moreau-jean", ""

    @property
    def units(self) -> ContactUnits:
        """Those in which the step is one as well: a stiffness of m/h²."""
        return ContactUnits(self.mass, self.speed, self.mass / self.time_step**2, 1.0)

    @property
    def touches(self) -> "NonsmoothTouches":
        """Its contacts, in its units."""
        return NonsmoothTouches(self.restitution, self.theta, self.force / self.units.force)


class NonsmoothTouches:
    """Contacts by these steps, in units of mass, closing speed and step, as :class:`..drivers.alone.Touches`."""

    def __init__(self, restitution: float, theta: float, push: float):
        self.restitution, self.theta, self.flight = restitution, theta, -push

    def run(self, instants: np.ndarray) -> np.ndarray:
        """What is found of each touch, (n, FOUND): the force is that which gives the impulse over a step.

        ``instants``: (n,), of touch, in steps after one, from 0 to 1.
        """
        gap, rate = instants + 0.5 * self.flight * instants**2, -(1.0 + self.flight * instants)
        found = np.zeros((len(instants), FOUND))
        found[:, CODE] = STUCK
        going = np.ones(len(instants), dtype=bool)
        for _ in range(MOST_STEPS):
            # rates −e, e², −e³ … times this one follow, which leave the gap closed; this step is the deepest of them
            slow = -(1.0 + self.restitution) * rate <= -self.flight
            rests = slow & (rate <= 0.0) & (gap < 0.0) & (gap <= 1.5 * rate)
            free, bound = rate + self.flight, np.where(gap + PREDICTED * rate <= 0.0, -self.restitution * rate, -np.inf)
            after = np.maximum(free, bound)
            impulse = after - free
            gap, rate = gap + self.theta * after + (1.0 - self.theta) * rate, after
            found[:, DEPTH] = np.where(going, np.maximum(found[:, DEPTH], -gap), found[:, DEPTH])
            found[:, PUSH] = np.where(going, np.maximum(found[:, PUSH], impulse), found[:, PUSH])
            found[:, STEPS] += going & (impulse > 0.0)
            hit = going & (found[:, STEPS] > 0)
            parted = hit & (impulse == 0.0) & (rate > 0.0) & ((gap > 0.0) | (self.flight == 0.0))
            found[parted, SPEED], found[parted, GAP], found[parted, CODE] = rate[parted], gap[parted], PARTED
            going &= ~(parted | rests | (hit & (rate == 0.0) & (self.flight == 0.0)))
            if not going.any():
                break
        return found


class Span(NamedTuple):
    """Over the instants of touch within a step."""

    least: float
    mean: float
    greatest: float


@dataclass(frozen=True)
class WithStep:
    """What steps make of a contact, over the instants of touch within a step.

    Attributes
    ----------
    restitution : Span
        Of the contacts that have a result: neither blown up nor ended by a step without a solution. 0 of those that
        stick: they rest, or go on meeting with ever smaller speeds.
    energy_lost : Span
        1 − e², as a share of the energy with which the bodies meet; negative where it is gained.
    penetration, force : float
        The greatest, at steps.
    steps : (int, int)
        Fewest and most in which the force acts.
    time : (float, float)
        How long these are.
    without_solution, two_solutions, blown_up, stuck, gained : float
        Shares of the touches: with a step that has no solution, or two; whose motion grows beyond all bounds; that do
        not part again; that part faster than they came.
    instant, restitutions : (n, 5) ndarray
        The restitution over the instant of touch, in steps after a step: in n pieces, each at five instants; nan
        without a result.
    """

    restitution: Span
    energy_lost: Span
    penetration: float
    force: float
    steps: tuple[int, int]
    time: tuple[float, float]
    without_solution: float
    two_solutions: float
    blown_up: float
    stuck: float
    gained: float
    instant: np.ndarray
    restitutions: np.ndarray


def impact(question: Impact | MoreauJean, fineness: Fineness = FULL) -> WithStep:
    """Solve a contact with its step, over all instants of touch.

    Parameters
    ----------
    question : Impact or MoreauJean
        Of a method with a time step; without one: :attr:`Impact.without_step`.
    fineness : Fineness
        `OUTLINE` for a curve of many of them, whose restitutions and shares alone are used.

    Raises
    ------
    ValueError
        If there is no time step.

    Examples
    --------
    >>> from vibroscope.engine import Impact, TimeStepping, impact
    >>> question = Impact(TimeStepping(1e6, 0.0, 4), 1.0, time_step=1e-4).with_restitution(0.5)
    >>> found = impact(question.with_steps_per_contact(5)).restitution
    >>> [round(e, 2) for e in found]
    [0.23, 0.49, 0.58]
    """
    found = instants_of(question, fineness)
    e, known = found.restitution, np.isfinite(found.restitution).any()
    fewest, most = map(int, found.ends(found.steps)) if known else (0, 0)
    least, greatest = found.ends(e)
    return WithStep(
        Span(least, found.mean(e), greatest),
        Span(1.0 - greatest**2, found.mean(1.0 - e**2), 1.0 - least**2),
        found.ends(found.depth)[1],
        found.ends(found.force)[1],
        (fewest, most),
        (fewest * question.time_step, most * question.time_step),
        found.share(found.unsolved),
        found.share(found.two > 0),
        found.share(found.code == BLOWN_UP),
        found.share(found.code == STUCK),
        found.share_above(e, 1.0 + GAINED),
        found.instant,
        e,
    )


def instants_of(question: Impact | MoreauJean, fineness: Fineness = FULL) -> Instants:
    """The contact over the instants of touch, in the units of the question; nan of contacts without a result.

    Raises
    ------
    ValueError
        If there is no time step.
    """
    if not question.time_step:
        raise ValueError("the question has no time step: give one, or ask for what the contact gives without_step")
    found, u = over_instants(question.touches, fineness), question.units
    known = np.isfinite(found.restitution)
    depth, force, steps = (np.where(known, each, np.nan) for each in (found.depth, found.force, found.steps))
    return found._replace(depth=depth * u.length, force=force * u.force, steps=steps)


class ForceCourse(NamedTuple):
    """The force of one contact over time."""

    instant: float  # of touch, in steps after a step; nan without a step
    restitution: float
    time: np.ndarray  # (n,), since touch
    force: np.ndarray  # (n,); with a step that at the end of each step


def force_courses(
    question: Impact, asked: float | None = None, found: WithStep | None = None
) -> dict[str, ForceCourse]:
    """The force over time of the best touch within a step, of the worst, and of the contact without a step.

    The best has the restitution nearest to what was asked for, and the worst the farthest of all that have one.

    Parameters
    ----------
    question : Impact
    asked : float, optional
        The restitution that was asked for; by default what the contact gives without a step.
    found : WithStep, optional
        What `impact` finds; without it, it is computed.

    Returns
    -------
    dict of str to ForceCourse
        "best" and "worst", both left out where no touch has a restitution, and "exact".

    Raises
    ------
    ValueError
        If there is no time step.

    Examples
    --------
    >>> from vibroscope.engine import Impact, TimeStepping, force_courses
    >>> question = Impact(TimeStepping(1e6, 0.0, 4), 1.0, time_step=1e-4).with_restitution(0.5)
    >>> courses = force_courses(question.with_steps_per_contact(5))
    >>> {name: round(course.restitution, 2) for name, course in courses.items()}
    {'best': 0.56, 'worst': 0.23, 'exact': 0.5}
    """
    found = found or impact(question)
    wanted = question.without_step.restitution if asked is None else asked
    u, until = question.units, CONTACT_TIMES * question.contact_time
    known = np.isfinite(found.restitutions)
    lasting = found.instant[:, -1:] - found.instant[:, :1] > SHORT  # else rounding decides what a touch there gives
    known &= lasting | ~(known & lasting).any()
    off, touches, courses = np.abs(found.restitutions[known] - wanted), question.touches, {}
    for name, choose in (("best", np.argmin), ("worst", np.argmax)) if known.any() else ():
        k = choose(off)
        instant, e = float(found.instant[known][k]), float(found.restitutions[known][k])
        steps = math.ceil(until / question.time_step) + 1
        every = math.ceil(steps / MOST_GIVEN)
        force = touches.force(instant, steps, every)
        time = (every * np.arange(len(force)) - instant) * question.time_step
        courses[name] = ForceCourse(instant, e, time, force * u.force)
    p = parameters_alone(question.unit_method.limit, question.restitution, push=question.force / u.force)
    time, force = force_alone(p, until / u.time)
    courses["exact"] = ForceCourse(math.nan, question.without_step.restitution, time * u.time, force * u.force)
    return courses
