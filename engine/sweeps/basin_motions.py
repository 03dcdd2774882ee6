"""The motion to which each start of a plane leads: the motions that attract, and the runs labelled by them.

The motions are found beforehand, from a lattice of starts of the same plane. So the label of a cell depends neither on
the other cells nor on the order in which they are computed. Each cell is run until that is decided:

- A closed-form solver (:mod:`..drivers.batch`): until the section enters a trapping region of one of the cycles
  (:mod:`..motions.trapping`), at most through the transient of the study.
- Of what enters none by then, and of every cell of another solver, the section of the sample is compared with those of
  the motions (:mod:`..motions.section`).
- If it is none of them, the cell has LATER times the transient to enter a region. Then Newton's method searches for a
  cycle from there (:mod:`..motions.steady`); one that is not among the motions is the cell's own, which the study puts
  together with others at the end.

A plane of starts: two of the four initial numbers, or the start phase of the excitation and one of them.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from vibroscope.engine.arguments import Poll, require, shown
from vibroscope.engine.cells import CellResults, Cells
from vibroscope.engine.drivers import batch as driver
from vibroscope.engine.drivers.batch import are_compiled
from vibroscope.engine.drivers.section import period_of
from vibroscope.engine.drivers.threads import thread_count
from vibroscope.engine.methods import Method
from vibroscope.engine.model import COORDINATES, System
from vibroscope.engine.motions.search import KnownMotion, MotionSearch
from vibroscope.engine.motions.section import cycle_points, least_size
from vibroscope.engine.motions.trapping import trapping_regions
from vibroscope.engine.result import STATUSES, Status
from vibroscope.engine.simulate import FARTHEST
from vibroscope.engine.sweeps.codes import MISSING

PHASE = "phase"  # when a run begins, as a share of the excitation period
AXES = (*COORDINATES, PHASE)


@dataclass(frozen=True)
class StartPlane:
    """The plane of starts of a basin.

    Attributes
    ----------
    axes : (str, str)
        Of `AXES`, different ones.
    spans : ((float, float), (float, float))
        Ends of both.
    start : (4,) tuple of float
        ξ₁, ξ₁′, ξ₂, ξ₂′ of every start; those on the axes have no effect.
    phase : float
        Of every start, where it is not on an axis: 0 ≤ phase < 1.

    Raises
    ------
    ValueError
        If an axis is unknown or given twice, or a number is out of range.
    """

    axes: tuple[str, str]
    spans: tuple[tuple[float, float], tuple[float, float]]
    start: tuple[float, float, float, float]
    phase: float = 0.0

    def __post_init__(self):
        if unknown := [name for name in self.axes if name not in AXES]:
            raise ValueError(f"{shown(unknown[0])} is no axis of a plane of starts: give two of {', '.join(AXES)}")
        if self.axes[0] == self.axes[1]:
            raise ValueError(f"both axes are {self.axes[0]}: give two different ones of {', '.join(AXES)}")
        for name, span in zip(self.axes, self.spans, strict=True):
            for end in span:
                _checked(name, end)
        for name, value in zip(COORDINATES, self.start, strict=True):
            _checked(f"start {name}", value)
        _checked(PHASE, self.phase)

    def check(self, system: System) -> None:
        """Raise a ValueError where the system has no such starts."""
        second = [name for name in self.axes if name in COORDINATES[2:]]
        if system.wall and second:
            raise ValueError(f"{second[0]} cannot be an axis: a wall does not move; give xi1, v1 or phase")
        if system.wall and any(self.start[2:]):
            raise ValueError(f"start xi2, v2 = {self.start[2]:g}, {self.start[3]:g}: a wall does not move; give 0, 0")
        if PHASE in self.axes and not system.excitation.drives:
            raise ValueError("phase cannot be an axis: nothing drives the bodies; give two of xi1, v1, xi2, v2")

    def starts(self, x: np.ndarray, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """ξ₁, ξ₁′, ξ₂, ξ₂′ and the phase of the starts at points of the plane, (n, 4) and (n,)."""
        columns = np.column_stack([np.tile(self.start, (len(x), 1)), np.full(len(x), self.phase)])
        for name, values in zip(self.axes, (x, y), strict=True):
            columns[:, AXES.index(name)] = values
        return columns[:, :4], columns[:, 4] % 1.0

    def lattice(self, count: int) -> tuple[np.ndarray, np.ndarray]:
        """The starts of count × count points, each in the middle of its part of the plane."""
        middles = (np.arange(count) + 0.5) / count
        x, y = (low + (high - low) * middles for low, high in self.spans)
        return self.starts(np.repeat(x, count), np.tile(y, count))


def can_begin(system: System, method: Method, starts: np.ndarray) -> np.ndarray:
    """Whether a solver can begin from each start, (n,) of bool: the reference knows no penetration."""
    if not method.rigid:
        return np.ones(len(starts), bool)
    return system.overlaps_of(starts) == 0


def _checked(name: str, value: float) -> None:
    if name == PHASE:
        require(name, value, 0, 1, "give a share of the excitation period")
    else:
        require(name, value, -FARTHEST, FARTHEST, "start within a million units of length")


PROBES, SLOW_PROBES = 16, 6  # along each side of the lattice: of cells that are compiled, and of others
MOST_MOTIONS = 32  # motions that are looked for on the lattice
PROBED = 200  # periods of the lattice's starts between two searches for a motion
LATER = 4  # multiples of the transient within which a cell may still enter a trapping region
OK = STATUSES.index(Status.OK)

# In place of the index of a motion:
OTHER = -2  # none of those that were found beforehand
ENDED = -3  # the run ended early
NO_START = -4  # the bodies of a reference would penetrate


@dataclass(frozen=True)
class Reached:
    """The motions to which cells lead.

    Attributes
    ----------
    motion : (n,) ndarray
        Index of the motion; MISSING, OTHER, ENDED or NO_START.
    period : (n,) ndarray
        Of the motion; MISSING where there is none.
    point : (n, 4) ndarray
        Of a motion that is none of those found beforehand: the first point of its cycle in ascending order, or the mean
        of its section; else nan.
    periods : (n,) ndarray
        That were run.
    status : (n,) ndarray
    """

    motion: np.ndarray
    period: np.ndarray
    point: np.ndarray
    periods: np.ndarray
    status: np.ndarray

    @classmethod
    def nothing(cls, n: int) -> "Reached":
        """The values of cells that are not yet computed."""
        motion, period = np.full(n, MISSING, np.int64), np.full(n, MISSING, np.int64)
        return cls(motion, period, np.full((n, 4), np.nan), np.zeros(n, np.int64), np.full(n, OK))


class BasinSearch(MotionSearch):
    """The motions of a solver in a plane of starts, and the labels of cells.

    Parameters
    ----------
    system, eta, method
        As in :func:`engine.simulate`.
    plane : StartPlane
    transient, sample : int
        Periods that a cell runs which no trapping region decides.
    """

    def __init__(self, system: System, eta: float, method: Method, plane: StartPlane, transient: int, sample: int):
        super().__init__(system, eta, method, transient, sample)
        self.plane = plane
        self._row = Cells(system, [eta], method).parameters()
        self.trapped = not method.has_step and bool(are_compiled(method, self._row)[0])
        self._found: list[KnownMotion] | None = None

    def motions(self, threads: int | None = None, cancelled: Poll | None = None) -> list[KnownMotion]:
        """The motions that starts of the lattice lead to, in the order in which they were found.

        Threads that ask before they are found search each on its own: a lock would be held while ``cancelled`` lets
        another job run in its place.

        Raises
        ------
        Cancelled
            If ``cancelled`` returned true; the next call begins anew.
        """
        if self._found is None:
            starts, phases = self.plane.lattice(PROBES if self.trapped else SLOW_PROBES)
            allowed = can_begin(self.system, self.method, starts)
            self.least = least_size(self.system, starts)
            self._found = self._search(starts[allowed], phases[allowed], thread_count(threads), cancelled)
        return self._found

    def label(
        self,
        starts: np.ndarray,
        phases: np.ndarray,
        *,
        threads: int | None = None,
        progress: Callable[[int], None] | None = None,
        cancelled: Poll | None = None,
    ) -> Reached:
        """Run cells until it is known which motion each of them tends to.

        Parameters
        ----------
        starts, phases : (n, 4), (n,) ndarray
        threads, progress, cancelled
            As in :func:`engine.run_cells`.
        """
        motions = self.motions(threads, cancelled)
        found = Reached.nothing(len(starts))
        allowed = can_begin(self.system, self.method, starts)
        found.motion[~allowed] = NO_START
        left, states = np.flatnonzero(allowed), starts[allowed]
        how = {"threads": thread_count(threads), "progress": progress, "cancelled": cancelled}
        if self.trapped:
            left, states = self._settle_cells(found, motions, left, states, phases[left], self.transient, how)
            how["progress"] = None  # which has counted them
        if len(left):
            self._recognise(found, motions, left, states, how)
        return found

    # -- cells ----------------------------------------------------------------------------------------------------

    def _settle(self, motions, states, phases, periods: int, threads, progress, cancelled) -> driver.BatchResults:
        regions = [region for each in motions for region in each.regions]
        centres = np.array([region.centre for region in regions]).reshape(-1, 4)
        factors = np.array([region.factor for region in regions]).reshape(-1, 4, 4)
        return driver.settle(
            self.method,
            np.repeat(self._row, len(states), axis=0),
            np.ascontiguousarray(states),
            phases * (2 * np.pi / self.eta),
            driver.Traps(centres, factors),
            max(periods, 1),
            threads=threads,
            progress=progress,
            cancelled=cancelled,
        )

    def _settle_cells(self, found: Reached, motions, cells, states, phases, periods: int, how: dict):
        """Label the cells that a trapping region decides; the others and the states that they came to."""
        settled = self._settle(motions, states, phases, periods, **how)
        owners = np.array([k for k, each in enumerate(motions) for _ in each.regions], dtype=np.int64)
        trapped, ended = settled.known != driver.NO_TRAP, settled.status != OK
        found.motion[cells[trapped]] = owners[settled.known[trapped]]
        found.motion[cells[ended]] = ENDED
        found.period[cells[trapped]] = [motions[k].period for k in owners[settled.known[trapped]]]
        found.status[cells] = settled.status
        found.periods[cells] += settled.periods
        left = ~(trapped | ended)
        return cells[left], self.clean(settled.end[left])

    def _recognise(self, found: Reached, motions, cells, states, how: dict) -> None:
        """Label cells by their sections, and those that are none of the motions by what they come to later."""
        run = self.run(states, 0 if self.trapped else None, **how)
        found.status[cells], found.periods[cells] = run.status, found.periods[cells] + run.periods
        found.motion[cells[~run.ok]] = ENDED
        unknown = []
        for k in np.flatnonzero(run.ok):
            index = self.index_of(run.section[k], motions)
            if index is None:
                unknown.append(k)
            else:
                found.motion[cells[k]], found.period[cells[k]] = index, motions[index].period
        sections = dict(zip(cells[unknown].tolist(), run.section[unknown], strict=True))
        if self.trapped and unknown:  # a long transient may be over later
            states, phases = self.clean(run.end[unknown]), np.zeros(len(unknown))
            left = self._settle_cells(found, motions, cells[unknown], states, phases, LATER * self.transient, how)
            sections = {i: state[None] for i, state in zip(*left, strict=True)}
        for i, section in sections.items():
            self._search_from(found, i, section, motions, how["cancelled"])

    def _search_from(self, found: Reached, i: int, section: np.ndarray, motions, cancelled) -> None:
        """Label cell i by the cycle that Newton's method finds from the end of a section, or else by the section."""
        cycle = self.cycle_from(self.clean(section[-1:])[0], cancelled)
        section, period = (cycle.section, cycle.period) if cycle else (section, period_of(section))
        index = self.index_of(section, motions)
        if index is None:
            found.motion[i], found.period[i] = OTHER, period
            points = cycle_points(section, period) if period else section.mean(axis=0)[None]
            found.point[i] = points[np.lexsort(points.T[::-1])[0]]
        else:
            found.motion[i], found.period[i] = index, motions[index].period

    # -- the motions ----------------------------------------------------------------------------------------------

    def _search(self, starts, phases, threads: int, cancelled) -> list[KnownMotion]:
        """Each motion from the first start that leads to none of those before."""
        if not len(starts):
            return []
        if not self.trapped:
            run = self.run(starts, threads=threads, cancelled=cancelled)
            return self._motions_of_runs(run, [], cancelled)
        motions: list[KnownMotion] = []
        if not phases[0]:  # else the first cells come to a section before there is any region
            self.add(motions, starts[0], cancelled)
        while len(motions) < MOST_MOTIONS:
            settled = self._settle(motions, starts, phases, PROBED, threads, None, cancelled)
            left = (settled.known == driver.NO_TRAP) & (settled.status == OK)
            starts, phases = self.clean(settled.end[left]), np.zeros(int(left.sum()))
            if not len(starts):
                break
            before = len(motions)
            index = self.add(motions, starts[0], cancelled)
            if index is None or not motions[index].regions:  # nothing is trapped by it
                run = self.run(starts, threads=threads, cancelled=cancelled)
                return self._motions_of_runs(run, motions, cancelled)
            if index < before:  # a transient of a motion that was known
                starts, phases = starts[1:], phases[1:]
            if not len(starts):
                break
        return motions

    def _motions_of_runs(self, run: CellResults, motions: list[KnownMotion], cancelled) -> list[KnownMotion]:
        """The motions so far, and those to which the runs tend beside them."""
        for k in range(len(run.status)):
            if len(motions) < MOST_MOTIONS:
                self.led_to(run, k, motions, cancelled)
        return motions

    def prepared(self, found: KnownMotion, cancelled: Poll | None) -> KnownMotion:
        """A new motion with its trapping regions, where the kernel looks for them."""
        if self.trapped and found.cycle is not None:
            found.regions.extend(trapping_regions(self.system, self.eta, self.method, found.cycle, cancelled))
        return found


@lru_cache(maxsize=16)
def basin_search(
    system: System, eta: float, method: Method, plane: StartPlane, transient: int, sample: int
) -> BasinSearch:
    """The search of a plane, whose motions are found once per process."""
    return BasinSearch(system, eta, method, plane, transient, sample)
