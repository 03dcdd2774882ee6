"""Matrices to twice the usual number of digits, as sums of two float64 (Dekker 1971; Knuth, TAOCP 2, 4.2.2).

As in :mod:`.matrices` they are [B C; 0 R], and the zeros in the lower left are left out of products.

The tables of a phase are powers of one matrix. Rounded at each product, they would be wrong by several units in the
last place, always in the same sense, and would cause most of the error of a solution in closed form.

Plain twin: mpmath's matrix product and exponential (tests/engine/kernels/test_double_double.py).
"""

import numpy as np

from ..compile.options import jit
from .matrices import multiply

_SPLITTER = 134217729.0  # 2²⁷ + 1: splits a float64 into halves whose products are exact (Dekker)


def _products(begin):
    # Constant bounds let the compiler unroll the loops. Rows and columns before ``begin`` are left out.
    @jit
    def add_block(out, a, b, rows, inner, first):
        for i in range(rows[0], rows[1]):
            for k in range(inner[0], inner[1]):
                x, rest = a[0, i, k], a[1, i, k]
                t = _SPLITTER * x
                x1 = t - (t - x)
                x2 = x - x1
                for j in range(first, 6):
                    y = b[0, k, j]
                    t = _SPLITTER * y
                    y1 = t - (t - y)
                    y2 = y - y1
                    p = x * y
                    error = ((x1 * y1 - p) + x1 * y2 + x2 * y1) + x2 * y2
                    high = out[0, i, j]
                    total = high + p
                    virtual = total - high
                    lost = (high - (total - virtual)) + (p - virtual)
                    out[0, i, j] = total
                    out[1, i, j] += lost + error + (x * b[1, k, j] + rest * y)

    @jit
    def divide(out, divisor, rows, first):
        for i in range(rows[0], rows[1]):
            for j in range(first, 6):
                high, low = out[0, i, j], out[1, i, j]
                quotient = high
                if divisor != 1.0:
                    quotient = high / divisor
                    t = _SPLITTER * quotient
                    upper = t - (t - quotient)
                    low = (((high - divisor * upper) - divisor * (quotient - upper)) + low) / divisor
                out[0, i, j] = quotient + low
                out[1, i, j] = (quotient - out[0, i, j]) + low

    @jit
    def product(a, b, divisor):
        out = np.zeros((2, 6, 6))
        add_block(out, a, b, (begin, 4), (begin, 4), begin)
        add_block(out, a, b, (begin, 6), (4, 6), 4)
        divide(out, divisor, (begin, 4), begin)
        divide(out, divisor, (4, 6), 4)
        return out

    @jit
    def round_block(out, a, b, rows, inner, columns):
        # the factors are known to more digits than the product needs
        for i in range(rows[0], rows[1]):
            for j in range(columns[0], columns[1]):
                high, low = 0.0, 0.0
                for k in range(inner[0], inner[1]):
                    high += a[0, i, k] * b[0, k, j]
                    low += a[1, i, k] * b[0, k, j] + a[0, i, k] * b[1, k, j]
                out[i, j] = high + low

    @jit
    def rounded_product(a, b, out):
        round_block(out, a, b, (begin, 4), (begin, 4), (begin, 4))
        round_block(out, a, b, (begin, 4), (begin, 6), (4, 6))
        round_block(out, a, b, (4, 6), (4, 6), (4, 6))

    return product, rounded_product


_product, _rounded_product = _products(0)
_short_product, _short_rounded_product = _products(2)


@jit
def product(a, b, divisor, one_body):
    """Product of two (2, 6, 6) matrices, high parts first, divided by a small whole number; accurate to about 2⁻¹⁰⁰.

    ``one_body``: the first two rows and columns are left out (see :mod:`.matrices`), here and in what follows.
    """
    return _short_product(a, b, divisor) if one_body else _product(a, b, divisor)


@jit
def _times(a, h, one_body):
    """The matrix ah, (2, 6, 6)."""
    matrix, factor = np.zeros((2, 6, 6)), np.zeros((2, 6, 6))
    for i in range(6):
        factor[0, i, i] = h
        for j in range(6):
            matrix[0, i, j] = a[i, j]
    return product(matrix, factor, 1.0, one_body)


@jit
def _sum_up(matrix, total, terms, one_body):
    """Horner's rule on the first terms of the series of exp(matrix); ``total``: what follows them, over the last."""
    for k in range(terms, 0, -1):
        total = product(matrix, total, float(k), one_body)
        for i in range(6):
            high, low = total[0, i, i], total[1, i, i]
            total[0, i, i] = 1.0 + high
            virtual = total[0, i, i] - 1.0
            low += (1.0 - (total[0, i, i] - virtual)) + (high - virtual)
            total[1, i, i] = low
    return total


@jit
def exponential(a, h, terms, one_body):
    """exp(ah) of a (6, 6) matrix, ah of norm at most about one, by Horner's rule on its series; (2, 6, 6)."""
    total = np.zeros((2, 6, 6))
    for i in range(6):
        total[0, i, i] = 1.0
    return _sum_up(_times(a, h, one_body), total, terms, one_body)


@jit
def quick_exponential(a, h, terms, exact, one_body):
    """The same with no more than the first ``exact`` terms to twice the digits: the others are small where ah is."""
    matrix, total, image = _times(a, h, one_body), np.zeros((2, 6, 6)), np.zeros((6, 6))
    for i in range(6):
        total[0, i, i] = 1.0
    for k in range(terms, exact, -1):
        multiply(image, matrix[0], total[0])
        for i in range(6):
            for j in range(6):
                total[0, i, j] = image[i, j] / k
            total[0, i, i] += 1.0
    return _sum_up(matrix, total, exact, one_body)


@jit
def _copy(out, a):
    for n in range(2):
        for i in range(6):
            for j in range(6):
                out[n, i, j] = a[n, i, j]


@jit
def powers(a, count, one_body):
    """aʲ of a (2, 6, 6) matrix for j = 1 … count, rounded to float64: (count, 6, 6).

    Every eighth power and the first eight are computed to twice the digits; each other power is one product of these.
    """
    first, eighths, out = np.zeros((9, 2, 6, 6)), np.zeros((count // 8 + 1, 2, 6, 6)), np.zeros((count, 6, 6))
    for i in range(6):
        first[0, 0, i, i] = eighths[0, 0, i, i] = 1.0
    _copy(first[1], a)
    for j in range(2, 9):
        _copy(first[j], product(first[j // 2], first[j - j // 2], 1.0, one_body))
    _copy(eighths[1], first[8])
    for j in range(2, count // 8 + 1):
        _copy(eighths[j], product(eighths[j // 2], eighths[j - j // 2], 1.0, one_body))
    for j in range(1, count + 1):
        if one_body:
            _short_rounded_product(eighths[j // 8], first[j % 8], out[j - 1])
        else:
            _rounded_product(eighths[j // 8], first[j % 8], out[j - 1])
    return out
