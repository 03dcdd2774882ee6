"""Small matrices, written out as loops: at this size a library call costs more than the sums.

All of them act on z: a state of four numbers, then cos ητ and sin ητ. The excitation does not depend on the motion, so
they are (6, 6) with zeros in the lower left, [B C; 0 R]. Products leave the zeros out, and with them nearly half of
the sums.

Systems of a few to some tens of linear equations: solution, determinant, null vector.

Compiled loops: at this size a call of NumPy costs more than the sums. Nothing is taken to be symmetric or definite.

Plain twins: ``numpy.linalg`` (tests/engine/kernels/test_small_systems.py).
"""

import math

import numpy as np
from vibroscope.engine.kernels.compile.options import jit, jit_inlined, jit_no_alloc


@jit
def eliminate(matrix, right):
    """Gaussian elimination with partial pivoting, in place; returns the sign of the row exchanges.

    The upper triangle of ``matrix``, (n, n), becomes U; the rows of ``right``, (n, k), are changed with its own. A
    column whose pivot is zero is left as it is.
    """
    n, sign = matrix.shape[0], 1.0
    for k in range(n):
        best = k
        for i in range(k + 1, n):
            if abs(matrix[i, k]) > abs(matrix[best, k]):
                best = i
        if best != k:
            sign = -sign
            for j in range(n):
                matrix[k, j], matrix[best, j] = matrix[best, j], matrix[k, j]
            for j in range(right.shape[1]):
                right[k, j], right[best, j] = right[best, j], right[k, j]
        pivot = matrix[k, k]
        if pivot == 0.0:
            continue
        for i in range(k + 1, n):
            factor = matrix[i, k] / pivot
            if factor == 0.0:
                continue
            for j in range(k + 1, n):
                matrix[i, j] -= factor * matrix[k, j]
            for j in range(right.shape[1]):
                right[i, j] -= factor * right[k, j]
    return sign


@jit
def solve(matrix, right):
    """Replace ``right``, (n, k), by the solution of ``matrix``·x = right; ``matrix``, (n, n), is changed.

    A singular matrix gives numbers that are not finite.
    """
    eliminate(matrix, right)
    n = matrix.shape[0]
    for j in range(right.shape[1]):
        for i in range(n - 1, -1, -1):
            value = right[i, j]
            for k in range(i + 1, n):
                value -= matrix[i, k] * right[k, j]
            right[i, j] = value / matrix[i, i]


@jit
def relative_determinant(matrix):
    """The determinant relative to Hadamard's bound of it, the product of the lengths of the rows: smooth, in [−1, 1].

    nan if an element is not finite, or a row is zero.
    """
    work, none = matrix.copy(), np.zeros((matrix.shape[0], 0))
    logarithm = 0.0
    for i in range(work.shape[0]):
        square = 0.0
        for j in range(work.shape[1]):
            square += work[i, j] * work[i, j]
        logarithm -= 0.5 * np.log(square)
    sign = eliminate(work, none)
    for i in range(work.shape[0]):
        pivot = work[i, i]
        if pivot == 0.0:
            return 0.0 if math.isfinite(logarithm) else math.nan
        sign = -sign if pivot < 0.0 else sign
        logarithm += np.log(abs(pivot))
    return sign * math.exp(logarithm)


@jit
def null_vector(matrix):
    """The vector of length one that a (n, n + 1) matrix maps to zero; nan if an element is not finite.

    The last column of Q in Mᵀ = QR, by Householder's reflections.
    """
    n = matrix.shape[0]
    work, found = matrix.copy(), np.zeros(n + 1)
    for k in range(n):
        row, square = work[k], 0.0
        for j in range(k, n + 1):
            square += row[j] * row[j]
        if not math.isfinite(square):
            found[:] = np.nan
            return found
        if square == 0.0:
            continue
        row[k] += math.copysign(math.sqrt(square), row[k])
        half = 0.0
        for j in range(k, n + 1):
            half += row[j] * row[j]
        for i in range(k + 1, n):
            reflect(work[i], row, k, half)
    found[n] = 1.0
    for k in range(n - 1, -1, -1):
        square = 0.0
        for j in range(k, n + 1):
            square += work[k, j] * work[k, j]
        if square > 0.0:
            reflect(found, work[k], k, square)
    return found


@jit
def reflect(vector, normal, begin, square):
    """Reflect a vector, in place, in the plane with this normal of squared length ``square``, zero before ``begin``."""
    along = 0.0
    for j in range(begin, vector.shape[0]):
        along += vector[j] * normal[j]
    along *= 2.0 / square
    for j in range(begin, vector.shape[0]):
        vector[j] -= along * normal[j]


