"""Curves of closed orbits with one sequence of events: pseudo-arclength steps, and roots along them.

A point X = (unknowns, α₁) of a curve solves F(X) = 0, one equation fewer than unknowns. From a point, its tangent leads
to a predicted one; Newton's method brings it back to the curve in the plane orthogonal to the tangent, so that folds
are nothing special (Keller 1977). Distances are scaled: states by their largest, α₁ by the width of its range, instants
by the excitation period.
"""

from functools import cached_property

import numpy as np

from ..drivers.law_orbit import LawOrbitEquations, equations_of
from ..drivers.orbit import Evaluation, OrbitEquations
from ..drivers.orbit_steps import scales_of, step_at_value, step_in_plane, tangent_of
from .family import Family
from .orbit import Orbit
from .parameter_range import ParameterRange

NEWTON_STEPS = 10
CONVERGED = 1e-10  # scaled step of Newton's method, after which the next would be rounding
STALLED = 1e-7  # the same, where rounding prevents any smaller
DIFFERENCE = 1e-6  # of the width of the range, of central differences in α₁
STEEP = 0.01  # component of the tangent along α₁
FAR = 0.5  # of a step: a correction as long as that leads to another curve


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

    Attributes
    ----------
    evaluation : Evaluation
    slope : (4 + m,) ndarray
        ∂F/∂α₁.
    tangent : (5 + m,) ndarray
        Scaled, of length one.
    """

    def __init__(self, curve: "Curve", orbit: Orbit, value: float, towards: np.ndarray | None = None) -> None:
        self._curve, self.orbit, self.value, self._towards = curve, orbit, value, towards
        self._solved: dict[float, np.ndarray] = {}  # X on its curve, by the distance along the tangent
        self.evaluation: Evaluation = curve.evaluate(orbit, value)

    @cached_property
    def slope(self) -> np.ndarray:
        """See the class; made where it is asked for, since it needs the tables of two more α₁."""
        return self._curve.slope(self.orbit, self.value)

    @cached_property
    def tangent(self) -> np.ndarray:
        """See the class; nan where there is none."""
        tangent = tangent_of(self.evaluation.jacobian, self.slope, self.scales)
        forwards = tangent[-1] if self._towards is None else tangent @ self._towards
        return tangent if forwards >= 0 else -tangent

    def turned(self) -> "CurvePoint":
        """The same point with the opposite tangent."""
        return CurvePoint(self._curve, self.orbit, self.value, -self.tangent)

    @cached_property
    def unknowns(self) -> np.ndarray:
        """X, (5 + m,)."""
        return np.append(self.orbit.unknowns, self.value)

    @cached_property
    def scales(self) -> np.ndarray:
        """Units in which distances from the orbit count, (5 + m,)."""
        return self._curve.scales(self.orbit)

    def remember(self, s: float, unknowns: np.ndarray) -> None:
        """Note the X of the curve at a distance along the tangent."""
        self._solved[s] = unknowns

    def predicted(self, s: float) -> np.ndarray:
        """X at a distance along the tangent: the parabola, or cubic, through the nearest known ones.

        Interpolation by divided differences (Newton) with the tangent at 0.
        """
        along = self.tangent * self.scales
        found = self.unknowns + s * along
        nearest = sorted(self._solved, key=lambda known: abs(known - s))[:2]
        bends = [(self._solved[known] - self.unknowns - known * along) / known**2 for known in nearest]
        if bends:
            found = found + s**2 * bends[0]
        if len(bends) == 2:
            found = found + s**2 * (s - nearest[0]) * (bends[1] - bends[0]) / (nearest[1] - nearest[0])
        return found

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
    """

    def __init__(self, family: Family, span: ParameterRange) -> None:
        self.family, self.low, self.high, self.width = family, span.low, span.high, span.width
        self._known: dict[float, OrbitEquations | LawOrbitEquations] = {}

    def equations(self, value: float) -> OrbitEquations | LawOrbitEquations:
        """The equations at α₁; the last ones are kept."""
        found = self._known.get(value)
        if found is None:
            last = next(reversed(self._known.values()), None)
            if len(self._known) > 8:
                self._known.clear()
            found = self._known[value] = equations_of(*self.family.at(value), like=last)
        return found

    def evaluate(self, orbit: Orbit, value: float) -> Evaluation:
        """F, its Jacobian and the facts of an orbit at α₁."""
        return self.equations(value)(orbit.kinds, orbit.first, orbit.period, orbit.unknowns)

    def slope(self, orbit: Orbit, value: float) -> np.ndarray:
        """∂F/∂α₁ by differences of second order: central, or one-sided where α₁ is at the end of what it may be."""
        h, equations = DIFFERENCE * self.width, self.equations(value)
        for offsets in ((-h, h), (0.0, h, 2 * h), (0.0, -h, -2 * h)):
            try:
                problems = [self.family.at(value + offset) for offset in offsets]
            except ValueError:
                continue
            values = equations.residuals(problems, orbit.kinds, orbit.first, orbit.period, orbit.unknowns)
            if len(values) == 2:
                return (values[1] - values[0]) / (2 * h)
            return (4 * values[1] - 3 * values[0] - values[2]) / (2 * offsets[1])
        raise ValueError(f"{self.family.over} = {value:g}: the range of what it may be is narrower than {4 * h:g}")

    def scales(self, orbit: Orbit) -> np.ndarray:
        """Units in which distances count, (5 + m,)."""
        return scales_of(orbit.unknowns, self.width)

    def corrected(self, orbit: Orbit, value: float) -> Orbit | None:
        """The orbit at this α₁ near a guess; None if Newton's method does not find it."""
        equations, scales = self.equations(value), self.scales(orbit)
        unknowns, before, out = orbit.unknowns.copy(), np.inf, Evaluation.without_facts(len(orbit.kinds))
        for _ in range(NEWTON_STEPS):
            found = equations(orbit.kinds, orbit.first, orbit.period, unknowns, out)
            length = step_at_value(found.residual, found.jacobian, scales, unknowns)
            if not length < 1e3 or (length >= before and length > STALLED):
                return None
            if length < CONVERGED or length >= before or _next_step(length, before) < CONVERGED:
                return orbit.at(unknowns)
            before = length
        return orbit.at(unknowns) if before < STALLED else None

    def ahead(self, point: CurvePoint, s: float) -> tuple[Orbit, float] | None:
        """The orbit and α₁ at the distance s along the tangent of a point; None if there is none.

        Where the curve is steep enough α₁ is that of the tangent, since the tables of one α₁ then serve all steps of
        Newton's method; near a fold the orbit is sought in the plane orthogonal to the tangent.
        """
        scales = point.scales
        guess, predicted = point.unknowns + s * point.tangent * scales, point.predicted(s)
        orbit = point.orbit.at(predicted[:-1])
        try:
            if abs(point.tangent[-1]) > STEEP:
                orbit = self.corrected(orbit, float(guess[-1]))
                found = orbit and (orbit, float(guess[-1]))
            else:
                row = point.tangent / scales
                found = self.constrained(orbit, float(predicted[-1]), row, row @ guess, point.slope)
        except ValueError:  # α₁ is out of its range
            return None
        if found is None:
            return None
        unknowns = np.append(found[0].unknowns, found[1])
        if not np.linalg.norm((unknowns - guess) / scales) <= FAR * abs(s) + 1e3 * CONVERGED:
            return None
        point.remember(s, unknowns)
        return found

    def constrained(
        self, orbit: Orbit, value: float, row: np.ndarray, target: float, slope: np.ndarray | None = None
    ) -> tuple[Orbit, float] | None:
        """The orbit and α₁ near a guess at which row·X has a given value; None if Newton's method does not find it.

        ``slope``: ∂F/∂α₁ nearby, by default that of the guess. Each step corrects it by what the one before missed
        (Broyden 1965), since differences would need the tables of two more α₁.
        """
        slope = (self.slope(orbit, value) if slope is None else slope).copy()
        scales, x, before = self.scales(orbit), np.append(orbit.unknowns, value), np.inf
        step, out = np.zeros((len(x), 1)), Evaluation.without_facts(len(orbit.kinds))
        for _ in range(2 * NEWTON_STEPS):
            found = self.equations(float(x[-1]))(orbit.kinds, orbit.first, orbit.period, x[:-1], out)
            length = step_in_plane((found.residual, found.jacobian), scales, (row, float(target)), x, slope, step)
            if not length < 1.0:
                return None
            if length < CONVERGED or (length >= before and before < STALLED):
                return orbit.at(x[:-1].copy()), float(x[-1])
            before = length
        return None


def _next_step(length: float, before: float) -> float:
    """About how long the next step of Newton's method is, by its quadratic convergence; infinite after the first."""
    return length * (length / before) ** 2 if before < np.inf else np.inf


def null_vectors(matrix: np.ndarray) -> np.ndarray:
    """Two vectors of length one that a matrix with one column more than rows, of a rank one too low, maps to zero."""
    return np.linalg.svd(matrix)[2][-2:]
