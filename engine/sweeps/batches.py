"""How the cells of a study are divided into batches, and in which order these are computed.

A batch is an index of the study's grid: a box (slices) or single cells (index arrays). Boxes are the chunks of a store:
some seconds of work each, the unit that is written, lost in a kill, and sent to a cluster. For a picture that refines
while one watches, batches are single cells spread over the grid and take some tenths of a second.

Here stand, too, how far a study is, its results in memory, as arrays over the whole grid, and the origin that their
attributes hold. That is of two kinds, kept apart. `origin` follows from what was asked and from the engine, and is the
same in every run. `account` is of the run that finished the result (date, cost) and is written last, so that all else
is the same, byte for byte, however often a run was killed and on how many machines it was taken up again.
"""

import datetime
import importlib.metadata
import itertools
import json
import math
import platform
import time
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from vibroscope.engine.sweeps.codes import MISSING
from vibroscope.engine.sweeps.study import Study

if TYPE_CHECKING:
    import xarray


@dataclass(frozen=True)
class Progress:
    """The argument of a study's ``progress`` callable.

    Attributes
    ----------
    done, total : int
        Cells; refinement raises the total.
    computed, reused, failed : int
        Of those done: computed by this run, found in the store, ended early (with their status in the result).
    seconds : float
        Since the study began.
    """

    done: int
    total: int
    computed: int
    reused: int
    failed: int
    seconds: float

    @property
    def rate(self) -> float:
        """Cells computed a second."""
        return self.computed / self.seconds if self.seconds > 0 else 0.0

    @property
    def seconds_left(self) -> float:
        """The seconds left at this rate; inf before the first cell."""
        return (self.total - self.done) / self.rate if self.rate else float("inf")


ProgressCallback = Callable[[Progress], None]


class ProgressCounter:
    """Counts the cells of a study and calls the callback, from before the first batch to the last cell."""

    def __init__(self, callback: ProgressCallback | None = None) -> None:
        self._callback = callback
        self._begun = time.perf_counter()
        self.total = self.computed = self.reused = self.failed = 0

    def now(self, in_hand: int = 0) -> Progress:
        """The progress, with so many cells done of the batch that is being computed."""
        computed, seconds = self.computed + in_hand, time.perf_counter() - self._begun
        return Progress(computed + self.reused, self.total, computed, self.reused, self.failed, seconds)

    def add(self, status: np.ndarray, *, reused: bool) -> None:
        """Count a batch whose cells have these statuses."""
        if reused:
            self.reused += status.size
        else:
            self.computed += status.size
        self.failed += int(np.count_nonzero(status))
        self.report()

    def report(self, in_hand: int = 0) -> None:
        """Call the callback."""
        if self._callback is not None:
            self._callback(self.now(in_hand))


SOURCE = "Penalty-regularization of a dissipative vibro-impacting system (the model and its Table 1)"


def engine_version() -> str:
    """Version of the package; ``unknown`` if it is not installed."""
    try:
        return importlib.metadata.version("vibroscope")
    except importlib.metadata.PackageNotFoundError:
        return "unknown"


def origin(study: Study) -> dict[str, object]:
    """Attributes that are known before a study is run; groups of numbers as JSON, which every file format can hold."""
    numbers = study.numbers()
    return {
        "title": f"vibroscope sweep {study.kind}",
        "source": SOURCE,
        "system": json.dumps(numbers["system"]),
        "method": json.dumps(numbers["method"]),
        "options": json.dumps(numbers["options"]),
        **{name: numbers[name] for name in ("eta", "transient", "sample") if name in numbers},
        "engine_version": engine_version(),
        "engine_digest": numbers["engine"],
        "key": study.key,
        "complete": 0,
    }


def account(progress: Progress, where: str) -> dict[str, object]:
    """Attributes of the run that finished a result."""
    return {
        "date": datetime.datetime.now(datetime.UTC).isoformat(timespec="seconds"),
        **cost(progress),
        "computed_on": f"{where}, {platform.machine()}, Python {platform.python_version()}, "
        f"NumPy {importlib.metadata.version('numpy')}, Numba {importlib.metadata.version('numba')}",
        "complete": 1,
    }


