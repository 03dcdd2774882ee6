"""Small matrices, (6, 6), written out as loops: at this size a library call costs more than the sums."""

import numpy as np

from .jit import jit


@jit
def unit(i):
    """Row i of the unit matrix, (6,)."""
    row = np.zeros(6)
    row[i] = 1.0
    return row


@jit
def identity():
    """The unit matrix, (6, 6)."""
    out = np.zeros((6, 6))
    for i in range(6):
        out[i, i] = 1.0
    return out


@jit
def product(a, b):
    """The product of two matrices."""
    out = np.zeros((6, 6))
    for i in range(6):
        for k in range(6):
            for j in range(6):
                out[i, j] += a[i, k] * b[k, j]
    return out


@jit
def row_times(row, a, factor):
    """A row times a matrix times a number."""
    out = np.zeros(6)
    for k in range(6):
        for j in range(6):
            out[j] += row[k] * a[k, j] * factor
    return out


@jit
def add(total, term, factor):
    """Add a multiple of ``term`` to the matrix ``total``, in place."""
    for i in range(6):
        for j in range(6):
            total[i, j] += factor * term[i, j]


@jit
def raise_to(bound, row):
    """Raise a row of bounds to the sizes of another, in place."""
    for i in range(6):
        bound[i] = max(bound[i], abs(row[i]))


@jit
def exponential(a, h):
    """exp(ah), by its series: for norms of at most about one."""
    total, term = identity(), identity()
    for k in range(1, 24):
        term = product(term, a)
        for i in range(6):
            for j in range(6):
                term[i, j] *= h / k
        add(total, term, 1.0)
    return total


@jit
def spread(bound, a, h):
    """A row of bounds carried over times up to h, before and after, by exp(|a|h)."""
    sizes = np.zeros((6, 6))
    for i in range(6):
        for j in range(6):
            sizes[i, j] = abs(a[i, j])
    return row_times(bound, exponential(sizes, h), 1.0)


@jit
def powers(a, count):
    """aʲ for j = 1 … count, by products of two that are known, so that rounding adds up but log₂ j times."""
    out = np.zeros((count, 6, 6))
    add(out[0], a, 1.0)
    for j in range(2, count + 1):
        add(out[j - 1], product(out[j // 2 - 1], out[j - j // 2 - 1]), 1.0)
    return out


@jit
def logarithm(a):
    """log a of a matrix whose eigenvalues lie within about a half of 1, by the series in a − 1."""
    rest, total = identity(), np.zeros((6, 6))
    add(total, a, 1.0)
    add(total, rest, -1.0)
    term, rest = total.copy(), total.copy()
    for k in range(2, 80):
        term = product(term, rest)
        add(total, term, (1.0 if k % 2 else -1.0) / k)
    return total
