"""How a study is cut: into boxes of cells, each some seconds of work, the unit that is kept, lost and sent."""

import itertools
import math
from collections.abc import Iterator

Chunk = tuple[slice, ...]

# Writing a chunk costs some 20 ms however small it is, and a killed run loses the chunks in hand: so many periods take
# between one and ten seconds.
PERIODS_PER_CHUNK = 4_000_000
NUMBERS_PER_CHUNK = 4_000_000
SMALLEST, LARGEST = 16, 16_384  # cells


def chunk_shape(
    shape: tuple[int, ...], periods_per_cell: int, numbers_per_cell: int, most: int | None = None
) -> tuple[int, ...]:
    """Cells of a chunk along each axis: boxes of nearly equal sides that leave no small rest.

    By default it depends on what was asked alone, not on the machine, so that another can go on with the same chunks.
    """
    if most is None:
        by_work, by_size = PERIODS_PER_CHUNK // periods_per_cell, NUMBERS_PER_CHUNK // numbers_per_cell
        most = max(SMALLEST, min(by_work, by_size, LARGEST))
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


def count(chunk: Chunk) -> int:
    """Cells in a chunk."""
    return math.prod(part.stop - part.start for part in chunk)
