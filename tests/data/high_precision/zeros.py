"""The first zero of a polynomial that is known to within a bound: certified, or undecided."""

from itertools import pairwise
from math import comb

from mpmath import mp, mpf

from high_precision.series import horner

BITS = 560  # of the integers whose signs decide: 1e-168


class Undecided(ArithmeticError):
    """More digits are needed to decide whether there is an event."""


def sign_changes(b, bound):
    """Changes of sign of Bernstein coefficients; None if one of them may be zero."""
    if any(-bound <= x <= bound for x in b):
        return None
    return sum((x > 0) != (y > 0) for x, y in pairwise(b))


def halves(b):
    """Bernstein coefficients on both halves (de Casteljau), with 2^-BITS lost at each level."""
    left, right = [b[0]], [b[-1]]
    while len(b) > 1:
        b = [(x + y) >> 1 for x, y in pairwise(b)]
        left.append(b[0])
        right.append(b[-1])
    return left, right[::-1]


def bernstein(coefficients):
    """Σ cⱼ sʲ on [0, 1] in Bernstein form, integers in units of 2^-BITS; bᵢ = Σ C(i, j)/C(n, j) cⱼ."""
    n = len(coefficients) - 1
    line = [int(mp.ldexp(c, BITS)) // comb(n, j) for j, c in enumerate(coefficients)]
    b = []
    while line:  # Pascal's triangle: b₀ = c₀, and each line of sums loses its last
        b.append(line[0])
        line = [x + y for x, y in pairwise(line)]
    return b


def first_zero(coefficients, order, remainder):
    """First s in (0, 1] with f(s) = 0, or None; f = Σ cⱼ sʲ starts positive, its ``order`` lowest terms vanish."""
    q = coefficients[order:]
    bound = int(mp.ldexp(remainder, BITS)) + (1 << (len(q) + 10))
    parts = [(bernstein(q), mpf(0), mpf(1))]
    if parts[0][0][0] <= bound:
        raise Undecided("f does not start positive")
    while parts:
        b, low, width = parts.pop()
        count = sign_changes(b, bound)
        if count == 0:
            if b[0] < 0:
                raise Undecided("f is negative without a zero")
            continue
        if count == 1:
            return polish(q, low, low + width)
        if width < mpf(2) ** -300:
            raise Undecided("double zero")
        left, right = halves(b)
        parts += [(right, low + width / 2, width / 2), (left, low, width / 2)]
    return None


def polish(q, low, high):
    """The only zero in [low, high] of a polynomial positive at ``low``, by Newton's method kept in the bracket."""
    slopes = [j * c for j, c in enumerate(q)][1:]
    near = mpf(10) ** (-0.65 * mp.dps)  # a step this short leaves an error of about its square
    s = -q[0] / q[1] if q[1] < 0 else low  # a good guess for the short flights of a chatter
    s = s if low < s < high else (low + high) / 2
    for _ in range(40 * mp.dps):
        value = horner(q, s)
        low, high = (s, high) if value > 0 else (low, s)
        slope = horner(slopes, s)
        nearer = s - value / slope if slope != 0 else low
        if abs(nearer - s) <= abs(s) * near:
            return nearer
        s = nearer if low < nearer < high else (low + high) / 2
    raise Undecided("no convergence")
