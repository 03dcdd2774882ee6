"""The error of many penalty cells and what it is made of.

On the instants of Newmark's grid, over the periods of a cell's sample but the first,

    Newmark − reference(table) = [Newmark − exact penalty] + [exact penalty − reference(derived)] + [derived − table]
    error                        time step                   regularisation                         joint damping

each as the root mean square of both displacements relative to that of reference(table), as in
:mod:`..divergence.error`. Scatter comes in bursts, so that other periods, or fewer, would give another error than
:func:`..divergence.compare.compare` does. The last is the same for all cells of one η.

There is an error wherever the reference repeats itself: a cell that does not repeat is far from it at most instants,
and the error shows it (`period` is the reason). The parts exist where exact penalty and both references repeat after as
many periods, scatter forgiven; elsewhere a difference at each instant means nothing, and they are nan.
"""

import functools
from collections.abc import Callable
from dataclasses import replace

import numpy as np
from vibroscope.engine.arguments import Poll
from vibroscope.engine.cells import CellResults, Cells
from vibroscope.engine.divergence.error import Target
from vibroscope.engine.divergence.grid import closest_repetition, relative_to, rms
from vibroscope.engine.divergence.grid import samples_by_period as by_period
from vibroscope.engine.drivers.differences import ALONE, BESIDE, OWN_LIMIT, Cycles, Grid, Motions, Sampling, differences
from vibroscope.engine.drivers.threads import thread_count
from vibroscope.engine.methods import Reference
from vibroscope.engine.model import System
from vibroscope.engine.result import Cancelled, Checkpoint, Record
from vibroscope.engine.simulate import simulate

ERROR_SAMPLES = 200  # per period (see engine.divergence.grid)


class ReferenceMotion:
    """The reference's motion with the joint damping as measured and as derived, and the errors of cells against both.

    Parameters
    ----------
    system : System
    eta : float
    initial : (4,) tuple, optional
        ξ₁, ξ₁′, ξ₂, ξ₂′ at τ = 0; rest, if not given.

    Attributes
    ----------
    table, derived : Target
    period : int
        Excitation periods after which the reference repeats itself; 0 if it does not, and then there is no error.
    splits : bool
        Whether that with derived joint damping repeats after as many: else the error has no parts.
    """

    def __init__(self, system: System, eta: float, initial: tuple[float, ...] | None = None) -> None:
        self.system, self.eta = system, eta
        self.table, self.derived = (
            Target.find(system, eta, Reference(kind), initial=initial) for kind in ("table", "derived")
        )
        self.period = self.table.period
        self.splits = self.period == self.derived.period > 0

    @functools.cached_property
    def joint_damping(self) -> float:
        """Reference(derived) − reference(table), relative to the latter; nan if they do not repeat alike."""
        if not self.splits:
            return np.nan
        table, size = self.table.cycle(Record(1, ERROR_SAMPLES))
        derived, _ = self.derived.cycle(Record(1, ERROR_SAMPLES))
        return relative_to(rms(closest_repetition(derived, table) - table), size)

    @functools.cached_property
    def first_impact(self) -> float:
        """Instant of the reference's first impact in a cycle, as a share of T; nan if there is none or no cycle."""
        if not self.period:
            return np.nan
        response = self.table.reference
        begin = response.window[1] - self.period * response.period
        recent = response.impacts.time[response.impacts.time > begin]
        return recent.min() / response.period % 1.0 if len(recent) else np.nan

    @functools.cached_property
    def impacts_per_period(self) -> float:
        """Impacts of the reference per excitation period."""
        response = self.table.reference
        return len(response.impacts) / response.keep

    def errors(
        self,
        cells: Cells,
        found: CellResults,
        exact: CellResults | None,
        *,
        threads: int | None = None,
        progress: Callable[[int], None] | None = None,
        cancelled: Poll | None = None,
    ) -> np.ndarray:
        """Error, its part by the time step and its part by the regularisation, of each cell: (3, n).

        Parameters
        ----------
        cells : Cells
            Of a penalty method, all of this system and η.
        found : CellResults
            Of these cells.
        exact : CellResults or None
            Of the same by the exact penalty method, which may be ``found`` itself; None: only the error, not its parts.

        Raises
        ------
        Cancelled
            If ``cancelled`` returned true.
        """
        errors = np.full((3, len(cells)), np.nan)
        chosen = np.flatnonzero(found.ok)
        if not self.period or not len(chosen):
            return errors
        parts, limits = np.full(len(cells), ALONE), cells
        if exact is not None and self.splits:
            own_limit = not cells.method.has_step
            limits = cells if own_limit else replace(cells, method=cells.method.limit, steps=None)
            parts[exact.ok & (exact.near_period == self.period)] = OWN_LIMIT if own_limit else BESIDE
        steps, grid = np.unique(cells.steps_each()[chosen].astype(int), return_inverse=True)
        records = [_record_of(int(n)) for n in steps]
        kept = self.period * max(1, (found.section.shape[1] - 1) // self.period)

        def motions_of(cells: Cells, found: CellResults) -> Motions:
            def sample(k: int, signals: np.ndarray) -> np.ndarray | None:
                record, i = replace(records[grid[k]], periods=kept), chosen[k]
                start = Checkpoint(self.system, self.eta, cells.method_of(i), 0, found.section[i, 0])
                return _displacements(start, record, lambda: signals[0] != 0)

            rows = cells.parameters()[chosen]
            return Motions(
                cells.method, rows, found.section[chosen, 0], found.period[chosen], found.cycle[chosen], sample
            )

        apart = differences(
            motions_of(cells, found),
            motions_of(limits, found if exact is None else exact),
            parts[chosen],
            Sampling([self._grid(record) for record in records], grid, kept),
            threads=thread_count(threads),
            progress=progress,
            cancelled=cancelled,
        )
        sizes = [self.table.cycle(record)[1] for record in records]
        relative = [[relative_to(each, sizes[g]) for each in row] for row, g in zip(apart.tolist(), grid, strict=True)]
        errors[:, chosen] = np.array(relative).T
        return errors

    def _grid(self, record: Record) -> Grid:
        """The reference at the instants of a record."""
        targets = self.table, self.derived if self.splits else self.table
        cycles = (np.ascontiguousarray(target.cycle(record)[0].transpose(1, 2, 0)) for target in targets)
        return Grid(record.phases(record.steps or record.per_period), Cycles(*cycles))


def _record_of(steps: int) -> Record:
    """The record of a period that samples a method with so many steps per period, 0: none; at most ERROR_SAMPLES."""
    return Record(1, len(Record(1, ERROR_SAMPLES).phases(steps)), steps) if steps else Record(1, ERROR_SAMPLES)


def _displacements(start: Checkpoint, record: Record, cancelled: Poll) -> np.ndarray | None:
    """ξ₁ and ξ₂ over the periods of a record, (periods, m, 2); None if the run ends early or is cancelled."""
    how = {"periods": record.periods, "keep": record.periods, "record": record, "cancelled": cancelled}
    try:
        run = simulate(start.system, start.eta, start.method, initial=start, **how)
    except Cancelled:
        return None
    return np.ascontiguousarray(by_period(run)[:2].transpose(1, 2, 0)) if run.ok else None


@functools.lru_cache(maxsize=8)
def reference_motion(system: System, eta: float, initial: tuple[float, ...] | None = None) -> ReferenceMotion:
    """The reference's motion at one η from one start, found once per process."""
    return ReferenceMotion(system, eta, initial)
