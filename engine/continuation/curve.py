"""Curves of closed orbits with one sequence of events: pseudo-arclength steps, and roots along them.

A point X = (unknowns, α₁) of a curve solves F(X) = 0, one equation fewer than unknowns. From a point, its tangent leads
to a predicted one; Newton's method brings it back to the curve in the plane orthogonal to the tangent, so that folds
are nothing special (Keller 1977). Distances are scaled: states by their largest, α₁ by the width of its range, instants
by the excitation period.
"""

import math
from collections.abc import Callable
from functools import cached_property

import numpy as np
from vibroscope.engine.continuation.family import Family, ParameterRange
from vibroscope.engine.continuation.orbit import KeptEquations, Margin, Orbit, least_margin, margins, within_cycle
from vibroscope.engine.continuation.roots import Convergence, converges
from vibroscope.engine.continuation.tolerances import (
    ANOTHER_MOTION,
    LONG_CORRECTION,
    LOST_SYMMETRY,
    ROUGH,
    SLOPE_DIFFERENCE,
    STEEP,
)
from vibroscope.engine.drivers.orbit import Evaluation, steps
from vibroscope.engine.methods import ExactPenalty, Reference

# by a slope that is corrected the ratio of two steps stays
IN_PLANE = Convergence(
    2 * steps.NEWTON_STEPS, far=1.0, converged=steps.CONVERGED, stalled=steps.STALLED, following=1e-13
)


