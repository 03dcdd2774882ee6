"""Backwards: from what a contact is to give to the step, K and D, each verified by solving the contact with it.

K may also follow from materials and radii, by Hertz' contact of two elastic bodies with round surfaces. The force is
Kδ^1.5 with

    K = 4/3 E* √R,    1/E* = (1 − ν₁²)/E₁ + (1 − ν₂²)/E₂,    1/R = 1/R₁ + 1/R₂

(Johnson, Contact Mechanics (1985), section 4.2; Goldsmith, Impact (1960), section 4.2). A plane has the radius inf.
"""

import math
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import replace
from functools import cache
from itertools import chain, pairwise
from typing import NamedTuple

import numpy as np
from vibroscope.engine.arguments import Poll, require
from vibroscope.engine.drivers.alone import BLOWN_UP, Touches, parameters_alone
from vibroscope.engine.drivers.step_maps import bodies_of, is_stable
from vibroscope.engine.methods import contact_ranges
from vibroscope.engine.one_impact.forward import GAINED, WithStep, impact
from vibroscope.engine.one_impact.instants import (
    EDGE,
    OUTLINE,
    ROUGH,
    SAME,
    Instants,
    courses_of,
    follow,
    over_instants,
)
from vibroscope.engine.one_impact.question import Impact
from vibroscope.engine.result import check_cancelled

MODULUS_RANGE = (0.0, 1e15)
POISSON_RANGE = (-1.0, 0.5)
STEPS_RANGE = (0.25, 500.0)  # steps per contact among which the fewest are sought
PER_DECADE = 16  # tried before halving, of these and of K and D
LOOK_ABOVE, PER_STEP = 1.5, 10  # from what is found so far to so many times that, so many are tried for each step more
CLOSELY, EACH = 10, 31  # … up to so many steps more; beyond them each 31st of these, e being closer the more there are
LOOK = 1e3  # times a value, and that part of it, within which its bounds are sought
SEEK = 10.0  # times K, from one bracket of a permitted penetration or force to the next
CLOSE_TO_ASKED = 0.05  # of the restitution
HALVED_TO = 1e-4  # relative, of what is found by halving, and how close to a change of contacts steps are tried
JUST_BELOW = 1.0 - 0.25 * HALVED_TO
SURE = 2e-3  # of the restitution: closer to a bound than this, a rough look over the instants does not decide


class Material(NamedTuple):
    """An isotropic elastic material."""

    modulus: float  # E in Pa
    poisson: float  # ν
    title: str = ""
    source: str = ""


def hertz_stiffness(first: Material, second: Material, radius1: float, radius2: float = math.inf) -> float:
    """Return K of the force Kδ^1.5, in N/m^1.5 of moduli in Pa and radii in m.

    Parameters
    ----------
    first, second : Material
    radius1, radius2 : float
        Of the surfaces, positive; inf of a plane, at most one of them.

    Raises
    ------
    ValueError
        If a number is out of range.

    Examples
    --------
    >>> from vibroscope.engine import Material, hertz_stiffness
    >>> steel = Material(210e9, 0.3)
    >>> f"{hertz_stiffness(steel, steel, 0.01):.3g}"
    '1.54e+10'
    """
    compliance = 0.0
    for body in (first, second):
        modulus = require("E", body.modulus, *MODULUS_RANGE, "give Young's modulus in Pa", open_low=True)
        poisson = require("nu", body.poisson, *POISSON_RANGE, "give Poisson's ratio", open_low=True)
        compliance += (1.0 - poisson**2) / modulus
    curvature = 0.0
    for radius in (radius1, radius2):
        if not radius > 0.0:
            raise ValueError(f"radius = {radius:g} is not positive: give a radius in m, or inf of a plane")
        curvature += 1.0 / radius
    if curvature == 0.0:
        raise ValueError("two planes touch in no point: give a radius of at least one of them")
    return 4.0 / (3.0 * compliance * math.sqrt(curvature))


