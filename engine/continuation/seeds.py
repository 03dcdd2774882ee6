"""Motions from which branches are followed: what runs settle to, slowly or not, and unstable ones amid them.

A run that has not settled yet, but nearly repeats itself, lies near an orbit that Newton's method finds. The mean of a
cycle lies near the unstable motion from which its period doubled or trebled.
"""

from collections import Counter
from collections.abc import Iterator, Sequence

import numpy as np
from vibroscope.engine.arguments import Poll
from vibroscope.engine.cells import CellResults, Cells, run_cells
from vibroscope.engine.continuation.curve import Curve, CurvePoint
from vibroscope.engine.continuation.orbit import Orbit, least_period, orbit_of_run
from vibroscope.engine.continuation.sequences import on_its_sequence
from vibroscope.engine.continuation.tolerances import (
    BESIDE_SEQUENCE,
    NEARLY_RETURNS,
    RETURNS_CLOSELY,
    SAME_ORBIT,
    ZERO_MARGIN,
)
from vibroscope.engine.facts import Symbol, equation, stated
from vibroscope.engine.motions.poincare_map import PoincareMap, may_be_stable, size_of
from vibroscope.engine.motions.search import apart, random_states, reach_of
from vibroscope.engine.motions.steady import fixed_point, near_returns, steady
from vibroscope.engine.simulate import starting_checkpoint

REACH_OF_SEEDS = 1.5  # of the largest displacement and velocity of the runs from rest, to where starts are drawn


