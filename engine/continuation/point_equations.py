"""The equations of a bifurcation point in two numbers: those of its orbit, and one condition more.

The unknowns are X = (y₀, θ, a, b): those of the orbit (:mod:`..kernels.event_driven.orbit`), and where λ and μ lie in
their ranges. A fold or a period doubling is where A = ∂F/∂(y₀, θ), with M + 1 in place of M − 1 at a doubling, is
singular: with two fixed vectors the bordered matrix [[A, p], [qᵀ, 0]] is regular, and the last component s of its
solution for (0, 1) is zero exactly where A is singular (Govaerts 2000). Its derivative is −wᵀ(∂A)v with the null
vectors v and w, and (∂A/∂X)v is the derivative of ∂F/∂X along v: two evaluations for all unknowns.

At a grazing the instant of the touch is an unknown like that of an event, and its closing speed is zero. It is an
impact of the reference; of the penalty it is a *marker*, an event without effect, since both events of a contact fall
together.
"""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from ..drivers.orbit import CLOSING, PART, TOUCH
from .margins import DOUBLING, FOLD, GRAZING, indicator
from .newton import Convergence, converges
from .orbit import Orbit
from .plane import Place, Plane

DIFFERENCE = 1e-6  # scaled, of differences
SHORT = 0.02  # excitation periods, of a contact of the penalty
NEWTON = Convergence(12, far=0.2, converged=1e-11, stalled=1e-8)
SLOW = 0.5  # ratio of two steps of Newton's method, above which the derivatives are renewed


class Condition:
    """What is zero at a point of a kind.

    Parameters
    ----------
    kind : str
        A fold, a period doubling, a Neimark–Sacker point or a grazing.
    touch : int, optional
        The event that is the touch of the grazing orbit.
    """

    def __init__(self, kind: str, touch: int | None = None) -> None:
        self.kind, self.touch = kind, touch
        self._borders: tuple[np.ndarray, np.ndarray, list[tuple[int, int]]] | None = None

    def value(self, plane: Plane, place: Place, scales: np.ndarray) -> float:
        """The condition."""
        if self.kind == GRAZING:
            return float(place.evaluation.facts[self.touch, CLOSING] / scales[0])
        if self.kind not in (FOLD, DOUBLING):
            return indicator(self.kind, place)
        return self._bordered(place, scales)[2]

    def gradient(self, plane: Plane, place: Place, scales: np.ndarray) -> np.ndarray:
        """Its derivative in scaled X, (n + 2,)."""
        if self.kind not in (FOLD, DOUBLING):
            return gradient_of(lambda there: self.value(plane, there, scales), plane, place, scales)
        v, w, _ = self._bordered(place, scales)
        n, found = len(v), np.zeros(len(v) + 2)
        found[:n] = -w @ _along(plane, place, scales, v)
        for k in range(2):
            turned = _difference(plane, place, scales, _unit(n, k), lambda there: there.evaluation.jacobian * scales)
            found[n + k] = -w @ turned @ v
        return found

    def _bordered(self, place: Place, scales: np.ndarray) -> tuple[np.ndarray, np.ndarray, float]:
        """The null vectors v and w, and s."""
        if self._borders is None:
            matrix, basis = regular(self.kind, place, scales, short := short_pairs(place.orbit))
            u, _, v = np.linalg.svd(matrix)
            self._borders = u[:, -1], v[-1], short
        p, q, short = self._borders
        matrix, basis = regular(self.kind, place, scales, short)
        n = len(matrix)
        whole = np.zeros((n + 1, n + 1))
        whole[:n, :n], whole[:n, n], whole[n, :n] = matrix, p, q
        right = np.zeros(n + 1)
        right[n] = 1.0
        one, other = np.linalg.solve(whole, right), np.linalg.solve(whole.T, right)
        return basis @ one[:n], other[:n], float(one[n])

    def curvature(self, plane: Plane, place: Place, scales: np.ndarray) -> float:
        """wᵀ(∂²F)vv of a fold, which is zero at a cusp; its sign counts between two renewals."""
        v, w, _ = self._bordered(place, scales)
        return float(w @ _along(plane, place, scales, v) @ v)

    def renewed(self) -> None:
        """Choose the bordering vectors anew, those of the next place."""
        self._borders = None


def short_pairs(orbit: Orbit) -> list[tuple[int, int]]:
    """First and last event of short contacts and flights of the penalty; each event belongs to one at most."""
    kinds, instants, found = orbit.kinds, orbit.instants, []
    pairs = [(k, last) for k in range(len(kinds)) if (last := _end_of(kinds, k)) is not None]
    for first, last in sorted(pairs, key=lambda pair: instants[pair[1]] - instants[pair[0]]):
        events = {*range(first, last + 1)}
        short = kinds[first] >= TOUCH and instants[last] - instants[first] < SHORT
        if short and not any(events & {*range(i, j + 1)} for i, j in found):
            found.append((first, last))
    return found


def _end_of(kinds: tuple[int, ...], first: int) -> int | None:
    """The event that ends the contact, or the flight, which another one begins."""
    if kinds[first] == TOUCH:
        return next((k for k in range(first + 1, len(kinds)) if kinds[k] == PART), None)
    return first + 1 if kinds[first : first + 2] == (PART, TOUCH) else None