def over_steps(question: Impact, steps: Sequence[float] | np.ndarray) -> Iterator[tuple[float, WithStep]]:
    """The contact with so many steps in it, one after the other.

    ``steps``: (n,), steps per contact as :attr:`Impact.contact_time` counts them.

    Examples
    --------
    >>> from vibroscope.engine import Impact, TimeStepping, over_steps
    >>> question = Impact(TimeStepping(1e6, 0.0, 4), 1.0, time_step=1e-4).with_restitution(0.5)
    >>> [(n, round(found.restitution.least, 2)) for n, found in over_steps(question, [5, 10, 20])]
    [(5.0, 0.23), (10.0, 0.4), (20.0, 0.46)]
    """
    for n in steps:
        yield float(n), impact(question.with_steps_per_contact(float(n)))


def over_speeds(question: Impact, speeds: Sequence[float] | np.ndarray) -> Iterator[tuple[float, WithStep]]:
    """The contact at each of the closing speeds, (n,), with the step as it is.

    Examples
    --------
    >>> from vibroscope.engine import Impact, TimeStepping, over_speeds
    >>> hertz = Impact(TimeStepping(1e6, 1e5, 4, law="hunt-crossley"), 1.0, time_step=1e-3)
    >>> [round(found.restitution.mean, 2) for _, found in over_speeds(hertz, [0.5, 1.0, 2.0])]
    [0.95, 0.9, 0.81]
    """
    for speed in speeds:
        yield float(speed), impact(replace(question, speed=float(speed)))


class LargestStep(NamedTuple):
    """The largest step with which, and with every smaller one, a contact gives what was asked."""

    step: float  # s
    steps_per_contact: float
    verified: WithStep  # with this step


def largest_step(
    question: Impact, tolerance: float = CLOSE_TO_ASKED, asked: float | None = None, cancelled: Poll | None = None
) -> LargestStep | None:
    """The largest step for which e stays within a tolerance of what was asked, whatever the instant of touch.

    Smaller steps, down to 500 in a contact, keep to it as well. Certain of one stage: up to 1.5 times the steps in a
    contact that are found, and ten more at most, each change of the course of a contact that begins at the end of a
    step is sought, and with the status of the end each that halving finds at any instant; both of its sides are tried,
    where a restitution appears or ends. Between these changes, where the restitution is smooth, ten numbers of steps in
    each unit are sampled; above, up to 1.5 times, each 31st of these, and beyond 16 in a decade. Of two stages changes
    within a step show in part, and what is narrower than a tenth of a step can be missed.
    Touches that a step without a solution ends have no restitution: `verified` says how many they are.

    Parameters
    ----------
    question : Impact
        Of a method with a step; which one has no part in the answer.
    tolerance : float
        Of the restitution, above 0.
    asked : float, optional
        The restitution that was asked for; by default what the contact gives without a step.
    cancelled : callable, optional
        Polled for each step that is tried; when it returns true the search is cancelled.

    Returns
    -------
    LargestStep or None
        None if even the smallest step does not keep to it.

    Raises
    ------
    ValueError
        If the tolerance is not positive.
    Cancelled
        If ``cancelled`` returned true.

    Examples
    --------
    >>> from vibroscope.engine import Impact, TimeStepping, largest_step
    >>> question = Impact(TimeStepping(1e6, 0.0, 4), 1.0, time_step=1e-4).with_restitution(0.5)
    >>> round(largest_step(question).steps_per_contact, 1)
    18.0
    """
    tolerance = require("tolerance", tolerance, 0.0, 1.0, "give how far the restitution may be off", open_low=True)
    wanted = question.without_step.restitution if asked is None else asked

    @cache
    def touches(steps: float) -> Touches:
        check_cancelled(cancelled)
        return question.touches_with(question.contact_time / steps)

    @cache
    def rough(steps: float) -> Instants:
        return over_instants(touches(steps), ROUGH)

    @cache
    def keeps(steps: float) -> bool:
        found = rough(steps)
        off = np.nanmax(np.abs(found.restitution - wanted), initial=0.0)
        if off > tolerance or (found.code == BLOWN_UP).any():
            return False
        if off < tolerance - SURE:
            return np.isfinite(found.restitution).any()
        found = over_instants(touches(steps), OUTLINE)
        ends = found.ends(found.restitution)
        return not (found.code == BLOWN_UP).any() and all(abs(e - wanted) <= tolerance for e in ends)

    ends = np.array([0.0, *(stage.end for stage in question.method.integrator.stages)])
    edges = np.unique(np.clip(np.concatenate([ends - EDGE, ends + EDGE]), EDGE, 1.0 - EDGE))

    @cache
    def courses(steps: float) -> list[list[float]]:
        """Of contacts that begin at the ends of a step or stage; with the status of the end, of all in their order."""
        looked = courses_of(follow(touches(steps), edges)[:, SAME])
        inside = rough(steps).courses if question.method.status == "end" else looked[:0]
        return [*looked.tolist(), *inside.tolist()]

    tried = np.geomspace(*reversed(STEPS_RANGE), 1 + PER_DECADE * 3)
    impulse = question.force * question.contact_time / tried  # in a step, that may not make the speed
    fewest = _last_that_holds(keeps, tried[impulse < question.mass * question.speed])
    while fewest is not None:  # steps that fail recur with each step more in a contact: looked for more closely above
        # at the same steps each time, of which what is known is kept; e is farthest off just below whole numbers
        near = np.arange(math.ceil(LOOK_ABOVE * fewest * PER_STEP), fewest * PER_STEP, -1.0) * JUST_BELOW / PER_STEP
        near = near[(near > fewest) & (near < STEPS_RANGE[1])]
        far = near[near > fewest + CLOSELY][::EACH].tolist()
        first = near[0] if len(near) else fewest
        near = _with_changes(courses, [*near[near <= fewest + CLOSELY].tolist(), fewest])
        closer = _last_that_holds(keeps, chain(far, near))
        if closer == fewest:
            break
        fewest = float(tried[tried > first][-1]) if closer is None else closer  # the first fails: on above it
    if fewest is None:
        return None
    chosen = question.with_steps_per_contact(fewest)
    return LargestStep(chosen.time_step, fewest, impact(chosen))


