"""The closing speeds of a motion, and what a contact gives at all of them."""

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from vibroscope.engine.contact import check_speed
from vibroscope.engine.drivers.alone import BLOWN_UP, STUCK
from vibroscope.engine.one_impact.forward import Span, instants_of
from vibroscope.engine.one_impact.instants import Instants
from vibroscope.engine.one_impact.question import Impact

CLASSES = 12  # of speeds, of equal width, each solved at its mean


class OverMotion(NamedTuple):
    """What steps make of the contacts of a motion, over its closing speeds and over the instants of touch.

    Least and greatest are over all of them; in means and shares each speed counts as often as it occurs.
    """

    speed: np.ndarray  # (n,), the mean of each class of closing speeds that occurs
    count: np.ndarray  # (n,), how many
    speeds: Span  # of all
    restitution: Span
    penetration: Span  # the deepest of each contact, likewise
    force: Span
    steps: Span  # in which the force acts
    without_solution: float
    blown_up: float
    stuck: float


def over_motion(question: Impact, speeds: Sequence[float] | np.ndarray) -> OverMotion:
    """The contact at all closing speeds of a motion, with the step as it is.

    The restitution of a linear law does not depend on the speed: one solution does for all. Of others speeds are put
    into 12 classes of equal width, whose means are solved, and for the ends the least and the greatest speed.

    Parameters
    ----------
    question : Impact
        Of a method with a time step; its own speed has no part in the answer.
    speeds : (n,) array_like
        Above 0, as often as they occur: :attr:`Impacts.closing_speed` of a run.

    Raises
    ------
    ValueError
        If there is no speed, or one at which there is no such contact; if there is no time step.

    Examples
    --------
    >>> from vibroscope.engine import Impact, TimeStepping, over_motion
    >>> hertz = Impact(TimeStepping(1e6, 1e5, 4, law="hunt-crossley"), 1.0, time_step=1e-3)
    >>> found = over_motion(hertz, [0.5, 0.5, 0.5, 2.0])
    >>> found.count.tolist(), [round(e, 2) for e in found.restitution]
    ([3, 1], [0.79, 0.91, 0.96])
    """
    speeds = np.array([check_speed(each) for each in speeds])
    if not len(speeds):
        raise ValueError("there is no closing speed: give those of a motion in which the bodies meet")
    least, greatest = float(speeds.min()), float(speeds.max())
    which = np.minimum((CLASSES * (speeds - least) / ((greatest - least) or 1.0)).astype(int), CLASSES - 1)
    counts = np.bincount(which)
    means = np.bincount(which, speeds)[counts > 0] / counts[counts > 0]
    counts = counts[counts > 0]
    solved = np.concatenate([means, [least, greatest]])
    weights = np.concatenate([counts, [0, 0]]) / counts.sum()
    found = _solved(question, solved)

    def share(of) -> float:
        return float(weights @ [each.share(of(each)) for each in found])

    def span(of) -> Span:
        ends = np.array([each.ends(of(each)) for each in found])
        known = weights * [each.share(np.isfinite(of(each))) for each in found]
        if not known.sum():
            return Span(np.nan, np.nan, np.nan)
        middle = known[known > 0] @ [each.mean(of(each)) for each, k in zip(found, known, strict=True) if k > 0]
        return Span(float(np.nanmin(ends)), float(middle / known.sum()), float(np.nanmax(ends)))

    return OverMotion(
        means,
        counts,
        Span(least, float(speeds.mean()), greatest),
        span(lambda each: each.restitution),
        span(lambda each: each.depth),
        span(lambda each: each.force),
        span(lambda each: each.steps),
        share(lambda each: each.unsolved),
        share(lambda each: each.code == BLOWN_UP),
        share(lambda each: each.code == STUCK),
    )


def _solved(question: Impact, speeds: np.ndarray) -> list[Instants]:
    """The contact at each of the speeds."""
    if question.depends_on_speed:
        return [instants_of(replace(question, speed=float(speed))) for speed in speeds]
    one = instants_of(question)
    grown = speeds / question.speed
    return [one._replace(depth=one.depth * times, force=one.force * times) for times in grown]
