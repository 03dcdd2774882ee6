"""The first zero of a watched quantity within one block of a phase, found so that none can be passed.

**Across the block.** f at the POINTS instants jh of the block is POINTS rows times one state. Where f exceeds
c = h²/8 · sup|f″| at both ends of an interval, it has no zero within: f lies above its chord by no less than −c.

**Within an interval** that this leaves open f is, to rounding, a polynomial in u = s/h. In Bernstein's basis it has no
zero in (0, 1) if no coefficient changes sign, and exactly one if there is one change (Descartes' rule); with more
changes the interval is halved (de Casteljau). Newton's method then finishes from where the control polygon falls
through zero.

A phase that starts on the surface starts with f = 0: there the polynomial is divided by uᵐ, m the order of the first
derivative that is not zero, so that a flight of any shortness, its f below what rounding leaves of larger numbers,
is solved to all digits.
"""

from ..compile.options import bare, inlined
from .tables import (
    BERNSTEIN,
    DEEPEST,
    FIRST,
    LOW,
    POINTS,
    POWERS,
    SPAN,
    TERMS,
    TERMS_LEFT,
    TO_BERNSTEIN,
    VALUES,
    bend,
    find_values,
    find_watched,
    moved,
)

_N = TERMS - 1
NEWTON_LIMIT = 12
NONE = -1.0
CHUNK = 8


@inlined
def first_not_above(values, level, start):
    """Index of the first value from ``start`` on that is not above the level; POINTS if there is none."""
    for chunk in range(start & -CHUNK, POINTS, CHUNK):
        low = 0
        for k in range(chunk, chunk + CHUNK):  # counted without a branch: one vector instruction
            low += not (values[k] > level)
        if low > 0:
            for k in range(max(chunk, start), chunk + CHUNK):
                if not values[k] > level:
                    return k
    return POINTS


@bare
def to_bernstein(terms, b):
    """Coefficients in Bernstein's basis on (0, 1), from those of the powers."""
    for j in range(TERMS):
        b[j] = 0.0
        for k in range(j + 1):
            b[j] += TO_BERNSTEIN[k, j] * terms[k]


@inlined
def sign_changes(b, start):
    """Changes of sign from b[start] on, zero counting as negative."""
    count = 0
    for k in range(start + 1, TERMS):
        count += (b[k] > 0.0) != (b[k - 1] > 0.0)
    return count


@bare
def halve(b, right):
    """De Casteljau: b becomes the left half, ``right`` the right one."""
    for k in range(TERMS):
        right[k] = b[k]
    # after round m, right[j] for j ≥ 0 holds the m-th averages from the left end on
    for m in range(1, TERMS):
        for j in range(TERMS - m):
            right[j] = 0.5 * (right[j] + right[j + 1])
        b[m] = right[0]
    # right[j] now is the average of order n − j that ends at the last coefficient


@inlined
def curve_at(terms, u):
    """Σ terms[k] uᵏ, its derivative, and half its second derivative.

    Even and odd powers apart, which are two short chains of sums in place of a long one.
    """
    w = u * u
    even, even1, even2 = terms[_N - 1], 0.0, 0.0
    odd, odd1, odd2 = terms[_N], 0.0, 0.0
    for k in range(_N - 3, -1, -2):
        even2, odd2 = even2 * w + even1, odd2 * w + odd1
        even1, odd1 = even1 * w + even, odd1 * w + odd
        even, odd = even * w + terms[k], odd * w + terms[k + 1]
    # f = e(w) + u o(w), w = u²
    value = even + u * odd
    slope = 2.0 * u * even1 + odd + 2.0 * w * odd1
    return value, slope, even1 + 3.0 * u * odd1 + 4.0 * w * (even2 + u * odd2)


@inlined
def falls_through(b, order):
    """Where the control polygon of f/uᵐ falls through zero, as a share of the interval; m = ``order`` is 0 or 1.

    If f = u q, then jbⱼ = n q₍ⱼ₋₁₎.
    """
    k = order + 1
    while b[k] > 0.0:
        k += 1
    before, here = b[k - 1], b[k]
    if order == 1:
        before, here = before * k, here * (k - 1.0)
    return (k - 1.0 - order + before / (before - here)) / (_N - order)


