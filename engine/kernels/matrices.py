"""Small matrices, (6, 6), written out as loops: at this size a library call costs more than the sums."""

import numpy as np

from .jit import bare, inlined, jit


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


@inlined
def multiply(out, a, b):
    """Write the product of two matrices to ``out``, which is neither.

    A row of the result is kept in six numbers, since what is written to an array the compiler must reckon to change a.
    """
    for i in range(6):
        s0, s1, s2, s3, s4, s5 = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
        for k in range(6):
            factor = a[i, k]
            s0 += factor * b[k, 0]
            s1 += factor * b[k, 1]
            s2 += factor * b[k, 2]
            s3 += factor * b[k, 3]
            s4 += factor * b[k, 4]
            s5 += factor * b[k, 5]
        out[i, 0], out[i, 1], out[i, 2], out[i, 3], out[i, 4], out[i, 5] = s0, s1, s2, s3, s4, s5


@jit
def product(a, b):
    """The product of two matrices."""
    out = np.empty((6, 6))
    multiply(out, a, b)
    return out


@inlined
def _image(row, a, factor):
    s0, s1, s2, s3, s4, s5 = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    for k in range(6):
        r = row[k]
        s0 += r * a[k, 0] * factor
        s1 += r * a[k, 1] * factor
        s2 += r * a[k, 2] * factor
        s3 += r * a[k, 3] * factor
        s4 += r * a[k, 4] * factor
        s5 += r * a[k, 5] * factor
    return s0, s1, s2, s3, s4, s5


@jit
def row_times(row, a, factor):
    """A row times a matrix times a number."""
    out = np.empty(6)
    out[0], out[1], out[2], out[3], out[4], out[5] = _image(row, a, factor)
    return out


@bare
def rows_times(out, row, tables, factor):
    """Write a row times each matrix of a table, (n, 6, 6), times a number to (n, 6)."""
    for j in range(out.shape[0]):
        out[j, 0], out[j, 1], out[j, 2], out[j, 3], out[j, 4], out[j, 5] = _image(row, tables[j], factor)


@bare
def raise_along(bound, row, tables):
    """Raise a row of bounds to the sizes of a row and of what each matrix of a table makes of it, in place."""
    b0, b1, b2 = max(bound[0], abs(row[0])), max(bound[1], abs(row[1])), max(bound[2], abs(row[2]))
    b3, b4, b5 = max(bound[3], abs(row[3])), max(bound[4], abs(row[4])), max(bound[5], abs(row[5]))
    for j in range(tables.shape[0]):
        s0, s1, s2, s3, s4, s5 = _image(row, tables[j], 1.0)
        b0, b1, b2 = max(b0, abs(s0)), max(b1, abs(s1)), max(b2, abs(s2))
        b3, b4, b5 = max(b3, abs(s3)), max(b4, abs(s4)), max(b5, abs(s5))
    bound[0], bound[1], bound[2], bound[3], bound[4], bound[5] = b0, b1, b2, b3, b4, b5


@jit
def add(total, term, factor):
    """Add a multiple of ``term`` to the matrix ``total``, in place."""
    for i in range(6):
        for j in range(6):
            total[i, j] += factor * term[i, j]


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
        multiply(out[j - 1], out[j // 2 - 1], out[j - j // 2 - 1])
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
