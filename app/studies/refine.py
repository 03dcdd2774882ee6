"""The cells of a study in an order that shows the whole picture first and its details later. No panel import.

Every cell is computed once. First comes every eighth along each axis, then those halfway between, and so on, as an
interlaced picture is sent. What is not known yet is shown as the cell that stands for it in the coarser grid.
"""

from __future__ import annotations

import time
from collections.abc import Iterator

import numpy as np

COARSEST = 8
# A batch of cells takes about so long (seconds): often enough to watch, and soon enough cancelled.
_BATCH_SECONDS = 0.4
_FIRST, _LEAST, _MOST = 16, 4, 1024


def interlaced(shape: tuple[int, ...]) -> np.ndarray:
    """Flat indices of all cells of a grid, the coarse ones first."""
    strides = np.meshgrid(*(_stride(n) for n in shape), indexing="ij")
    level = np.minimum.reduce(strides)
    return np.argsort(-level.ravel(), kind="stable")


def _stride(n: int) -> np.ndarray:
    """The coarsest grid of 8, 4, 2, 1 that each index lies on."""
    index = np.arange(n)
    return np.minimum(np.where(index == 0, COARSEST, index & -index), COARSEST)


def nearest(known: np.ndarray) -> np.ndarray:
    """For each cell of a grid the flat index of the known cell that stands for it; −1 where there is none yet.

    Parameters
    ----------
    known : (n, m) ndarray of bool
        Filled in the order of `interlaced`.
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


def batches(order: np.ndarray, first: int = _FIRST) -> Iterator[np.ndarray]:
    """The order in pieces, each as long as the one before has shown to be right."""
    begin, size = 0, first
    while begin < len(order):
        started = time.monotonic()
        piece = order[begin : begin + size]
        yield piece
        begin += len(piece)
        passed = max(time.monotonic() - started, 1e-3)
        size = int(np.clip(size * _BATCH_SECONDS / passed, _LEAST, _MOST))
