"""The answer: what a contact gives, without a step and with it."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from vibroscope.engine.drivers.alone import BLOWN_UP, STUCK
from vibroscope.engine.one_impact.instants import FULL, OUTLINE, Fineness, Instants, over_instants
from vibroscope.engine.one_impact.moreau_jean import MoreauJean
from vibroscope.engine.one_impact.question import Impact

GAINED = 1e-9  # restitution beyond one that is not rounding


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


def outline(question: Impact) -> Instants:
    """The restitution over the instants of touch, close enough for a search."""
    return over_instants(question.touches, OUTLINE)