class OrbitFinder:
    """Finds closed orbits of a family.

    Parameters
    ----------
    curve : Curve
        Its equations and range.
    max_period : int
        Longest cycle, in excitation periods.
    threads : int or None
        That run cells; None for as many as there are processors.
    cancelled : callable or None
    """

    def __init__(self, curve: Curve, max_period: int, threads: int | None, cancelled: Poll | None) -> None:
        self.curve, self.family, self.max_period = curve, curve.family, max_period
        self.threads, self.cancelled = threads, cancelled
        self.kinds_of_runs = Counter()  # "periodic", "longer", "aperiodic", "ended"
        self._random, self._reach = np.random.default_rng(0), np.zeros(2)  # displacement and velocity

    # -- one orbit -----------------------------------------------------------------------------------------------------

    def at(self, value: float, state: Sequence[float], period: int, beyond: float = ZERO_MARGIN) -> Orbit | None:
        """The orbit through a state at τ = 0, with its events; None if it is not found, or penetrates by more."""
        problem = self.family.at(value)
        poincare = PoincareMap(*problem, None)
        y = poincare.coordinates(np.asarray(state, dtype=float))
        guess = orbit_of_run(problem, y, period)
        orbit = guess and self.curve.corrected(guess, value)
        if orbit is None:
            return None
        found = CurvePoint(self.curve, orbit, value)
        if not found.least_margin >= -beyond:
            return None
        rows = found.evaluation.section
        shortest = least_period(rows, SAME_ORBIT)
        return orbit if shortest == period else self.at(value, poincare.displacements(rows[0]), shortest, beyond)

    def begun(self, value: float, state: Sequence[float] | None) -> Orbit:
        """The orbit :meth:`near` a state, or else that which a run from there has :meth:`settled` to; None is rest."""
        return (state is not None and self.near(value, state)) or self.settled(value, state)

    def near(self, value: float, state: Sequence[float]) -> Orbit | None:
        """The orbit that passes through a state, stable or not, or else that of the shortest period that nearly does.

        None if there is none.
        """
        problem = self.family.at(value)
        poincare = PoincareMap(*problem, self.cancelled)
        y = poincare.coordinates(np.asarray(starting_checkpoint(state, *problem).state))
        size, near = size_of(y), None
        for period in range(1, self.max_period + 1):
            returned = poincare(y, period)
            if returned is None or not returned.residual < NEARLY_RETURNS * size:
                continue
            if near is not None and not returned.residual < RETURNS_CLOSELY * size:
                continue
            orbit = self.at(value, poincare.displacements(y), period, BESIDE_SEQUENCE)
            if orbit is not None and on_its_sequence(self.curve, CurvePoint(self.curve, orbit, value)) is None:
                continue
            off = np.inf if orbit is None else np.abs(orbit.unknowns[:4] - y).max()
            if off < RETURNS_CLOSELY * size:
                return orbit
            if near is None and off < 2 * NEARLY_RETURNS * size:
                near = orbit
        return near

    def settled(self, value: float, state: Sequence[float] | None) -> Orbit:
        """The orbit that a run settles to.

        Raises
        ------
        ValueError
            If there is none, or none that can be followed.
        """
        problem, over = self.family.at(value), self.family.over
        how = {"initial": state, "max_period": self.max_period, "cancelled": self.cancelled}
        found = steady(*problem, **how)
        if not found.periodic:
            found = steady(*problem, **how, stable_only=False)
        if not found.periodic:
            raise ValueError(f"there is no periodic motion to follow: {found.message}")
        orbit = self.at(value, found.state, found.period)
        if orbit is None:
            raise ValueError(
                stated(
                    "the motion at {} has no sequence of events that can be followed: change {} a little",
                    equation(over, value),
                    Symbol(over),
                )
            )
        return orbit

    def by_newton(self, value: float, state: Sequence[float], period: int) -> Orbit | None:
        """The orbit that Newton's method on the Poincaré map finds from a state; None if it finds none."""
        poincare = PoincareMap(*self.family.at(value), self.cancelled)
        y = poincare.coordinates(np.asarray(state, dtype=float))
        found = fixed_point(poincare, y, period, size_of(y))
        return found and self.at(value, poincare.displacements(found.state), period)

    def why_none(self) -> str:
        """A sentence about the runs, where no motion was found."""
        words = {
            "periodic": "repeat but have no sequence of events that can be followed",
            "longer": f"repeat after more than {self.max_period} periods",
            "aperiodic": "do not repeat: chaos, or a motion that settles slowly",
            "ended": "ended early",
        }
        said = ", ".join(f"{count} {words[kind]}" for kind, count in self.kinds_of_runs.most_common())
        return f"no periodic motion was found: of {self.kinds_of_runs.total()} runs {said}"

    # -- many ----------------------------------------------------------------------------------------------------------

    def orbits(self, count: int, starts: int, unstable: bool) -> Iterator[tuple[float, Orbit]]:
        """What runs settle to at so many values of the number, each from so many starts, the first of them rest.

        Those next to the family's own value come first. With ``unstable`` also motions that no run settles to.
        """
        values = np.append(np.linspace(self.curve.low, self.curve.high, count), self.family.value)
        values = values[(values >= self.curve.low) & (values <= self.curve.high)]
        runs = [self._from_rest(values), *(self._from_random_starts(values) for _ in range(starts - 1))]
        for i in np.argsort(np.abs(values - self.family.value), kind="stable"):
            value = float(values[i])
            for each in runs:
                self._count(each, i)
                if each.ok[i]:
                    yield from ((value, orbit) for orbit in self._of_run(value, each, i, unstable))

    def from_elsewhere(self, count: int) -> Iterator[tuple[float, Orbit]]:
        """What runs from random starts settle to at so many values of the number; after :meth:`orbits`."""
        values = np.linspace(self.curve.low, self.curve.high, count)
        runs = self._from_random_starts(values)
        for i in np.flatnonzero(runs.ok):
            yield from ((float(values[i]), orbit) for orbit in self._of_run(float(values[i]), runs, i, False))

    def _from_rest(self, values: np.ndarray) -> CellResults:
        """Runs at these values from rest."""
        runs = self._runs(values, None)
        self._reach = np.maximum(self._reach, REACH_OF_SEEDS * reach_of(runs.end[runs.ok]))
        return runs

    def _from_random_starts(self, values: np.ndarray) -> CellResults:
        """Runs at these values, each from another start within reach of the runs from rest so far."""
        states = random_states(self._random, len(values), self._reach)
        systems = (self.family.at(float(value))[0] for value in values)
        return self._runs(values, [apart(*each) for each in zip(systems, states, strict=True)])

    def _runs(self, values: np.ndarray, initial: Sequence[np.ndarray] | None) -> CellResults:
        """Runs at these values."""
        problems = [self.family.at(float(value)) for value in values]
        cells = {"eta": [eta for _, eta, _ in problems], "method": self.family.method, "initial": initial}
        if self.family.over in ("K", "D"):
            cells["stiffness" if self.family.over == "K" else "damping"] = values
        how = {"transient": 2000, "sample": 64, "threads": self.threads, "cancelled": self.cancelled}
        return run_cells(Cells([system for system, _, _ in problems], **cells), **how)

    def _count(self, runs: CellResults, i: int) -> None:
        period = runs.period[i]
        settled = "periodic" if 0 < period <= self.max_period else "longer" if period else "aperiodic"
        self.kinds_of_runs[settled if runs.ok[i] else "ended"] += 1

    def _of_run(self, value: float, runs: CellResults, i: int, unstable: bool) -> Iterator[Orbit]:
        """The orbits that the section of one run leads to."""
        rows, period = runs.section[i], int(runs.period[i])
        size = size_of(rows)
        if 0 < period <= self.max_period:
            guesses = [self.at(value, runs.end[i], period)]
        else:
            recurs = near_returns(rows, size, self.max_period, NEARLY_RETURNS)
            guesses = (self.by_newton(value, rows[-1], p) for p in recurs)
        yield from (orbit for orbit in guesses if orbit is not None and self._attracts(orbit, value))
        if not unstable or period == 1:
            return
        parts = [(rows.mean(axis=0), 1)]
        parts += [
            (rows[-period:].reshape(k, period // k, 4).mean(axis=0)[0], period // k)
            for k in (2, 3)
            if 0 < period <= self.max_period and period % k == 0 and period > k
        ]
        found = (self.by_newton(value, mean, shorter) for mean, shorter in parts)
        yield from (orbit for orbit in found if orbit is not None)

    def _attracts(self, orbit: Orbit, value: float) -> bool:
        return orbit.period == 1 or bool(may_be_stable(self.curve.evaluate(orbit, value).multipliers))