def _with_changes(courses: Callable[[float], list], steps: Sequence[float]) -> Iterator[float]:
    """Steps per contact, falling, and between them both sides of each change of the courses that contacts take.

    There a piece of the instants of touch appears or ends, and with it a restitution.
    """

    def between(high: float, low: float, at_high: list, at_low: list) -> Iterator[float]:
        if at_high == at_low:
            return
        if high / low - 1.0 < HALVED_TO:
            yield from (high, low)
            return
        middle = 0.5 * (high + low)
        at_middle = courses(middle)
        yield from between(high, middle, at_high, at_middle)
        yield from between(middle, low, at_middle, at_low)

    for high, low in pairwise(steps):
        yield high
        yield from between(high, low, courses(high), courses(low))
    yield steps[-1]


class Bounds(NamedTuple):
    """Around a value, from where to where a step is stable, gains no energy, and has a solution, whenever bodies touch.

    Each is (least, greatest): 0 and inf where it holds as far as is looked; None where it does not hold at the value.
    ``stable`` is None of a law that is not spring and damper, whose stiffness depends on the depth.
    """

    stable: tuple[float, float] | None
    no_energy_gained: tuple[float, float] | None
    solution: tuple[float, float] | None


def stiffness_bounds(question: Impact) -> Bounds:
    """Bounds of K at the step and with the D of a question, from a thousandth to a thousand times its K.

    Examples
    --------
    >>> from vibroscope.engine import CentralDifference, Impact, TimeStepping, stiffness_bounds
    >>> explicit = TimeStepping(1e6, 0.0, 4, integrator=CentralDifference())
    >>> round(stiffness_bounds(Impact(explicit, 1.0, time_step=1e-3)).stable[1], -3)  # (2/Δt)²
    4000000.0
    """
    span = contact_ranges(question.method.law)[0]
    return _bounds(lambda value: question.with_contact(stiffness=value), question.method.stiffness, span)


def damping_bounds(question: Impact) -> Bounds:
    """Bounds of D at the step and with the K of a question, likewise.

    Examples
    --------
    >>> from vibroscope.engine import Impact, TimeStepping, damping_bounds
    >>> least, _ = damping_bounds(Impact(TimeStepping(1e6, 200, 4), 1.0, time_step=5e-4)).no_energy_gained
    >>> round(least, 1)  # less does not make up for the contact that is felt late
    46.8

    Raises
    ------
    ValueError
        If there is no D.
    """
    if not question.method.damping:
        raise ValueError("D is 0 or left out: give one around which to look")
    span = contact_ranges(question.method.law)[1]
    return _bounds(lambda value: question.with_contact(damping=value), question.method.damping, span)


