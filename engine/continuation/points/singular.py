"""Folds, period doublings and Neimark–Sacker points.

At a fold and a doubling A = ∂F/∂(y₀, θ), with M + 1 in place of M − 1 at a doubling, is singular;
at a Neimark–Sacker point the test function of a branch is zero.

With two fixed vectors the bordered matrix [[A, p], [qᵀ, 0]] is regular, and the last component s of its solution for
(0, 1) is zero exactly where A is singular (Govaerts 2000). Its derivative is −wᵀ(∂A)v with the null vectors v and w,
and (∂A/∂X)v is the derivative of ∂F/∂X along v: two evaluations for all unknowns.
"""

import numpy as np
from vibroscope.engine.continuation.kinds import DOUBLING, FOLD, NEIMARK_SACKER, indicator
from vibroscope.engine.continuation.orbit import Orbit
from vibroscope.engine.continuation.points.problem import Place, PointProblem
from vibroscope.engine.continuation.tolerances import BRIEF_CONTACT
from vibroscope.engine.drivers.orbit import event


class Singular(PointProblem):
    """The last component of the solution of the bordered matrix is zero."""

    kinds = (FOLD, DOUBLING)
    _borders: tuple[np.ndarray, np.ndarray, list[tuple[int, int]]] | None = None

    def condition(self, place: Place) -> float:
        """The last component."""
        return self._bordered(place)[2]

    def condition_gradient(self, place: Place) -> np.ndarray:
        """See the module."""
        v, w, _ = self._bordered(place)
        n, found = len(v), np.zeros(len(v) + 2)
        found[:n] = -w @ self.jacobian_along(place, v)
        for k in range(2):
            turned = self.slope(k, place, lambda there: there.evaluation.jacobian * self.scales)
            found[n + k] = -w @ turned @ v
        return found

    def _bordered(self, place: Place) -> tuple[np.ndarray, np.ndarray, float]:
        """The null vectors v and w, and s."""
        if self._borders is None:
            matrix, basis = regular(self.kind, place, self.scales, short := short_pairs(place.orbit))
            u, _, v = np.linalg.svd(matrix)
            self._borders = u[:, -1], v[-1], short
        p, q, short = self._borders
        matrix, basis = regular(self.kind, place, self.scales, short)
        n = len(matrix)
        whole = np.zeros((n + 1, n + 1))
        whole[:n, :n], whole[:n, n], whole[n, :n] = matrix, p, q
        right = np.zeros(n + 1)
        right[n] = 1.0
        one, other = np.linalg.solve(whole, right), np.linalg.solve(whole.T, right)
        return basis @ one[:n], other[:n], float(one[n])

    def curvature(self, place: Place) -> float:
        """wᵀ(∂²F)vv of a fold, which is zero at a cusp; its sign counts between two renewals."""
        v, w, _ = self._bordered(place)
        return float(w @ self.jacobian_along(place, v) @ v)

    def renewed(self) -> None:
        """Choose the bordering vectors anew, those of the next place."""
        self._borders = None


def short_pairs(orbit: Orbit) -> list[tuple[int, int]]:
    """First and last event of short contacts and flights of the penalty; each event belongs to one at most."""
    kinds, instants, found = orbit.at_any_stop, orbit.instants, []
    pairs = [(k, last) for k in range(len(kinds)) if (last := _end_of(kinds, k)) is not None]
    for first, last in sorted(pairs, key=lambda pair: instants[pair[1]] - instants[pair[0]]):
        events = {*range(first, last + 1)}
        short = kinds[first] >= event.TOUCH and instants[last] - instants[first] < BRIEF_CONTACT
        if short and not any(events & {*range(i, j + 1)} for i, j in found):
            found.append((first, last))
    return found


def _end_of(kinds: tuple[int, ...], first: int) -> int | None:
    """The event that ends the contact, or the flight, which another one begins."""
    if kinds[first] == event.TOUCH:
        return next((k for k in range(first + 1, len(kinds)) if kinds[k] == event.PART), None)
    return first + 1 if kinds[first : first + 2] == (event.PART, event.TOUCH) else None


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


class NeimarkSacker(PointProblem):
    """The indicator of a branch is zero."""

    kinds = (NEIMARK_SACKER,)

    def condition(self, place: Place) -> float:
        """The indicator."""
        return indicator(self.kind, place)