@inlined
def polish(terms, u, low, high, most):
    """The one zero in (low, high) of the polynomial, which falls through it, and its slope there.

    Halley's method from ``u``, held inside the bracket.
    """
    for _ in range(most):
        value, slope, curve = curve_at(terms, u)
        if value > 0.0:
            low = u
        else:
            high = u
        nearer = u - value * slope / (slope * slope - value * curve)
        if not low <= nearer <= high:
            nearer = 0.5 * (low + high)
        change, u = abs(nearer - u), nearer
        # cubic, so the next correction is below rounding; near a double zero only once it is short beside its distance
        if change <= 1e-5 * u and change * abs(curve) <= 1e-5 * abs(slope):
            break
    return u, curve_at(terms, u)[1]


@bare
def open_interval(terms, b, scratch):
    """First zero in (0, 1), and the slope there, of a polynomial with terms[0] > 0 whose coefficients change sign."""
    low, width, depth = 0.0, 1.0, 0
    while True:
        changes = sign_changes(b, 0)
        if changes == 1:
            return polish(terms, low + width * falls_through(b, 0), low, low + width, NEWTON_LIMIT)
        if changes > 1 and width > 2.0**-DEEPEST:
            width *= 0.5
            halve(b, scratch.stack[depth])
            scratch.stack[depth, LOW], scratch.stack[depth, SPAN] = low + width, width
            depth += 1
            continue
        if depth == 0:
            return NONE, 0.0
        depth -= 1
        low, width = scratch.stack[depth, LOW], scratch.stack[depth, SPAN]
        for k in range(TERMS):
            b[k] = scratch.stack[depth, k]
        if not b[0] > 0.0:  # a touch that halving could not tell from a zero
            return low, min(curve_at(terms, low)[1], 0.0)


@inlined
def in_interval(phase, z, order, most, scratch):
    """First zero of f in (0, h], as u = s/h, and f′ there; (NONE, 0) if there is none.

    ``order``: of the first derivative that is not zero at the beginning, where f is positive from then on.
    """
    find_watched(phase, z, scratch)
    b, powers = scratch.products[BERNSTEIN:POWERS], scratch.products[POWERS:FIRST]
    low = 0
    for k in range(TERMS):
        low += not (b[k] > 0.0)
    # at first order b[0] = 0, and the others have the signs of the coefficients of f/u
    if low == order and order <= 1 and b[TERMS - 1] > 0.0 and (order == 1 or b[0] > 0.0):
        return NONE, 0.0
    shift = order
    if order == 0 and b[0] <= 0.0:  # zero within rounding: the block before ended here
        if powers[1] < 0.0:
            return 0.0, powers[1] / phase.spacing
        shift = 1
    terms = scratch.products[TERMS_LEFT : TERMS_LEFT + TERMS]
    for k in range(TERMS):
        terms[k] = powers[k + shift] if k + shift < TERMS else 0.0
    if order <= 1 and shift == order and b[order] > 0.0 and sign_changes(b, order) == 1:
        u, slope = polish(terms, falls_through(b, order), 0.0, 1.0, most)
    else:
        if shift > 0:
            to_bernstein(terms, b)
        u, slope = open_interval(terms, b, scratch)
    for _ in range(shift):
        slope *= u
    return u, slope / phase.spacing


@inlined
def first_root(phase, z, order, most, scratch):
    """First zero of f within the block that begins at z.

    Parameters
    ----------
    phase : Phase
    z : (6,) tuple of float64
    order : int
        0 if f > 0 at the beginning, else that of the first derivative which is not zero there; it must be positive.
    most : int
        Corrections of the zero, NEWTON_LIMIT for one that is exact to rounding.
    scratch : Scratch

    Returns
    -------
    (int, float, float, int)
        Interval and u where the zero lies, s = (interval + u) h; f′ there; intervals examined.
        The interval is POINTS if there is no zero.
    """
    u, slope = in_interval(phase, z, order, most, scratch)
    if u >= 0.0:
        return 0, u, slope, 1
    examined, i = 1, 1
    find_values(phase, z, scratch)
    values, level = scratch.products[VALUES:BERNSTEIN], bend(phase, z)
    while i < POINTS:
        # values[k] belongs to the instant k + 1
        k = first_not_above(values, level, i - 1) + 1
        if k > POINTS:
            break
        i = max(i, k - 1)
        if i == POINTS:
            break
        u, slope = in_interval(phase, moved(phase, z, i), 0, most, scratch)
        examined += 1
        if u >= 0.0:
            return i, u, slope, examined
        i += 1
    return POINTS, 0.0, 0.0, examined