def _bounds(changed: Callable[[float], Impact], value: float, span: tuple[float, float]) -> Bounds:
    def stable(value: float) -> bool:
        question = changed(value)
        step = question.time_step / question.units.time
        bodies = bodies_of(parameters_alone(question.unit_method, question.restitution, step))
        return is_stable(bodies, question.method.integrator, step, 1)

    def gains_none(value: float) -> bool:
        found = over_instants(changed(value).touches, OUTLINE)
        return not ((found.restitution > 1.0 + GAINED) | (found.code == BLOWN_UP)).any()

    def solved(value: float) -> bool:
        return not over_instants(changed(value).touches, OUTLINE).unsolved.any()

    def around(holds: Callable[[float], bool]) -> tuple[float, float] | None:
        ends = []
        for far, beyond in ((value / LOOK, 0.0), (value * LOOK, math.inf)):
            far = min(max(far, span[0]), span[1])
            tried = np.geomspace(value, far, 1 + math.ceil(PER_DECADE * abs(math.log10(far / value))))
            last = _last_that_holds(holds, tried)
            if last is None:
                return None
            ends.append(beyond if last == tried[-1] else last)
        return ends[0], ends[1]

    return Bounds(around(stable) if changed(value).method.linear else None, around(gains_none), around(solved))


def _last_that_holds(holds: Callable[[float], bool], tried: Iterable[float]) -> float | None:
    """The value up to which, from the first of those tried on, something holds; None if for none."""
    good = None
    for value in map(float, tried):
        if not holds(value):
            break
        good = value
    else:
        return good
    return None if good is None else _halved(holds, good, value, HALVED_TO)


def _halved(holds: Callable[[float], bool], good: float, bad: float, to: float) -> float:
    """The value closest to a bad one for which something still holds, up to a relative difference."""
    while abs(bad / good - 1.0) > to:
        middle = math.sqrt(good * bad)
        if middle in (good, bad):
            break
        good, bad = (middle, bad) if holds(middle) else (good, middle)
    return good


def stiffness_for(question: Impact, *, penetration: float | None = None, force: float | None = None) -> Impact:
    """The question with the K at which the deepest penetration or the largest force is a permitted one, without a step.

    The restitution stays what it is without a constant force: D follows. K is the smallest for a penetration, and the
    largest for a force.

    Parameters
    ----------
    question : Impact
        Its law has a D.
    penetration, force : float
        One of the two.

    Raises
    ------
    ValueError
        If both are given or none, or no K within the range gives it.

    Examples
    --------
    >>> from vibroscope.engine import ExactPenalty, Impact, stiffness_for
    >>> question = Impact(ExactPenalty(1e6, 0.0), speed=1.0, mass=2.0)
    >>> round(stiffness_for(question, penetration=1e-3).method.stiffness)  # m v²/δ²
    2000000
    """
    if (penetration is None) == (force is None):
        raise ValueError("give either a permitted penetration or a permitted force")
    name, wanted = ("penetration", penetration) if force is None else ("force", force)
    wanted = require(name, wanted, 0.0, 1e12, f"give the permitted {name}", open_low=True)
    alone = replace(question, method=question.method.limit, time_step=0.0)
    e = replace(alone, force=0.0).without_step.restitution

    def at(stiffness: float) -> Impact:
        changed = alone.with_contact(stiffness=stiffness)
        return changed if question.method.damping in (None, 0.0) else changed.with_restitution(e)

    def beyond(stiffness: float) -> bool:
        found = getattr(at(stiffness).without_step, name)
        return found < wanted if force is None else found > wanted

    low = high = question.method.stiffness
    try:
        while beyond(low):
            low /= SEEK
        while not beyond(high):
            high *= SEEK
    except ValueError:  # K or D beyond what a method takes
        raise ValueError(f"{name} = {wanted:g}: no K within the range gives it: take another speed or mass") from None
    ends = (beyond, high, low) if force is None else (lambda stiffness: not beyond(stiffness), low, high)
    found = at(_halved(*ends, 1e-12)).method
    return question.with_contact(found.stiffness, found.damping)
