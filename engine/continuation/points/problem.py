"""Points of a kind in two numbers as a problem: the equations of their orbits, one condition more, and its derivative.

The unknowns are X = (y₀, θ, a, b): those of the orbit (:mod:`...kernels.event_driven.orbit`), and the shares of α₁ and
α₂ in their ranges. The solutions are a curve for the tracer (:mod:`..tracer`).
"""

import abc
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np
from vibroscope.engine.continuation.family import Family, ParameterRange
from vibroscope.engine.continuation.orbit import KeptEquations, Margin, Orbit, margins
from vibroscope.engine.continuation.roots import Convergence, converges
from vibroscope.engine.continuation.tolerances import (
    AT_BORDER,
    CORRECTION_ROUNDING,
    LONG_POINT_CORRECTION,
    POINT_DIFFERENCE,
    SLOW,
)
from vibroscope.engine.drivers.orbit import Evaluation, OrbitEquations, steps
from vibroscope.engine.motions.poincare_map import size_of

NEWTON = Convergence(12, far=0.2, converged=1e-11, stalled=1e-8)


@dataclass(frozen=True)
class Place:
    """A solution, or a guess: the orbit, the shares of both numbers, and what the equations say there.

    On a curve also the problem that it solves, their derivatives, and the tangent; all scaled.
    """

    orbit: Orbit
    shares: np.ndarray
    evaluation: Evaluation
    problem: object = None
    matrix: np.ndarray | None = None
    tangent: np.ndarray | None = None

    def scaled(self, scales: np.ndarray) -> np.ndarray:
        """X in units of ``scales``, (n + 2,)."""
        return np.append(self.orbit.unknowns / scales, self.shares)


class Plane:
    """The problems over two numbers; the tables of the last few are kept."""

    def __init__(self, over: Family, along: Family, axes: tuple[ParameterRange, ParameterRange]) -> None:
        self.over, self.along, self.axes = over, along, axes
        self._equations = KeptEquations(self.problem)

    @property
    def rigid(self) -> bool:
        """Whether impacts are instantaneous."""
        return self.over.method.rigid

    def values(self, shares: np.ndarray) -> tuple[float, float]:
        """α₁ and α₂ at shares of their ranges."""
        return self.axes[0].value(float(shares[0])), self.axes[1].value(float(shares[1]))

    def words(self, shares: np.ndarray) -> str:
        """Both numbers."""
        return ", ".join(
            f"{axis.name} = {value:.8g}" for axis, value in zip(self.axes, self.values(shares), strict=True)
        )

    def problem(self, *shares: float) -> tuple:
        """System, η and method."""
        value, along = self.values(shares)
        system, eta, method = self.along.at(along)
        return Family(self.over.over, system, eta, method).at(value)

    def equations(self, shares: np.ndarray) -> OrbitEquations:
        """The equations at shares of the ranges; raises ValueError where a number is out of its range."""
        return self._equations(*map(float, shares))

    def at(self, orbit: Orbit, shares: np.ndarray) -> Place:
        """The equations of an orbit at shares of the ranges."""
        found = self.equations(shares)(orbit.cycle, orbit.unknowns)
        return Place(orbit, np.asarray(shares, dtype=float), found)

    def margins(self, place: Place) -> list[Margin]:
        """What keeps it an orbit."""
        return margins(place.orbit, place.evaluation, self.problem(*place.shares)[2])