def regular(kind: str, place: Place, scales: np.ndarray, short: list[tuple[int, int]]) -> tuple[np.ndarray, np.ndarray]:
    """The matrix that is singular at a fold or a doubling, and at no grazing, in a basis; and that basis, (n, n) each.

    As a contact of the penalty shrinks to nothing, its length no longer counts in the equations: their derivative in it
    falls with it. The basis takes middle and squared length of a short contact for the instants of its two ends. Raises
    ValueError where there is no length.
    """
    matrix = place.evaluation.jacobian * scales
    basis = np.eye(len(scales))
    if kind == DOUBLING:
        matrix[range(4), range(4)] += 2.0 * scales[:4]
    for first, last in short:
        length = place.orbit.instants[last] - place.orbit.instants[first]
        if not length:
            raise ValueError("a contact has no length")
        both = [4 + first, 4 + last]
        basis[np.ix_(both, both)] = [[1.0, -1.0 / length], [1.0, 1.0 / length]]
    return matrix @ basis, basis


def slopes(plane: Plane, place: Place, scales: np.ndarray) -> np.ndarray:
    """∂F/∂(a, b), (n, 2)."""
    n = len(scales)
    return np.column_stack(
        [_difference(plane, place, scales, _unit(n, k), lambda there: there.evaluation.residual) for k in range(2)]
    )


def gradient_of(value: Callable[[Place], float], plane: Plane, place: Place, scales: np.ndarray) -> np.ndarray:
    """The derivative of a number in scaled X, (n + 2,), by differences."""
    steps = DIFFERENCE * np.eye(len(scales) + 2)
    return np.array([_difference(plane, place, scales, step, value) for step in steps])


def _along(plane: Plane, place: Place, scales: np.ndarray, v: np.ndarray) -> np.ndarray:
    """The derivative of ∂F/∂(y₀, θ), scaled, along a vector, (n, n)."""
    size = np.linalg.norm(v)
    step = DIFFERENCE * np.append(v / size, [0.0, 0.0])
    return size * _difference(plane, place, scales, step, lambda there: there.evaluation.jacobian * scales)


def _unit(n: int, k: int) -> np.ndarray:
    step = np.zeros(n + 2)
    step[n + k] = DIFFERENCE
    return step


def _difference(plane: Plane, place: Place, scales: np.ndarray, step: np.ndarray, value: Callable):
    """Derivative along a step in scaled X, for a step of the length DIFFERENCE; one-sided at the end of a range.

    Raises
    ------
    ValueError
        If a number is out of its range on both sides.
    """
    ends = []
    for way in (1.0, -1.0):
        try:
            ends.append((way, value(moved(plane, place, scales, way * step))))
        except ValueError:
            continue
    if len(ends) == 2:
        return (ends[0][1] - ends[1][1]) / (2 * DIFFERENCE)
    if not ends:
        raise ValueError("a number is out of its range")
    way, near = ends[0]
    far = value(moved(plane, place, scales, 2 * way * step))
    return way * (4 * near - far - 3 * value(place)) / (2 * DIFFERENCE)


def moved(plane: Plane, place: Place, scales: np.ndarray, step: np.ndarray) -> Place:
    """The equations a scaled step (n + 2,) away."""
    n = len(scales)
    return plane.at(replace(place.orbit, unknowns=place.orbit.unknowns + step[:n] * scales), place.shares + step[n:])


class Equations:
    """The equations of points of one kind, with one sequence of events."""

    def __init__(self, plane: Plane, condition: Condition, orbit: Orbit) -> None:
        self.plane, self.condition = plane, condition
        size = max(np.abs(orbit.unknowns[:4]).max(), 1e-9)
        self.scales = np.concatenate([np.full(4, size), np.ones(len(orbit.kinds))])

    def matrix(self, place: Place) -> np.ndarray:
        """Derivative of all equations in scaled X, (n + 1, n + 2); raises ValueError where there is none."""
        n = len(self.scales)
        found = np.zeros((n + 1, n + 2))
        found[:n, :n] = place.evaluation.jacobian * self.scales
        found[:n, n:] = slopes(self.plane, place, self.scales)
        found[n] = self.condition.gradient(self.plane, place, self.scales)
        return found

    def solved(
        self, guess: Place, row: np.ndarray, last: Callable[[Place], float], matrix: np.ndarray | None = None
    ) -> Place | None:
        """The solution near a guess at which one number more is zero; None if Newton's method does not find it.

        Parameters
        ----------
        guess : Place
        row : (n + 2,) ndarray
            Derivative of that number in scaled X.
        last : callable
            The number at a place.
        matrix : (n + 1, n + 2) ndarray, optional
            Derivatives nearby; those in the orbit's unknowns are renewed, all are updated by Broyden's method.
        """
        n, place, step, slow = len(self.scales), guess, None, False

        def take(before: float) -> float:
            nonlocal place, step, slow
            residual = self._residual(place, last)
            if slow:
                matrix[:-1] = self.matrix(place)
            elif step is not None:
                matrix[:] += np.outer(residual, step) / (step @ step)
            step = np.linalg.solve(matrix, -residual)
            length = float(np.abs(step).max())
            if length < NEWTON.far:
                place, slow = moved(self.plane, place, self.scales, step), length > SLOW * before
            return length

        try:
            matrix = np.vstack([self.matrix(place) if matrix is None else matrix, row])
            matrix[:n, :n] = place.evaluation.jacobian * self.scales
            return place if converges(take, NEWTON) else None
        except (ValueError, np.linalg.LinAlgError):
            return None

    def _residual(self, place: Place, last: Callable[[Place], float]) -> np.ndarray:
        condition = self.condition.value(self.plane, place, self.scales)
        return np.concatenate([place.evaluation.residual, [condition, last(place)]])
