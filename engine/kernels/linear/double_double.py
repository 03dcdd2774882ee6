"""Matrices to twice the usual number of digits, as sums of two float64 (Dekker 1971; Knuth, TAOCP 2, 4.2.2).

As in :mod:`.matrices` they are [B C; 0 R], and the zeros in the lower left are left out of products.

The tables of a phase are powers of one matrix. Rounded at each product, they would be wrong by several units in the
last place, always in the same sense, and would cause most of the error of a solution in closed form.

Plain twin: mpmath's matrix product and exponential (tests/engine/kernels/test_double_double.py).
"""

import numpy as np
from vibroscope.engine.kernels.compile.options import jit, jit_inlined, jit_no_alloc
from vibroscope.engine.kernels.linear import matrices

_SPLITTER = 134217729.0  # 2²⁷ + 1: splits a float64 into halves whose products are exact (Dekker)


@jit_inlined
def _add_product(high, low, x, rest, y, other):
    """high + low plus the product of x + rest and y + other."""
    t = _SPLITTER * x
    x1 = t - (t - x)
    x2 = x - x1
    t = _SPLITTER * y
    y1 = t - (t - y)
    y2 = y - y1
    p = x * y
    error = ((x1 * y1 - p) + x1 * y2 + x2 * y1) + x2 * y2
    total = high + p
    virtual = total - high
    lost = (high - (total - virtual)) + (p - virtual)
    return total, low + (lost + error + (x * other + rest * y))


@jit_inlined
def _quotient(high, low, divisor):
    """high + low over a small whole number, as the sum of two numbers of which the second is small."""
    quotient = high
    if divisor != 1.0:
        quotient = high / divisor
        t = _SPLITTER * quotient
        upper = t - (t - quotient)
        low = (((high - divisor * upper) - divisor * (quotient - upper)) + low) / divisor
    total = quotient + low
    return total, (quotient - total) + low


@jit_inlined
def _block(out, a, b, divisor, rows, inner, columns):
    # bounds are constants where this is called, which lets the compiler unroll the loops
    for i in range(rows[0], rows[1]):
        for j in range(columns[0], columns[1]):
            high, low = 0.0, 0.0
            for k in range(inner[0], inner[1]):
                high, low = _add_product(high, low, a[0, i, k], a[1, i, k], b[0, k, j], b[1, k, j])
            out[0, i, j], out[1, i, j] = _quotient(high, low, divisor)


@jit_no_alloc
def multiply(out, a, b, divisor):
    """Write a product of two (2, 6, 6) matrices, high parts first, divided by a small whole number, to ``out``.

    It is accurate to about 2⁻¹⁰⁰. ``out`` is neither of the two, and holds zeros in the lower left.
    """
    _block(out, a, b, divisor, (0, 4), (0, 4), (0, 4))
    _block(out, a, b, divisor, (0, 4), (0, 6), (4, 6))
    _block(out, a, b, divisor, (4, 6), (4, 6), (4, 6))


@jit_inlined
def _rounded_block(out, a, b, rows, inner, columns):
    # the factors are known to more digits than the product needs
    for i in range(rows[0], rows[1]):
        for j in range(columns[0], columns[1]):
            high, low = 0.0, 0.0
            for k in range(inner[0], inner[1]):
                high += a[0, i, k] * b[0, k, j]
                low += a[1, i, k] * b[0, k, j] + a[0, i, k] * b[1, k, j]
            out[i, j] = high + low


@jit_no_alloc
def _rounded_product(a, b, out):
    _rounded_block(out, a, b, (0, 4), (0, 4), (0, 4))
    _rounded_block(out, a, b, (0, 4), (0, 6), (4, 6))
    _rounded_block(out, a, b, (4, 6), (4, 6), (4, 6))


@jit
def _times(a, h):
    """The matrix ah, (2, 6, 6)."""
    matrix, factor, plain = np.zeros((2, 6, 6)), np.zeros((2, 6, 6)), np.zeros((2, 6, 6))
    for i in range(6):
        factor[0, i, i] = h
        for j in range(6):
            plain[0, i, j] = a[i, j]
    multiply(matrix, plain, factor, 1.0)
    return matrix


@jit
def _sum_up(matrix, total, terms):
    """Horner's rule on the first terms of the series of exp(matrix); ``total``: what follows them, over the last."""
    other = np.zeros((2, 6, 6))
    for k in range(terms, 0, -1):
        multiply(other, matrix, total, float(k))
        total, other = other, total
        for i in range(6):
            high, low = total[0, i, i], total[1, i, i]
            total[0, i, i] = 1.0 + high
            virtual = total[0, i, i] - 1.0
            low += (1.0 - (total[0, i, i] - virtual)) + (high - virtual)
            total[1, i, i] = low
    return total


@jit
def exponential(a, h, terms):
    """exp(ah) of a (6, 6) matrix, ah of norm at most about one, by Horner's rule on its series; (2, 6, 6)."""
    total = np.zeros((2, 6, 6))
    for i in range(6):
        total[0, i, i] = 1.0
    return _sum_up(_times(a, h), total, terms)


@jit
def quick_exponential(a, h, terms, exact):
    """The same with no more than the first ``exact`` terms to twice the digits: the others are small where ah is."""
    matrix, total, image = _times(a, h), np.zeros((2, 6, 6)), np.zeros((6, 6))
    for i in range(6):
        total[0, i, i] = 1.0
    for k in range(terms, exact, -1):
        matrices.multiply(image, matrix[0], total[0])
        for i in range(6):
            for j in range(6):
                total[0, i, j] = image[i, j] / k
            total[0, i, i] += 1.0
    return _sum_up(matrix, total, exact)


@jit_no_alloc
def _copy(out, a):
    for n in range(2):
        for i in range(6):
            for j in range(6):
                out[n, i, j] = a[n, i, j]


@jit
def powers(a, count):
    """aʲ of a (2, 6, 6) matrix for j = 1 … count, rounded to float64: (count, 6, 6).

    Every eighth power and the first eight are computed to twice the digits; each other power is one product of these.
    """
    first, eighths, out = np.zeros((9, 2, 6, 6)), np.zeros((count // 8 + 1, 2, 6, 6)), np.zeros((count, 6, 6))
    for i in range(6):
        first[0, 0, i, i] = eighths[0, 0, i, i] = 1.0
    _copy(first[1], a)
    for j in range(2, 9):
        multiply(first[j], first[j // 2], first[j - j // 2], 1.0)
    _copy(eighths[1], first[8])
    for j in range(2, count // 8 + 1):
        multiply(eighths[j], eighths[j // 2], eighths[j - j // 2], 1.0)
    for j in range(1, count + 1):
        _rounded_product(eighths[j // 8], first[j % 8], out[j - 1])
    return out
