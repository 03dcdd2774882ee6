"""Many cells in one call: runs that differ in η, in the system or in K, D and n, each told in a few numbers.

A sweep wants of each run its Poincaré section and what kind of motion it is, not its events. What is reported follows
from numbers that each period of the sample leaves behind, by the rules of :mod:`.motion`.
"""

import os
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace

import numpy as np

from .methods import ExactPenalty, Method, Newmark
from .model import System
from .motion import motion
from .result import Response, Status
from .simulate import simulate

STATUSES = tuple(Status)  # a cell's status is an index into them
REST = (0.0, 0.0, 0.0, 0.0)


@dataclass(frozen=True)
class Cells:
    """What to run, a cell each.

    Attributes
    ----------
    system : System or sequence of System
        One for all cells, or one a cell.
    eta : (n,) array_like
    method : Reference, ExactPenalty or Newmark
        Holds for all cells but where one of the next three says otherwise.
    stiffness, damping, steps : (n,) array_like, optional
        K, D (penalty methods) and n (Newmark) of each cell.
    initial : (n, 4) array_like, optional
        ξ₁, ξ₁′, ξ₂, ξ₂′ at τ = 0 of each cell; rest, if not given.
    chain : (n,) array_like of int, optional
        Cells of the same number follow each other in the order of their index: each but the first starts from the end
        of the one before (continuation), or from its ``initial`` where that one did not reach its end.
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
        object.__setattr__(self, "eta", np.array(self.eta, dtype=float).reshape(-1))
        n = len(self)
        if not isinstance(self.system, System):
            object.__setattr__(self, "system", tuple(self.system))
            _same_length("system", len(self.system), n)
        for name, known in (
            ("stiffness", ExactPenalty | Newmark),
            ("damping", ExactPenalty | Newmark),
            ("steps", Newmark),
        ):
            values = getattr(self, name)
            if values is None:
                continue
            if not isinstance(self.method, known):
                raise ValueError(f"{name} is no number of the {self.method.name} method: leave it out")
            object.__setattr__(self, name, np.array(values, dtype=float).reshape(-1))
            _same_length(name, len(getattr(self, name)), n)
        if self.initial is not None:
            initial = np.array(self.initial, dtype=float)
            if initial.shape != (n, 4):
                raise ValueError(
                    f"initial has the shape {initial.shape}, not {(n, 4)}: give ξ₁, ξ₁′, ξ₂, ξ₂′ of each cell"
                )
            object.__setattr__(self, "initial", initial)
        if self.chain is not None:
            object.__setattr__(self, "chain", np.array(self.chain, dtype=np.int64).reshape(-1))
            _same_length("chain", len(self.chain), n)

    def __len__(self) -> int:
        return len(self.eta)

    def system_of(self, i: int) -> System:
        """The system of cell i."""
        return self.system if isinstance(self.system, System) else self.system[i]

    def method_of(self, i: int) -> Method:
        """The method of cell i, its own numbers in place."""
        own = {
            name: getattr(self, name)[i]
            for name in ("stiffness", "damping", "steps")
            if getattr(self, name) is not None
        }
        return replace(self.method, **own) if own else self.method


def _same_length(name: str, length: int, n: int) -> None:
    if length != n:
        raise ValueError(f"{name} has {length} entries for {n} values of eta: give one a cell")


@dataclass(frozen=True)
class CellResults:
    """What became of each cell; nan (or 0, for whole numbers) where a cell did not reach its end.

    Attributes
    ----------
    status : (n,) ndarray of int8
        Index into ``STATUSES``.
    section : (n, sample, c) ndarray
        The chosen coordinates of the Poincaré section τ ≡ 0 mod T over the sample, oldest first.
    period, near_period : (n,) ndarray of int32
        As in :class:`.motion.Motion`; 0 is aperiodic.
    impacts_per_period, contacts_per_period, contact_share, spread, scatter : (n,) ndarray
        As in :class:`.motion.Motion`.
    longest_contact : (n,) ndarray
        τ that the longest contact overlapping the sample lasts; one that is open at the end of the run ends there.
    longest_contact_steps : (n,) ndarray
        The same in steps; nan for methods without.
    phase : (n,) ndarray
        Instant of the first impact in the last cycle (aperiodic: in the last period), as a share of T from the
        section; nan if there is none.
    end : (n, 4) ndarray
        ξ₁, ξ₁′, ξ₂, ξ₂′ at the end, from which a neighbouring cell can go on.
    periods : (n,) ndarray of int64
        Periods that were run; fewer than asked for where the motion was found to be periodic before.
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
    phase: np.ndarray
    end: np.ndarray
    periods: np.ndarray

    @property
    def ok(self) -> np.ndarray:
        """Which cells reached their end, (n,) of bool."""
        return self.status == STATUSES.index(Status.OK)


