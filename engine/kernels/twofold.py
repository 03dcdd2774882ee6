"""Matrices to twice the usual number of digits, as sums of two float64 (Dekker 1971; Knuth, TAOCP 2, 4.2.2).

The tables of a phase are powers of one matrix. Rounded at each product, they are wrong by several units in the last
place, always in the same sense, and that is most of what a march in closed form would be wrong by.
"""

import numpy as np

from .jit import exact

_SPLITTER = 134217729.0  # 2²⁷ + 1: parts a float64 into halves whose products are exact


@exact
def product(a, b):
    """The product of two (2, 6, 6) matrices, high parts first, good to about 2⁻¹⁰⁰."""
    high, low = np.zeros((6, 6)), np.zeros((6, 6))
    for i in range(6):
        for k in range(6):
            x, rest = a[0, i, k], a[1, i, k]
            t = _SPLITTER * x
            x1 = t - (t - x)
            x2 = x - x1
            for j in range(6):
                y = b[0, k, j]
                t = _SPLITTER * y
                y1 = t - (t - y)
                y2 = y - y1
                p = x * y
                error = ((x1 * y1 - p) + x1 * y2 + x2 * y1) + x2 * y2
                total = high[i, j] + p
                virtual = total - high[i, j]
                lost = (high[i, j] - (total - virtual)) + (p - virtual)
                high[i, j] = total
                low[i, j] += lost + error + (x * b[1, k, j] + rest * y)
    return _normal(high, low)


@exact
def _normal(high, low):
    out = np.empty((2, 6, 6))
    out[0] = high + low
    out[1] = (high - out[0]) + low
    return out


@exact
def scaled(a, h):
    """A (6, 6) matrix times a number."""
    left = np.zeros((2, 6, 6))
    right = np.zeros((2, 6, 6))
    left[0] = a
    for i in range(6):
        right[0, i, i] = h
    return product(left, right)


@exact
def divided(a, k):
    """A (2, 6, 6) matrix over a whole number."""
    high = a[0] / k
    # the remainder a − k high, exactly, from the halves of high
    t = _SPLITTER * high
    upper = t - (t - high)
    left = ((a[0] - k * upper) - k * (high - upper)) + a[1]
    return _normal(high, left / k)


@exact
def exponential(a, terms):
    """exp of a (2, 6, 6) matrix of norm at most about one, by Horner's rule on its series."""
    total = np.zeros((2, 6, 6))
    total[0] = np.eye(6)
    for k in range(terms, 0, -1):
        total = divided(product(a, total), k)
        total[0] += np.eye(6)
        total = _normal(total[0], total[1])
    return total


@exact
def _rounded_product(a, b, out):
    # of two factors that are known to more digits than the product is wanted to
    for i in range(6):
        for j in range(6):
            high, low = 0.0, 0.0
            for k in range(6):
                high += a[0, i, k] * b[0, k, j]
                low += a[1, i, k] * b[0, k, j] + a[0, i, k] * b[1, k, j]
            out[i, j] = high + low


@exact
def powers(a, count):
    """aʲ for j = 1 … count, rounded to float64: (count, 6, 6).

    Every eighth and the first eight are known to twice the digits; the others are one product of those.
    """
    first, eighths = np.zeros((9, 2, 6, 6)), np.zeros((count // 8 + 1, 2, 6, 6))
    first[0, 0] = eighths[0, 0] = np.eye(6)
    first[1] = a
    for j in range(2, 9):
        first[j] = product(first[j // 2], first[j - j // 2])
    if count >= 8:
        eighths[1] = first[8]
    for j in range(2, count // 8 + 1):
        eighths[j] = product(eighths[j // 2], eighths[j - j // 2])
    out = np.zeros((count, 6, 6))
    for j in range(1, count + 1):
        if j % 8 == 0:
            out[j - 1] = eighths[j // 8, 0]
        else:
            _rounded_product(eighths[j // 8], first[j % 8], out[j - 1])
    return out