def cost(progress: Progress) -> dict[str, object]:
    """Seconds and cells of a run."""
    return {name: getattr(progress, name) for name in ("seconds", "computed", "reused", "failed")}


Chunk = tuple[slice, ...]
Batch = Chunk | tuple[np.ndarray, ...]

# Writing a chunk costs some 20 ms however small it is, and a killed run loses the chunks in hand: so many periods take
# between one and ten seconds.
PERIODS_PER_CHUNK = 4_000_000
NUMBERS_PER_CHUNK = 4_000_000
SMALLEST_CHUNK, LARGEST_CHUNK = 16, 16_384  # cells of a chunk

COARSEST = 8  # stride of the grid that is computed first
BATCH_SECONDS = 0.4  # often enough to watch
FIRST_CELLS, FEWEST_CELLS, MOST_CELLS = 16, 4, 1024  # of a batch of single cells


def chunk_shape(
    shape: tuple[int, ...], periods_per_cell: int, numbers_per_cell: int, most: int | None = None
) -> tuple[int, ...]:
    """Cells of a chunk along each axis: boxes of nearly equal sides that leave no small rest.

    By default it depends on the study alone, not on the machine, so that another can go on with the same chunks.
    """
    if most is None:
        by_work, by_size = PERIODS_PER_CHUNK // periods_per_cell, NUMBERS_PER_CHUNK // numbers_per_cell
        most = max(SMALLEST_CHUNK, min(by_work, by_size, LARGEST_CHUNK))
    left, sides = most, []
    for remaining, length in zip(range(len(shape), 0, -1), shape, strict=True):
        side = max(1, min(length, math.floor(left ** (1 / remaining) + 1e-9)))
        side = math.ceil(length / math.ceil(length / side))
        sides.append(side)
        left = max(1, left // side)
    return tuple(sides)


def chunks(shape: tuple[int, ...], sides: tuple[int, ...]) -> Iterator[Chunk]:
    """All chunks of a grid, last axis fastest."""
    ranges = [
        [slice(begin, min(begin + side, length)) for begin in range(0, length, side)]
        for length, side in zip(shape, sides, strict=True)
    ]
    return itertools.product(*ranges)


def chunks_in_order(study: "Study", sides: tuple[int, ...]) -> list[Chunk]:
    """All chunks of a study in the order in which they are computed: the last first where it is continued downwards."""
    ordered = list(chunks(study.shape, sides))
    return ordered[::-1] if study.backwards else ordered


def coarse_first(study: "Study", known: np.ndarray) -> Iterator[Batch]:
    """All cells of a study, coarse ones first; of a continued study from one end to the other.

    Parameters
    ----------
    study : Study
    known : ndarray of bool
        In the shape of the grid: cells that an earlier run computed. They are the first batch.
    """
    in_direction = np.arange(known.size)[:: -1 if study.backwards else 1]
    order = in_direction if study.sequential else interlaced_order(study.shape)
    done = known.ravel()[order]
    batches = adaptive_batches(order[~done])
    for cells in itertools.chain([order[done]] if done.any() else [], batches):
        yield np.unravel_index(np.sort(cells), study.shape)


def interlaced_order(shape: tuple[int, ...]) -> np.ndarray:
    """Flat indices of all cells of a grid in the order of an interlaced picture.

    First comes every eighth cell along each axis, then those halfway between, and so on; on each level the first axis
    runs fastest.
    """
    strides = np.meshgrid(*(_coarsest_stride(n) for n in shape), indexing="ij")
    level = np.minimum.reduce(strides)
    order = np.argsort(-level.ravel(order="F"), kind="stable")
    return np.ravel_multi_index(np.unravel_index(order, shape, order="F"), shape)


def _coarsest_stride(n: int) -> np.ndarray:
    """The coarsest grid of 8, 4, 2, 1 that each index lies on."""
    index = np.arange(n)
    return np.minimum(np.where(index == 0, COARSEST, index & -index), COARSEST)


def nearest_known(known: np.ndarray) -> np.ndarray:
    """For each cell of a grid the flat index of the known cell that stands for it; −1 where there is none yet.

    Parameters
    ----------
    known : (n, m) ndarray of bool
        Filled in the order of `interlaced_order`.
    """
    rows, columns = known.shape
    found = np.full(known.shape, -1)
    stride = COARSEST
    while stride:
        row = (np.arange(rows) // stride * stride)[:, None]
        column = np.arange(columns) // stride * stride
        found = np.where(known[row, column], row * columns + column, found)
        stride //= 2
    return found


def adaptive_batches(order: np.ndarray) -> Iterator[np.ndarray]:
    """The order in pieces that take some tenths of a second, each as long as the one before it suggests."""
    begin, size = 0, FIRST_CELLS
    while begin < len(order):
        started = time.monotonic()
        piece = order[begin : begin + size]
        yield piece
        begin += len(piece)
        passed = max(time.monotonic() - started, 1e-3)
        size = int(np.clip(size * BATCH_SECONDS / passed, FEWEST_CELLS, MOST_CELLS))


def empty_values(study: Study) -> dict[str, np.ndarray]:
    """The variables of a study of which no cell is known."""
    lengths = study.lengths
    return {
        name: np.full(tuple(lengths[dim] for dim in variable.dims), variable.fill, variable.dtype)
        for name, variable in study.variables.items()
    }


class Memory:
    """One study's results; the same methods as `Store`.

    Parameters
    ----------
    values : mapping of str to ndarray, optional
        The variables that an earlier run of the same study left.
    """

    def __init__(self, values: Mapping[str, np.ndarray] | None = None) -> None:
        self._values = {name: array.copy() for name, array in (values or {}).items()}
        self._account: dict[str, object] = {}

    def claim(self, study: Study) -> None:
        """Make these results those of a study."""
        self._claimed = study

    def create(self, study: Study, sides: tuple[int, ...]) -> tuple[int, ...]:
        """Create every array that is missing; returns the sides of the chunks."""
        self._study = study  # a refined study: with all its cells, which were not known when it was claimed
        self._values = self._values or empty_values(study)
        return sides

    def part(self, name: str) -> "Memory":
        """Results that are a part of these: a round of refinement."""
        return Memory()

    def read(self, batch: Batch) -> dict[str, np.ndarray] | None:
        """The variables of a batch; None if any of its cells is missing."""
        if (self._values["status"][batch] == MISSING).any():
            return None
        return {name: array[batch] for name, array in self._values.items()}

    def write(self, batch: Batch, values: dict[str, np.ndarray]) -> None:
        """Take the variables of a batch."""
        for name, array in self._values.items():
            array[batch] = values[name]

    @property
    def known(self) -> np.ndarray:
        """Whether each cell is known, in the shape of the grid."""
        known = self._values["status"] != MISSING
        return known.all(axis=tuple(range(len(self._study.shape), known.ndim)))

    def values(self) -> dict[str, np.ndarray]:
        """Copies of all variables."""
        return {name: array.copy() for name, array in self._values.items()}

    def finish(self, progress: Progress, where: str) -> None:
        """Note that the results are complete, when and at what cost."""
        self._account = account(progress, where)

    def dataset(self) -> "xarray.Dataset":
        """The results as a labelled dataset."""
        import xarray

        study, values = self._study, self._values
        arrays = study.arrays | study.conclusions(values)
        found = {name: (item.dims, np.asarray(item.values), item.attributes) for name, item in arrays.items()}
        for name, variable in study.variables.items():
            found[name] = (variable.dims, values[name], variable.attributes)
        return xarray.Dataset(found, attrs=origin(self._claimed) | self._account)

    def close(self) -> None:
        """Nothing is open."""


def one_by_one(study: Study, results, batches: Iterable[Batch], counter: ProgressCounter, compute) -> Iterator[None]:
    """Count the batches that the results have, and compute and write the others, each after the one before.

    Parameters
    ----------
    study : Study
    results : Memory or Store
    batches : iterable of Batch
    counter : ProgressCounter
    compute : callable
        ``compute(batch, before)`` returns the variables of a batch; ``before`` are those of the one before, if the
        study is sequential.
    """
    before = None
    for batch in batches:
        values = results.read(batch)
        reused = values is not None
        if not reused:
            values = compute(batch, before)
            results.write(batch, values)
        before = values if study.sequential else None
        counter.add(values["status"], reused=reused)
        if not reused:
            yield
