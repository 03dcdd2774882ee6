"""Orbits next to a known one: near a guess, and along its curve."""

from collections.abc import Callable, Iterator, Sequence
from itertools import chain, zip_longest

import numpy as np

from .curve import Curve, CurvePoint
from .orbit import Orbit, within_cycle
from .tolerances import ANOTHER_MOTION
from .tracer import StepControl

WALK, LONGEST_WALK = StepControl(first=1e-5, largest=np.inf, smallest=1e-7, growth=4.0, turn=0.98), 0.03


def point_within_cycle(curve: Curve, point: CurvePoint) -> CurvePoint:
    """The same orbit with all its events in [0, p)."""
    orbit, turned = within_cycle(point.orbit, point.evaluation, curve.equations(point.value))
    if not turned:
        return point
    orbit = curve.corrected(orbit, point.value) or orbit  # at a grazing there is nothing to correct with
    towards = np.concatenate([np.zeros(4), np.roll(point.tangent[4:-1], turned), point.tangent[-1:]])
    there = CurvePoint(curve, orbit, point.value, towards)
    both = (point.orbit.instants < 0).any() and (point.orbit.instants >= point.orbit.period).any()
    return point_within_cycle(curve, there) if both else there


def is_near(curve: Curve, last: CurvePoint, orbit: Orbit) -> bool:
    """Whether an orbit is near the last one: farther away is another motion."""
    return bool(np.abs(orbit.unknowns[:4] - last.orbit.unknowns[:4]).max() <= ANOTHER_MOTION * curve.scales(orbit)[0])


def orbit_near(curve: Curve, last: CurvePoint, guess: Orbit, value: float, onwards: float) -> CurvePoint | None:
    """The orbit near a guess and near the last one, its tangent along the sign of ``onwards``."""
    point = curve.solved(guess, value, np.append(np.zeros(len(guess.unknowns)), onwards))
    return point if point is not None and is_near(curve, last, point.orbit) else None


def walk(curve: Curve, point: CurvePoint) -> Iterator[CurvePoint]:
    """Orbits ahead of one, at distances that grow up to LONGEST_WALK, one after the other: there may be folds."""
    way, step = 0.0, WALK.first
    while way < LONGEST_WALK:
        at = curve.along(point)
        there, step = WALK.shrunk(at, point, at(step), step)
        if there is None:
            return
        way, step, point = way + step, WALK.following(step, point, there), there
        yield there


def first_ahead(
    curve: Curve, starts: Sequence[CurvePoint], leads_on: Callable[[float], bool] = lambda _: True
) -> CurvePoint | None:
    """The first orbit ahead of one of these whose sequence holds, at an α₁ that leads on."""
    points = chain.from_iterable(zip_longest(*(walk(curve, start) for start in starts)))
    return next((point for point in points if point is not None and leads_on(point.value) and point.holds), None)
