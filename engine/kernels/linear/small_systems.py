"""Systems of a few to some tens of linear equations: solution, determinant, null vector.

Compiled loops: at this size a call of NumPy costs more than the sums. Nothing is taken to be symmetric or definite.

Plain twins: ``numpy.linalg`` (tests/engine/kernels/test_small_systems.py).
"""

import math

import numpy as np
from vibroscope.engine.kernels.compile.options import jit


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
