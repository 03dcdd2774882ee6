"""How the cells of a study are divided into batches, and in which order these are computed.

A batch is an index of the study's grid: a box (slices) or single cells (index arrays). Boxes are the chunks of a store:
some seconds of work each, the unit that is written, lost in a kill, and sent to a cluster. For a picture that refines
while one watches, batches are single cells spread over the grid and take some tenths of a second.
"""

import itertools
import math
import time
from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from vibroscope.engine.sweeps.study import Study

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
    """The order in pieces, each as long as the time that the one before took suggests."""
    begin, size = 0, FIRST_CELLS
    while begin < len(order):
        started = time.monotonic()
        piece = order[begin : begin + size]
        yield piece
        begin += len(piece)
        passed = max(time.monotonic() - started, 1e-3)
        size = int(np.clip(size * BATCH_SECONDS / passed, FEWEST_CELLS, MOST_CELLS))