class CurvePoint:
    """A point of a curve.

    Parameters
    ----------
    curve : Curve
    orbit : Orbit
    value : float
        α₁.
    towards : (5 + m,) ndarray, optional
        Scaled direction on whose side the tangent points, by default that of growing α₁.
    evaluation : Evaluation, optional
        That of the orbit, if it is known.

    Attributes
    ----------
    evaluation : Evaluation
    around : dict of float to CurvePoint
        Known points of its curve, by the distance along the tangent.
    unknowns : (5 + m,) ndarray
        X.
    scales : (5 + m,) ndarray
        Units in which distances from the orbit count.
    slope : (4 + m,) ndarray
        ∂F/∂α₁.
    tangent : (5 + m,) ndarray
        Scaled, of length one.
    """

    def __init__(
        self,
        curve: "Curve",
        orbit: Orbit,
        value: float,
        towards: np.ndarray | None = None,
        evaluation: Evaluation | None = None,
    ) -> None:
        self._curve, self.orbit, self.value, self._towards = curve, orbit, value, towards
        self.around: dict[float, CurvePoint] = {}
        self.evaluation = curve.evaluate(orbit, value) if evaluation is None else evaluation
        self.unknowns = np.concatenate([orbit.unknowns, (value,)])

    @cached_property
    def scales(self) -> np.ndarray:
        """See the class."""
        return self._curve.scales(self.orbit)

    @cached_property
    def slope(self) -> np.ndarray:
        """See the class; made where it is asked for, since it needs the tables of another α₁."""
        return self._curve.slope(self.orbit, self.value, self.evaluation.residual)

    @cached_property
    def tangent(self) -> np.ndarray:
        """See the class; nan where there is none."""
        tangent = steps.tangent_of(self.evaluation.jacobian, self.slope, self.scales)
        forwards = tangent[-1] if self._towards is None else tangent @ self._towards
        return tangent if forwards >= 0 else -tangent

    def turned(self) -> "CurvePoint":
        """The same point with the opposite tangent."""
        return CurvePoint(self._curve, self.orbit, self.value, -self.tangent, self.evaluation)

    @cached_property
    def multipliers(self) -> np.ndarray:
        """Floquet multipliers of the orbit, (4,), largest first."""
        return self.evaluation.multipliers

    @property
    def method(self) -> Reference | ExactPenalty:
        """The method at its α₁."""
        return self._curve.family.method_at(self.value)

    @property
    def margins(self) -> list[Margin]:
        """What keeps the solution an orbit with its sequence of events."""
        return margins(self.orbit, self.evaluation, self.method)

    @cached_property
    def least_margin(self) -> float:
        """The smallest of them."""
        return least_margin(self.orbit, self.evaluation, self.method)

    @property
    def holds(self) -> bool:
        """Whether it is an orbit with this sequence."""
        return self.least_margin > 0 and bool((np.diff(self.orbit.instants) > 0).all())

    @cached_property
    def along(self) -> np.ndarray:
        """The tangent in the units of X."""
        return self.tangent * self.scales

    @cached_property
    def coordinate(self) -> np.ndarray:
        """The row r with s = r·(X − X₀) for the distance s along the tangent at which :meth:`Curve.ahead` finds X."""
        if abs(self.tangent[-1]) <= STEEP:
            return self.tangent / self.scales
        row = np.zeros(len(self.tangent))
        row[-1] = 1.0 / self.along[-1]
        return row

    def way_to(self, point: "CurvePoint") -> float:
        """The distance along the tangent at which :meth:`Curve.ahead` finds another point."""
        return float(self.coordinate @ (point.unknowns - self.unknowns))

    def predicted(self, s: float) -> np.ndarray:
        """X at a distance along the tangent: the polynomial through the nearest known points.

        Interpolation by divided differences (Newton), at points whose tangent is known with that (Hermite).
        """
        nearest = list(self.around)
        if len(nearest) > 1:
            nearest = sorted(nearest, key=lambda known: abs(known - s))[:2]
        points = [self, *[self.around[known] for known in nearest]]
        values, along = np.empty((2, len(points), len(self.unknowns)))
        for k, point in enumerate(points):
            values[k] = point.unknowns
            along[k] = point.along if "tangent" in point.__dict__ else np.nan
        return steps.interpolated(np.array([0.0, *nearest]), values, along, self.coordinate, s)

    def predicted_slope(self, s: float) -> np.ndarray:
        """∂F/∂α₁ at a distance along the tangent: in a straight line from here to the last point whose own is known."""
        for distance, point in reversed(self.around.items()):
            if "slope" in point.__dict__:
                return self.slope + s / distance * (point.slope - self.slope)
        return self.slope

    def within_cycle(self) -> "CurvePoint":
        """The same orbit with all its events in [0, p)."""
        orbit, turned = within_cycle(self.orbit, self.evaluation, self._curve.equations(self.value))
        if not turned:
            return self
        orbit = self._curve.corrected(orbit, self.value) or orbit  # at a grazing there is nothing to correct with
        towards = np.concatenate([np.zeros(4), np.roll(self.tangent[4:-1], turned), self.tangent[-1:]])
        there = CurvePoint(self._curve, orbit, self.value, towards)
        both = (self.orbit.instants < 0).any() and (self.orbit.instants >= self.orbit.period).any()
        return there.within_cycle() if both else there

    def is_near(self, orbit: Orbit) -> bool:
        """Whether another orbit is near: farther away is another motion."""
        distance = np.abs(orbit.unknowns[:4] - self.orbit.unknowns[:4]).max()
        return bool(distance <= ANOTHER_MOTION * self._curve.scales(orbit)[0])

    def neighbour(self, guess: Orbit, value: float, onwards: float) -> "CurvePoint | None":
        """The orbit near a guess and near this one, its tangent along the sign of ``onwards``, or None."""
        point = self._curve.solved(guess, value, np.append(np.zeros(len(guess.unknowns)), onwards))
        return point if point is not None and self.is_near(point.orbit) else None

    @property
    def extended(self) -> np.ndarray:
        """∂F/∂X, (4 + m, 5 + m)."""
        return np.column_stack([self.evaluation.jacobian, self.slope])


