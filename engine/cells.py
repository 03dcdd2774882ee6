"""Cells of a sweep, and their results: arrays with an entry for each cell.

Many cells in one call: runs that differ in η, in the system or in K, D and n, each described by a few numbers.

A sweep needs the Poincaré section of each run and what kind of motion it is, not its events.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from vibroscope.engine.arguments import Poll, require, set_fields, shown, whole
from vibroscope.engine.drivers import batch as driver
from vibroscope.engine.drivers.event_driven import overlap_message
from vibroscope.engine.drivers.parameters import at_eta, parameter_rows, parameters_of_stops
from vibroscope.engine.drivers.section import describe_section, name_numbers
from vibroscope.engine.drivers.threads import GRAIN, thread_count
from vibroscope.engine.methods import METHOD_NUMBERS, Method
from vibroscope.engine.model import System, check_eta
from vibroscope.engine.result import STATUSES, Cancelled, Response, Status
from vibroscope.engine.simulate import KEEP_LIMIT, PERIODS_LIMIT, STEPS_LIMIT, simulate

FEW_CELLS = 8  # cells or chains for each thread: so few may take long, and threads take them one by one


@dataclass(frozen=True)
class Cells:
    """The cells to run: system, η, method and start of each.

    Attributes
    ----------
    system : System or sequence of System
        One for all cells, or one a cell.
    eta : (n,) array_like
    method : Reference, ExactPenalty or TimeStepping
        Holds for all cells but where one of the next three says otherwise.
    stiffness, damping, steps : (n,) array_like, optional
        K, D (penalty methods) and n (methods with a time step) of each cell.
    initial : (n, 4) array_like, optional
        ξ₁, ξ₁′, ξ₂, ξ₂′ at τ = 0 of each cell; rest, if not given.
    chain : (n,) array_like of int, optional
        Cells of the same number follow each other in the order of their index: each but the first starts from the end
        of the one before (continuation), or from its ``initial`` where that one did not reach its end.

    Raises
    ------
    ValueError
        If a number is out of range, or an array has the wrong shape.
    """

    system: System | Sequence[System]
    eta: np.ndarray
    method: Method
    stiffness: np.ndarray | None = None
    damping: np.ndarray | None = None
    steps: np.ndarray | None = None
    initial: np.ndarray | None = None
    chain: np.ndarray | None = None

    def __post_init__(self):
        self._keep("eta", self.eta, float)
        if not isinstance(self.method, Method):
            raise ValueError(f"method = {shown(self.method)} is no method: give Reference, ExactPenalty or Newmark")
        if not isinstance(self.system, System):
            try:
                systems = tuple(self.system)
            except TypeError:
                systems = (None,)
            if not all(isinstance(system, System) for system in systems):
                raise ValueError(f"system = {shown(self.system)} is no System: give one, or a sequence of them")
            set_fields(self, system=systems)
            self._same_length("system")
        for symbol, name in METHOD_NUMBERS.items():
            if getattr(self, name) is None:
                continue
            if symbol not in self.method.numbers:
                raise ValueError(f"{name} is no number of the {self.method.name} method: leave it out")
            self._keep(name, getattr(self, name), float)
        if self.initial is not None:
            self._keep("initial", self.initial, float)
        if self.chain is not None:
            self._keep("chain", self.chain, np.int64)
        if len(self) > 0:
            self._check()

    def _keep(self, name: str, values, kind: type) -> None:
        """Keep a copy as an array, with an entry (``initial``: four) for each cell."""
        try:
            numbers = np.array(values, dtype=float)
            if kind is np.int64 and not (np.isfinite(numbers) & (numbers == np.round(numbers))).all():
                raise ValueError
            values = numbers.astype(kind)
        except (TypeError, ValueError, OverflowError):
            raise ValueError(f"{name} = {shown(values)} are not numbers: give one a cell, of initial four") from None
        wanted = (len(values), 4) if name == "initial" and values.ndim > 0 else (values.size,)
        if values.shape != wanted:
            raise ValueError(f"{name} has the shape {values.shape}: give one entry a cell, of initial four")
        set_fields(self, **{name: values})
        self._same_length(name)

    def _same_length(self, name: str) -> None:
        if len(getattr(self, name)) != len(self):
            raise ValueError(f"{name} has {len(getattr(self, name))} entries for {len(self)} of eta: give one a cell")

    def _check(self) -> None:
        """Raise what :func:`engine.simulate` would raise at the first bad number."""
        if self.steps is not None and (self.steps % 1 > 0).any():
            bad = float(self.steps[self.steps % 1 > 0][0])
            raise ValueError(f"steps = {bad} is not a whole number: give steps per excitation period")
        for pick in (np.min, np.max):  # both are nan if one is
            check_eta(float(pick(self.eta)))
            replace(self.method, **{name: float(pick(values)) for name, values in self._own().items()})
        if self.initial is None:
            return
        reach = 1e6 if self.chain is None else math.inf  # a chain may go on from a motion that has grown
        for pick in (np.min, np.max):
            require("initial", float(pick(self.initial)), -reach, reach, "start within a million units of length")
        if self.method.rigid:
            if isinstance(self.system, System):
                overlaps = self.system.overlaps_of(self.initial)
            else:
                overlaps = [self.system_of(i).overlap_of(state) for i, state in enumerate(self.initial.tolist())]
            worst = int(np.argmax(overlaps))
            if overlaps[worst] > 0:
                raise ValueError(overlap_message(self.system_of(worst), -overlaps[worst]))

    def _own(self) -> dict[str, np.ndarray]:
        return {name: given for name in METHOD_NUMBERS.values() if (given := getattr(self, name)) is not None}

    def steps_each(self) -> np.ndarray:
        """n of each cell, (n,); zeros for methods without."""
        steps = self.method.steps if self.steps is None else self.steps
        return np.broadcast_to(np.asarray(steps, dtype=float), len(self))

    def starts(self) -> np.ndarray:
        """ξ₁, ξ₁′, ξ₂, ξ₂′ of each cell at τ = 0, (n, 4): as given, or the static equilibrium of its system."""
        if self.initial is not None:
            return self.initial
        if isinstance(self.system, System):
            return np.tile(self.system.rest, (len(self), 1))
        return np.array([system.rest for system in self.system]).reshape(len(self), 4)

    def parameters(self) -> np.ndarray:
        """Rows of :class:`engine.kernels.parameters.Parameters`, (n, s, …): of each cell, as seen from each stop.

        s is 2 if any cell has a second stop; the second row of one that has none is its first.
        """
        systems = (self.system,) if isinstance(self.system, System) else self.system
        stops = max((1 + system.two_stops for system in systems), default=1)
        rows = np.array([(parameters_of_stops(each, 1.0, self.method) * 2)[:stops] for each in systems])
        factors = np.array([each.contact_factors[:stops] for each in systems])
        power = np.array([system.excitation.power for system in systems])
        if len(systems) < len(self):
            rows = np.repeat(rows, len(self), axis=0)
        own = {name: values[:, None] for name, values in self._own().items()}
        for k, name in enumerate(("stiffness", "damping")):  # of the second stop multiples of those of the first
            if name in own:
                own[name] = factors[..., k] * own[name]
        return parameter_rows(at_eta(rows, self.eta[:, None], power[:, None]), own)

    def __len__(self) -> int:
        return len(self.eta)

    def at(self, places: np.ndarray, **changed) -> "Cells":
        """The cells at some places, by their index, each on its own, with other numbers of them ``changed``."""
        own = {name: getattr(self, name) for name in ("eta", "initial", *METHOD_NUMBERS.values())}
        own = {name: None if array is None else array[places] for name, array in own.items()}
        system = self.system if isinstance(self.system, System) else [self.system[i] for i in places]
        return replace(self, system=system, chain=None, **own | changed)

    def system_of(self, i: int) -> System:
        """The system of cell i."""
        return self.system if isinstance(self.system, System) else self.system[i]

    def method_of(self, i: int) -> Method:
        """The method of cell i, its own numbers in place."""
        return replace(self.method, **{name: values[i] for name, values in self._own().items()})


@dataclass(frozen=True)
class CellResults:
    """The results of the cells; nan (or 0, for whole numbers) where a cell did not reach its end.

    Attributes
    ----------
    status : (n,) ndarray of int8
        Index into ``STATUSES``.
    section : (n, sample, c) ndarray
        The chosen coordinates of the Poincaré section τ ≡ 0 mod T over the sample, oldest first.
    period, near_period : (n,) ndarray of int32
        As in :class:`.motions.description.Motion`; 0 is aperiodic.
    impacts_per_period, contacts_per_period, contact_share, spread, scatter : (n,) ndarray
        As in :class:`.motions.description.Motion`.
    longest_contact : (n,) ndarray
        τ that the longest contact overlapping the sample lasts; one that is open at the end of the run ends there.
    longest_contact_steps : (n,) ndarray
        The same in steps; nan for methods without.
    impact_phase : (n,) ndarray
        Instant of the first impact in the last cycle (aperiodic: in the last period), as a share of T from the
        section; nan if there is none.
    end : (n, 4) ndarray
        ξ₁, ξ₁′, ξ₂, ξ₂′ at the end, from which a neighbouring cell can go on.
    periods : (n,) ndarray of int64
        Periods that were run; fewer than asked for where the motion was found to be periodic before.
    cycle : (n,) ndarray of int64
        Periods after which such a motion was seen to repeat itself to rounding, a multiple of those of its period
        where the sample shows that; 0 where it was not.
    steps_without_solution, steps_with_two, steps_taken : (n,) ndarray of int64
        As in :class:`.result.Response`, and all steps of the run; zeros for cells that a kernel runs.
    """

    status: np.ndarray
    section: np.ndarray
    period: np.ndarray
    near_period: np.ndarray
    impacts_per_period: np.ndarray
    contacts_per_period: np.ndarray
    contact_share: np.ndarray
    spread: np.ndarray
    scatter: np.ndarray
    longest_contact: np.ndarray
    longest_contact_steps: np.ndarray
    impact_phase: np.ndarray
    end: np.ndarray
    periods: np.ndarray
    cycle: np.ndarray
    steps_without_solution: np.ndarray
    steps_with_two: np.ndarray
    steps_taken: np.ndarray

    def __repr__(self) -> str:
        return f"CellResults({len(self.status)} cells, {self.ok.sum()} ok, {self.section.shape[1]} periods kept)"

    @property
    def ok(self) -> np.ndarray:
        """Whether each cell reached its end, (n,) of bool."""
        return self.status == STATUSES.index(Status.OK)


def run_cells(
    cells: Cells,
    *,
    transient: int,
    sample: int,
    coordinates: Sequence[int] = (0, 1, 2, 3),
    recurrence: float = driver.RECURRENCE,
    threads: int | None = None,
    progress: Callable[[int], None] | None = None,
    cancelled: Poll | None = None,
) -> CellResults:
    """Run every cell for ``transient`` + ``sample`` periods and describe its last ``sample`` periods.

    The result of a cell does not depend on the others (but for those before it in its chain), on their order or on the
    number of threads. A cell that ends early has that in its status.

    Parameters
    ----------
    cells : Cells
    transient : int
        Periods before the sample, ≥ 0.
    sample : int
        Periods to describe, ≥ 1.
    coordinates : sequence of int
        Columns of the section to keep: 0 … 3 for ξ₁, ξ₁′, ξ₂, ξ₂′.
    recurrence : float
        Share of its size within which a state must return after a cycle, twice, for a cell to stop early: its motion
        has become periodic. By default what follows is the same to rounding; 0: all cells run to their end. So do those
        of Newmark whose every step is taken; those with located steps may stop at some lengths only.
    threads : int, optional
        As many as there are processors, if not given.
    progress : callable, optional
        Called, in the calling thread, with the number of cells done so far.
    cancelled : callable, optional
        Polled many times a second in the calling thread; when it returns true the call is cancelled.

    Raises
    ------
    ValueError
        If a number is out of range: the text names it, the range and what to do.
    Cancelled
        If ``cancelled`` returned true.

    Examples
    --------
    >>> from vibroscope.engine import Cells, Newmark, System, run_cells
    >>> cells = Cells(System(), [1.08, 2.76], Newmark(1, 1, 2000), stiffness=[2500, 12000], damping=[8, 18])
    >>> found = run_cells(cells, transient=500, sample=20)
    >>> found.period.tolist(), found.section.shape
    ([1, 0], (2, 20, 4))
    """
    if recurrence != 0:
        advice = "let cells stop early where what follows is nearly the same, or not at all by 0"
        require("recurrence", recurrence, driver.RECURRENCE, 1e-6, advice)
    task = driver.Task(
        whole("transient", transient, 0, PERIODS_LIMIT, "give the periods before the sample"),
        whole("sample", sample, 1, KEEP_LIMIT, "describe at least one period"),
        tuple(whole("coordinate", c, 0, 3, "0 to 3 are ξ₁, ξ₁′, ξ₂ and ξ₂′") for c in coordinates),
        float(recurrence),
    )
    threads = thread_count(threads)
    results = driver.empty_results(len(cells), task)
    solutions = np.zeros((len(cells), 3), dtype=np.int64)
    if len(cells) > 0:
        most = (task.transient + task.sample) * cells.steps_each().max()
        require("periods × steps", most, 0, STEPS_LIMIT, "run fewer periods or fewer steps per period")
        order, chained = _in_chains(cells)
        batch = driver.batch_of(cells.method, cells.parameters(), cells.starts(), task, order, chained)
        run_cell = _single_runs(cells, task, results, solutions)
        how = {"threads": threads, "progress": progress, "cancelled": cancelled}
        grain = 1 if np.count_nonzero(~chained) <= FEW_CELLS * threads else GRAIN
        driver.run_batch(cells.method, batch, results, run_cell, grain=grain, **how)
    return cell_results(cells, results, solutions)


def _in_chains(cells: Cells) -> tuple[np.ndarray, np.ndarray]:
    """The order in which cells are run, chain by chain, and which of them go on from the one before.

    Without chains those of most steps come first, so that no thread begins the longest one when the others are done.
    """
    if cells.chain is None:
        return np.argsort(-cells.steps_each(), kind="stable"), np.zeros(len(cells), dtype=bool)
    order = np.argsort(cells.chain, kind="stable")
    chained = np.append(False, np.diff(cells.chain[order]) == 0)
    return order, chained


def _single_runs(
    cells: Cells, task: driver.Task, results, solutions: np.ndarray
) -> Callable[[int, np.ndarray, np.ndarray], bool]:
    """A function that runs one cell by :func:`engine.simulate`; false if it was cancelled."""
    located = cells.method.located
    lengths = driver.lengths(task) if located else [task.transient + task.sample]

    def run_cell(i: int, start: np.ndarray, signals: np.ndarray) -> bool:
        done = 0  # periods
        for length in lengths:
            begun = done
            try:
                response = simulate(
                    cells.system_of(i),
                    cells.eta[i],
                    cells.method_of(i),
                    periods=length - done,
                    keep=task.sample,
                    initial=start,
                    cancelled=lambda: signals[0] != 0,
                )
            except Cancelled:
                return False
            if not response.ok:
                break
            if length < lengths[-1] and driver.section_recurs(response.section, task.recurrence):
                results.cycle[i] = driver.CYCLE
                break
            start, done = response.checkpoint, response.checkpoint.periods
        write_response(response, task, results, i)
        taken = begun * int(cells.steps_each()[i]) + response.cost.steps
        solutions[i] = response.steps_without_solution, response.steps_with_two, taken
        return True

    return run_cell


def write_response(response: Response, task: driver.Task, results, i: int) -> None:
    """Write a response into the results of cell i, as the kernel does."""
    results.status[i] = STATUSES.index(response.status)
    results.periods[i] = response.checkpoint.periods + response.keep if response.ok else response.periods
    if not response.ok:
        return
    results.numbers[i] = describe_section(response)
    results.section[i] = response.section[:, list(task.coordinates)]
    results.end[i] = response.section[-1]
    if response.method.rigid:  # a run that starts from there must not penetrate, not even by rounding
        results.end[i] = response.system.without_penetration(response.section[-1])


def cell_results(cells: Cells, results, solutions: np.ndarray) -> CellResults:
    """The results as named columns; ``solutions``: steps without a solution, with two, and all of them, (n, 3)."""
    numbers = name_numbers(results.numbers)
    periods = {name: np.nan_to_num(numbers.pop(name)).astype(np.int32) for name in ("period", "near_period")}
    share = numbers.pop("longest_contact")
    n = cells.steps_each() if cells.method.has_step else np.nan
    return CellResults(
        status=results.status.astype(np.int8),
        section=results.section,
        **periods,
        **numbers,
        longest_contact=share * 2 * np.pi / cells.eta,
        longest_contact_steps=np.round(share * n, 6),
        end=results.end,
        periods=results.periods,
        cycle=results.cycle,
        steps_without_solution=solutions[:, 0],
        steps_with_two=solutions[:, 1],
        steps_taken=solutions[:, 2],
    )