class PointProblem(abc.ABC):
    """The equations of points of one kind, with one sequence of events; a subclass is that of the kinds it names.

    Parameters
    ----------
    kind : str
        Of the points.
    plane : Plane
    orbit : Orbit
        One of them, or a guess.
    event : int, optional
        The event of the cycle that the condition is about.
    """

    kinds: tuple[str, ...] = ()
    by_kind: ClassVar[dict[str, type["PointProblem"]]] = {}

    def __init_subclass__(cls) -> None:
        cls.by_kind.update(dict.fromkeys(cls.kinds, cls))

    def __init__(self, kind: str, plane: Plane, orbit: Orbit, event: int | None = None) -> None:
        self.kind, self.plane, self.event = kind, plane, event
        size = size_of(orbit.unknowns[:4])
        self.scales = np.concatenate([np.full(4, size), np.ones(len(orbit.kinds))])

    # -- what is special to a kind -------------------------------------------------------------------------------------

    @classmethod
    def serves(cls, kind: str, rigid: bool) -> bool:
        """Whether points of a kind are followed, with rigid bodies or with compliant ones."""
        return True

    @classmethod
    def begun(cls, kind: str, plane: Plane, place: Place) -> Iterator[tuple["PointProblem", Orbit]]:
        """Problems that may be meant at the orbit of a point, with guesses of the orbit, the likeliest first."""
        yield cls(kind, plane, place.orbit), place.orbit

    @abc.abstractmethod
    def condition(self, place: Place) -> float:
        """What is zero at a point, beside the equations of its orbit."""

    def condition_gradient(self, place: Place) -> np.ndarray:
        """Its derivative in scaled X, (n + 2,)."""
        return self.gradient(self.condition, place)

    def is_own(self, margin: Margin, place: Place) -> bool:
        """Whether a margin is zero all along the curve, and so does not end it."""
        return False

    def renewed(self) -> None:  # noqa: B027 - most kinds have nothing to choose
        """Choose what is arbitrary in the condition anew, at the next place."""

    def turned(self, turn: int, orbit: Orbit) -> "PointProblem":
        """The same with the events of the cycle counted from another one."""
        event = None if self.event is None else (self.event + turn) % len(orbit.kinds)
        return type(self)(self.kind, self.plane, orbit, event)

    # -- the sequence of events ----------------------------------------------------------------------------------------

    def margins(self, place: Place) -> list[Margin]:
        """What keeps the orbit one of this sequence, but for what is zero all along the curve."""
        found = self.plane.margins(place)
        return [margin for margin in found if not self.is_own(margin, place)]

    def least_margin(self, place: Place) -> float:
        """The smallest of them; infinite where there is none."""
        return min((margin.value for margin in self.margins(place)), default=np.inf)

    # -- derivatives ---------------------------------------------------------------------------------------------------

    def moved(self, place: Place, step: np.ndarray) -> Place:
        """The equations a scaled step (n + 2,) away."""
        n, orbit = len(self.scales), place.orbit
        return self.plane.at(orbit.at(orbit.unknowns + step[:n] * self.scales), place.shares + step[n:])

    def gradient(self, value: Callable[[Place], float], place: Place) -> np.ndarray:
        """The derivative of a number in scaled X, (n + 2,), by differences."""
        return np.array(
            [self._difference(place, step, value) for step in POINT_DIFFERENCE * np.eye(len(self.scales) + 2)]
        )

    def slope(self, k: int, place: Place, value: Callable[[Place], np.ndarray]) -> np.ndarray:
        """The derivative of an array in the share of one of both numbers."""
        step = np.zeros(len(self.scales) + 2)
        step[len(self.scales) + k] = POINT_DIFFERENCE
        return self._difference(place, step, value)

    def jacobian_along(self, place: Place, v: np.ndarray) -> np.ndarray:
        """The derivative of ∂F/∂(y₀, θ), scaled, along a vector, (n, n)."""
        size = np.linalg.norm(v)
        step = POINT_DIFFERENCE * np.append(v / size, [0.0, 0.0])
        return size * self._difference(place, step, lambda there: there.evaluation.jacobian * self.scales)

    def _difference(self, place: Place, step: np.ndarray, value: Callable):
        """Derivative along a step in scaled X, over a length of POINT_DIFFERENCE; one-sided at the end of a range.

        Raises
        ------
        ValueError
            If a number is out of its range on both sides.
        """
        ends = []
        for way in (1.0, -1.0):
            try:
                ends.append((way, value(self.moved(place, way * step))))
            except ValueError:
                continue
        if len(ends) == 2:
            return (ends[0][1] - ends[1][1]) / (2 * POINT_DIFFERENCE)
        if not ends:
            raise ValueError("a number is out of its range")
        way, near = ends[0]
        far = value(self.moved(place, 2 * way * step))
        return way * (4 * near - far - 3 * value(place)) / (2 * POINT_DIFFERENCE)

    def directed(self, place: Place, towards: np.ndarray) -> Place | None:
        """A place on the curve with its tangent, on the side of a vector; None where there is none."""
        self.renewed()
        try:
            matrix = self.matrix(place)
        except ValueError:
            return None
        tangent = steps.null_vector(matrix)
        if not np.isfinite(tangent).all():
            return None
        tangent = tangent if tangent @ towards >= 0 else -tangent
        return replace(place, matrix=matrix, tangent=tangent)

    def matrix(self, place: Place) -> np.ndarray:
        """Derivative of all equations in scaled X, (n + 1, n + 2); raises ValueError where there is none."""
        n = len(self.scales)
        found = np.zeros((n + 1, n + 2))
        found[:n, :n] = place.evaluation.jacobian * self.scales
        for k in range(2):
            found[:n, n + k] = self.slope(k, place, lambda there: there.evaluation.residual)
        found[n] = self.condition_gradient(place)
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
                place, slow = self.moved(place, step), length > SLOW * before
            return length

        try:
            matrix = np.vstack([self.matrix(place) if matrix is None else matrix, row])
            matrix[:n, :n] = place.evaluation.jacobian * self.scales
            return place if converges(take, NEWTON) else None
        except (ValueError, np.linalg.LinAlgError):
            return None

    def at_share(self, guess: Place, k: int, share: float) -> Place | None:
        """The solution near a guess where one of both numbers has a share of its range."""
        row = np.zeros(len(self.scales) + 2)
        row[len(self.scales) + k] = 1.0
        return self.solved(guess, row, lambda there: there.shares[k] - share)

    def _residual(self, place: Place, last: Callable[[Place], float]) -> np.ndarray:
        return np.concatenate([place.evaluation.residual, [self.condition(place), last(place)]])

    # -- the curve -----------------------------------------------------------------------------------------------------

    def along(self, here: Place) -> Callable[[float], Place | None]:
        """The place at each distance along the tangent of one; None where there is none."""
        return lambda s: self._near(here, s, self._target(here, s)) if s else here

    def distance(self, here: Place, there: Place) -> float:
        """How far ahead along the tangent of one place another one lies."""
        return float(here.tangent @ (there.scaled(self.scales) - here.scaled(self.scales)))

    def border_ahead(self, here: Place) -> tuple[float, tuple[int, float]]:
        """How far ahead the border lies to which the tangent points, and that: which number, and its share."""
        rates = here.tangent[len(self.scales) :]
        borders = [(k, float(rate > 0)) for k, rate in enumerate(rates)]
        ways = [(share - here.shares[k]) / rates[k] if rates[k] else np.inf for k, share in borders]
        return min(zip(ways, borders, strict=True))

    def left(self, border: tuple[int, float]) -> str:
        """That a range is left, in words."""
        return f"{self.plane.axes[border[0]].name} leaves the range"

    def at_border(self, here: Place, way: float, border: tuple[int, float]) -> Place | None:
        """The place on a border, about a distance ``way`` along the tangent of another one."""
        k, share = border
        target = self._target(here, way)
        target[len(self.scales) + k] = share
        return self._near(here, way, target, border)

    def within(self, here: Place, there: Place) -> tuple[Place | None, tuple[int, float] | None]:
        """The second place, or that on the border if it lies there or beyond; and which, the first that is passed."""
        passed = []
        for k, (one, other) in enumerate(zip(here.shares, there.shares, strict=True)):
            if not AT_BORDER < other < 1 - AT_BORDER:
                border = float(other > 0.5)
                passed.append(((border - one) / (other - one), (k, border)))
        if not passed:
            return there, None
        part, border = min(passed)
        if abs(part - 1) < AT_BORDER:
            return there, border
        guess = between(self.plane, here, there, part)
        return guess and self.at_share(guess, *border), border

    def _target(self, here: Place, s: float) -> np.ndarray:
        return here.scaled(self.scales) + s * here.tangent

    def _near(self, here: Place, s: float, target: np.ndarray, border: tuple[int, float] | None = None) -> Place | None:
        """The place near a target ``s`` ahead, on a border or in the plane orthogonal to the tangent."""
        n, scales = len(self.scales), self.scales
        try:
            guess = self.plane.at(here.orbit.at(target[:n] * scales), target[n:])
        except ValueError:
            return None
        if border is not None:
            found = self.at_share(guess, *border)
        else:
            last = lambda there: here.tangent @ (there.scaled(scales) - target)  # noqa: E731
            found = self.solved(guess, here.tangent, last, here.matrix)
        far = np.inf if found is None else np.linalg.norm(found.scaled(scales) - target)
        return found if far <= LONG_POINT_CORRECTION * abs(s) + CORRECTION_ROUNDING else None


def between(plane: Plane, here: Place, there: Place, part: float) -> Place | None:
    """A guess between two places with the same sequence; None where a number is out of its range."""
    one, other = here.orbit.unknowns, there.orbit.unknowns
    orbit = replace(here.orbit, unknowns=one + part * (other - one))
    try:
        return plane.at(orbit, here.shares + part * (there.shares - here.shares))
    except ValueError:
        return None