class Curve:
    """The equations of a family over a range of α₁.

    Parameters
    ----------
    family : Family
    span : ParameterRange
        α₁ may leave it by as much as a difference needs.

    Attributes
    ----------
    equations : KeptEquations
        At α₁.
    """

    def __init__(self, family: Family, span: ParameterRange) -> None:
        self.family, self.low, self.high, self.width = family, span.low, span.high, span.width
        self.equations = KeptEquations(family.at)

    def evaluate(self, orbit: Orbit, value: float) -> Evaluation:
        """F, its Jacobian and the facts of an orbit at α₁."""
        return self.equations(value)(orbit.cycle, orbit.unknowns)

    def slope(self, orbit: Orbit, value: float, residual: np.ndarray) -> np.ndarray:
        """∂F/∂α₁ by a difference of first order, backward where α₁ is at the high end of what it may be.

        It turns the tangent, and an orbit is exact whatever the tangent is.
        """
        equations = self.equations(value)
        for h in (SLOPE_DIFFERENCE * self.width, -SLOPE_DIFFERENCE * self.width):
            try:
                problem = self.family.at(value + h)
            except ValueError:
                continue
            return equations.slope(problem, h, orbit.cycle, orbit.unknowns, residual)
        raise ValueError(f"{self.family.over} = {value:g}: the range of what it may be is narrower than {abs(h):g}")

    def scales(self, orbit: Orbit) -> np.ndarray:
        """Units in which distances count, (5 + m,)."""
        return steps.scales_of(orbit.unknowns, self.width)

    def words(self, point: CurvePoint) -> str:
        """Where a point lies."""
        return f"{self.family.over} = {point.value:.10g}"

    # -- borders -------------------------------------------------------------------------------------------------------

    def border_ahead(self, here: CurvePoint) -> tuple[float, float]:
        """How far ahead the end of the range lies to which the tangent points, and that; infinite if to none."""
        along = here.tangent[-1] * self.width
        border = self.high if along > 0 else self.low
        return (border - here.value) / along if along else math.inf, border

    def left(self, border: float) -> str:
        """That the range is left, in words."""
        return f"{self.family.over} leaves the range at {border:g}"

    def at_border(self, here: CurvePoint, way: float, border: float) -> CurvePoint | None:
        """The orbit at an end of the range, about a distance ``way`` along the tangent of another one."""
        guess = here.unknowns + way * here.tangent * here.scales
        return self.solved(here.orbit.at(guess[:-1]), border, here.tangent)

    def within(self, here: CurvePoint, there: CurvePoint) -> tuple[CurvePoint | None, float | None]:
        """The second point, or that at the end of the range if it lies there or beyond; and which end."""
        if self.low < there.value < self.high:
            return there, None
        border = self.low if there.value <= self.low else self.high
        if there.value == border:
            return there, border
        way = self.distance(here, there) * (border - here.value) / (there.value - here.value)
        return self.at_border(here, way, border), border

    def distance(self, here: CurvePoint, there: CurvePoint) -> float:
        """How far ahead along the tangent of one point another one lies."""
        return float((there.unknowns - here.unknowns) / here.scales @ here.tangent)

    # -- solutions -----------------------------------------------------------------------------------------------------

    def corrected(self, orbit: Orbit, value: float) -> Orbit | None:
        """The orbit at this α₁ near a guess; None if Newton's method does not find it."""
        point = self.solved(orbit, value)
        return point and point.orbit

    def solved(self, orbit: Orbit, value: float, towards: np.ndarray | None = None) -> CurvePoint | None:
        """The point at this α₁ near a guess, or None if Newton's method finds none; ``towards``: as for the point."""
        unknowns = orbit.unknowns.copy()
        found = self.equations(value).solve(orbit.cycle, unknowns, self.width)
        return found and CurvePoint(self, orbit.at(unknowns), value, towards, found)

    def along(self, here: CurvePoint) -> Callable[[float], CurvePoint | None]:
        """The point of the curve at each distance along the tangent of one; None where there is none."""
        return lambda s: self.ahead(here, s) if s else here

    def ahead(self, point: CurvePoint, s: float) -> CurvePoint | None:
        """The point at the distance s along the tangent of another one; None if there is none.

        Where the curve is steep enough α₁ is that of the tangent, since the tables of one α₁ then serve all steps of
        Newton's method; near a fold the orbit is sought in the plane orthogonal to the tangent.
        """
        if (known := point.around.get(s)) is not None:
            return known
        guess, predicted = point.unknowns + s * point.along, point.predicted(s)
        orbit, towards = point.orbit.at(predicted[:-1]), point.tangent
        try:
            if abs(towards[-1]) > STEEP:
                found = self.solved(orbit, float(guess[-1]), towards)
            else:
                row = towards / point.scales
                found = self.constrained(
                    orbit, float(predicted[-1]), (row, row @ guess), towards, point.predicted_slope(s)
                )
        except ValueError:  # α₁ is out of its range
            return None
        if found is None:
            return None
        if np.abs(found.evaluation.residual).max() > ROUGH:  # the last steps shrank less than foreseen
            found = self.solved(found.orbit, found.value, towards)
            if found is None or np.abs(found.evaluation.residual).max() > ROUGH:
                return None
        off = (found.unknowns - guess) / point.scales
        if not math.sqrt(off @ off) <= LONG_CORRECTION * abs(s) + 1e3 * steps.CONVERGED:
            return None
        point.around[s] = found
        return found

    def symmetric(self, guess: np.ndarray, near: CurvePoint) -> CurvePoint | None:
        """The orbit between two stops at the α₁ of a guess of X, as symmetric as that is, or None.

        Where symmetry is lost the equations are singular, and Newton's method leads anywhere along what has lost it. In
        steps of least squares that direction has no part. ``near``: a point with the same events.
        """
        x = guess.copy()
        scales, n = self.scales(near.orbit), len(x) - 1
        for _ in range(steps.NEWTON_STEPS):
            found = self.evaluate(near.orbit.at(x[:-1]), float(x[-1]))
            if np.abs(found.residual).max() < ROUGH:
                return CurvePoint(self, near.orbit.at(x[:-1]), float(x[-1]), near.tangent, found)
            if not np.isfinite(found.jacobian).all():
                return None
            step = np.linalg.lstsq(found.jacobian * scales[:n], -found.residual, rcond=LOST_SYMMETRY)[0]
            x[:-1] += step * scales[:n]
        return None

    def constrained(
        self,
        orbit: Orbit,
        value: float,
        plane: tuple[np.ndarray, float],
        towards: np.ndarray,
        slope: np.ndarray | None = None,
    ) -> CurvePoint | None:
        """The point near a guess in a plane, row·X = target; None if Newton's method does not find it.

        ``towards``: as for the point. ``slope``: ∂F/∂α₁ nearby, by default that of the guess. Each step corrects it by
        what the one before missed (Broyden 1965), since a difference would need the tables of another α₁.
        """
        scales, x = self.scales(orbit), np.concatenate([orbit.unknowns, (value,)])
        step, found = np.zeros((len(x), 1)), Evaluation.zeros(len(orbit.kinds))

        def take(before: float) -> float:
            nonlocal slope
            self.equations(float(x[-1]))(orbit.cycle, x[:-1], found)
            if before == np.inf:
                slope = self.slope(orbit, value, found.residual) if slope is None else slope.copy()
            return steps.step_in_plane((found.residual, found.jacobian), scales, plane, x, slope, step)

        return CurvePoint(self, orbit.at(x[:-1]), float(x[-1]), towards) if converges(take, IN_PLANE) else None

    def with_phase(self, guess: Orbit, value: float, i: int, j: int) -> CurvePoint | None:
        """The point near a guess whose phase between events i and j is as long as there; its tangent lengthens it."""
        row = np.zeros(len(guess.unknowns) + 1)
        row[4 + i], row[4 + j] = -1.0, 1.0
        return self.constrained(guess, value, (row, float(guess.instants[j] - guess.instants[i])), row)