def run_cells(
    cells: Cells,
    *,
    transient: int,
    sample: int,
    coordinates: Sequence[int] = (0, 1, 2, 3),
    early_stop: bool = True,
    threads: int | None = None,
    progress: Callable[[int], None] | None = None,
    cancelled: Callable[[], bool] | None = None,
) -> CellResults:
    """Run every cell for ``transient`` + ``sample`` periods and tell what its last ``sample`` periods are.

    The result of a cell does not depend on the others, on their order or on the number of threads. A cell that ends
    early says so in its status.

    Parameters
    ----------
    cells : Cells
    transient : int
        Periods before the sample, ≥ 0.
    sample : int
        Periods to describe, ≥ 1.
    coordinates : sequence of int
        Columns of the section to keep: 0 … 3 for ξ₁, ξ₁′, ξ₂, ξ₂′.
    early_stop : bool
        Stop a cell once its motion has become periodic.
    threads : int, optional
        As many as there are processors, if not given.
    progress : callable, optional
        Called, in the calling thread, with the number of cells done so far.
    cancelled : callable, optional
        Polled many times a second in the calling thread; when it returns true the call is withdrawn.

    Raises
    ------
    ValueError
        If a number is out of range: the text names it, the range and what to do.
    Cancelled
        If ``cancelled`` returned true.
    """
    n, columns = len(cells), list(coordinates)
    results = _empty(n, sample, len(columns))
    numbers = np.arange(n) if cells.chain is None else cells.chain
    chains = [np.flatnonzero(numbers == number) for number in np.unique(numbers)]

    def run(chain: np.ndarray) -> None:
        before = None
        for i in chain:
            start = before if before is not None else REST if cells.initial is None else cells.initial[i]
            options = {"periods": transient + sample, "keep": sample, "initial": start, "cancelled": cancelled}
            response = simulate(cells.system_of(i), cells.eta[i], cells.method_of(i), **options)
            _fill(results, i, response, columns)
            before = response.section[-1] if response.ok else None

    done = 0
    with ThreadPoolExecutor(threads or os.cpu_count()) as pool:
        for chain, _ in zip(chains, pool.map(run, chains), strict=True):
            done += len(chain)
            if progress is not None:
                progress(done)
    return results


def _empty(n: int, sample: int, columns: int) -> CellResults:
    def whole(kind):
        return np.zeros(n, dtype=kind)

    def number(*shape):
        return np.full((n, *shape), np.nan)

    return CellResults(
        whole(np.int8),
        number(sample, columns),
        whole(np.int32),
        whole(np.int32),
        *(number() for _ in range(8)),
        number(4),
        whole(np.int64),
    )


def _fill(results: CellResults, i: int, response: Response, columns: list[int]) -> None:
    results.status[i] = STATUSES.index(response.status)
    if not response.ok:
        return
    found = motion(response)
    names = "period", "near_period", "impacts_per_period", "contacts_per_period", "contact_share", "spread", "scatter"
    for name in names:
        getattr(results, name)[i] = getattr(found, name)
    length = response.period
    lasting = np.diff(response.contacts, axis=1).max(initial=0.0)
    results.section[i] = response.section[:, columns]
    results.longest_contact[i] = lasting
    if isinstance(response.method, Newmark):
        results.longest_contact_steps[i] = np.round(lasting / length * response.method.steps, 6)
    recent = response.impacts.time[response.impacts.time > response.window[1] - max(1, found.near_period) * length]
    results.phase[i] = recent.min(initial=np.inf) / length % 1.0 if len(recent) else np.nan
    results.end[i] = response.section[-1]
    results.periods[i] = response.periods