@jit
def unit(i):
    """Row i of the unit matrix, (6,)."""
    row = np.zeros(6)
    row[i] = 1.0
    return row


@jit_inlined
def image(row, a):
    """A row times a matrix, as six numbers.

    Not as an array: the compiler would have to assume that writing it changes the matrix.
    """
    s0, s1, s2, s3, s4, s5 = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    for k in range(4):
        r = row[k]
        s0 += r * a[k, 0]
        s1 += r * a[k, 1]
        s2 += r * a[k, 2]
        s3 += r * a[k, 3]
        s4 += r * a[k, 4]
        s5 += r * a[k, 5]
    for k in range(4, 6):
        r = row[k]
        s4 += r * a[k, 4]
        s5 += r * a[k, 5]
    return s0, s1, s2, s3, s4, s5


@jit_inlined
def multiply(out, a, b):
    """Write the product of two matrices to ``out``, which is neither and holds zeros in the lower left."""
    for i in range(4):
        out[i, 0], out[i, 1], out[i, 2], out[i, 3], out[i, 4], out[i, 5] = image(a[i], b)
    for i in range(4, 6):
        c, s = a[i, 4], a[i, 5]
        out[i, 4], out[i, 5] = c * b[4, 4] + s * b[5, 4], c * b[4, 5] + s * b[5, 5]


@jit_no_alloc
def fill_powers(out, a):
    """Write aʲ for j = 1 … len(out), each as a product of two earlier ones, so that rounding adds up only log₂ j times.

    ``out``, (n, 6, 6), holds zeros in the lower left of each.
    """
    for i in range(6):
        for j in range(6):
            out[0, i, j] = a[i, j]
    for j in range(2, out.shape[0] + 1):
        multiply(out[j - 1], out[j // 2 - 1], out[j - j // 2 - 1])


@jit
def row_times(row, a):
    """A row times a matrix."""
    out = np.empty(6)
    out[0], out[1], out[2], out[3], out[4], out[5] = image(row, a)
    return out


@jit_no_alloc
def rows_times(out, row, tables):
    """Write a row times each matrix of a table, (n, 6, 6), to (n, 6)."""
    for j in range(out.shape[0]):
        out[j, 0], out[j, 1], out[j, 2], out[j, 3], out[j, 4], out[j, 5] = image(row, tables[j])


@jit_no_alloc
def raise_to_images(bound, row, tables):
    """Raise a row of bounds, in place, to |row| and to |row·M| for each matrix M of a table."""
    b0, b1, b2 = max(bound[0], abs(row[0])), max(bound[1], abs(row[1])), max(bound[2], abs(row[2]))
    b3, b4, b5 = max(bound[3], abs(row[3])), max(bound[4], abs(row[4])), max(bound[5], abs(row[5]))
    for j in range(tables.shape[0]):
        s0, s1, s2, s3, s4, s5 = image(row, tables[j])
        b0, b1, b2 = max(b0, abs(s0)), max(b1, abs(s1)), max(b2, abs(s2))
        b3, b4, b5 = max(b3, abs(s3)), max(b4, abs(s4)), max(b5, abs(s5))
    bound[0], bound[1], bound[2], bound[3], bound[4], bound[5] = b0, b1, b2, b3, b4, b5


@jit
def raise_within(bound, a, h):
    """Raise a row of bounds to what they may become within h, by exp(|a|h), which majorises exp(as) for |s| ≤ h.

    24 terms suffice while the eigenvalues of |a|h are at most some units.
    """
    sizes = np.abs(a)
    t0, t1, t2, t3, t4, t5 = bound[0], bound[1], bound[2], bound[3], bound[4], bound[5]
    b0, b1, b2, b3, b4, b5 = t0, t1, t2, t3, t4, t5
    for k in range(1, 24):
        share = h / k
        t0, t1, t2, t3, t4, t5 = image((t0, t1, t2, t3, t4, t5), sizes)
        t0, t1, t2, t3, t4, t5 = t0 * share, t1 * share, t2 * share, t3 * share, t4 * share, t5 * share
        b0, b1, b2, b3, b4, b5 = b0 + t0, b1 + t1, b2 + t2, b3 + t3, b4 + t4, b5 + t5
    bound[0], bound[1], bound[2], bound[3], bound[4], bound[5] = b0, b1, b2, b3, b4, b5
