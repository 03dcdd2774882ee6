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
from concurrent.futures import ThreadPoolExecutor

import numpy as np

from ..cells import CellResults, Cells
from ..divergence.error import Target
from ..divergence.grid import best_shift, grid_of, relative_to, rms
from ..divergence.grid import repeat_cycle as repeated
from ..divergence.grid import samples_by_period as by_period
from ..methods import ExactPenalty, Method, Reference
from ..model import System
from ..result import Cancelled, Checkpoint, Record
from ..simulate import simulate

SAMPLES = 200  # per period (see engine.divergence.grid)


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
        table, size = self.table.cycle(Record(1, SAMPLES))
        return relative_to(rms(self._in_step(self.derived, Record(1, SAMPLES), table) - table), size)

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
        cancelled: Callable[[], bool] | None = None,
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
        if not self.period:
            return errors

        has_parts = np.zeros(len(cells), bool)
        if exact is not None and self.splits:
            has_parts = exact.ok & (exact.near_period == self.period)

        cycles = max(1, (found.section.shape[1] - 1) // self.period)

        def fill(i: int) -> None:
            if cancelled is not None and cancelled():
                raise Cancelled
            first = found.section[i, 0], exact.section[i, 0] if has_parts[i] else None
            errors[:, i] = self._split(cells.method_of(i), cycles, *first)

        with ThreadPoolExecutor(threads) as pool:
            for done, _ in enumerate(pool.map(fill, np.flatnonzero(found.ok)), start=1):
                if progress is not None:
                    progress(done)
        return errors

    def _split(
        self, method: Method, cycles: int, state: np.ndarray, exact_state: np.ndarray | None
    ) -> tuple[float, float, float]:
        penalty, grid = self._sampled(method, cycles, state)
        if penalty is None:
            return np.nan, np.nan, np.nan
        _, size = self.table.cycle(grid)
        total = relative_to(rms(penalty - self._in_step(self.table, grid, penalty)), size)
        if exact_state is None:
            return total, np.nan, np.nan
        if isinstance(method, ExactPenalty):
            return total, 0.0, relative_to(rms(penalty - self._in_step(self.derived, grid, penalty)), size)
        exact, _ = self._sampled(method.limit, cycles, exact_state, method.steps)
        if exact is None:
            return total, np.nan, np.nan
        exact = repeated(exact, exact.shape[1], self._lead(exact, penalty))
        derived = self._in_step(self.derived, grid, exact)
        return total, relative_to(rms(penalty - exact), size), relative_to(rms(exact - derived), size)

    def _sampled(self, method: Method, cycles: int, state: np.ndarray, steps: int | None = None):
        """Displacements over cycles from a state on, (2, periods, m), and their grid; None if the run ends."""
        periods = self.period * cycles
        record = Record(periods, SAMPLES, steps)
        start = Checkpoint(self.system, self.eta, method, 0, state)  # it may lie anywhere
        run = simulate(self.system, self.eta, method, periods=periods, keep=periods, initial=start, record=record)
        return (by_period(run)[:2], grid_of(run) if steps is None else None) if run.ok else (None, None)

    def _in_step(self, target: Target, grid: Record, displacement: np.ndarray) -> np.ndarray:
        """The cycle of a reference, moved by whole periods to where it is closest to displacements."""
        cycle, _ = target.cycle(grid)
        return repeated(cycle, displacement.shape[1], best_shift(cycle, displacement))

    def _lead(self, one: np.ndarray, other: np.ndarray) -> int:
        """Periods by which one motion is to begin later to come closest to another."""
        return min(range(self.period), key=lambda shift: rms(np.roll(one, -shift, axis=1) - other))


@functools.lru_cache(maxsize=8)
def reference_motion(system: System, eta: float, initial: tuple[float, ...] | None = None) -> ReferenceMotion:
    """The reference's motion at one η from one start, found once per process."""
    return ReferenceMotion(system, eta, initial)
