"""The first zero of a watched quantity within one block of a phase, with a certificate that none is missed.

**Across the block.** f at the POINTS instants jh of the block is POINTS rows times one state. Where f exceeds

    b = h²/8 · sup|f″|,        |f″| ≤ Σᵢ sup|(w A² E)ᵢ| |zᵢ|                                      (35)

at both ends of an interval, it has no zero inside: f lies above its chord less b. Where f begins at zero, its slope
there says the same of the first interval.

Tables hold f − f*, f* the value at the phase's equilibrium (:mod:`.tables`), which is added to a polynomial as to all
of its Bernstein coefficients, and taken from the bound.

**Within an interval** that this leaves open, f is to rounding a polynomial in u = s/h. In Bernstein's basis it has no
zero in (0, 1) if its coefficients do not change sign, and exactly one if they change sign once (Descartes' rule); with
more changes the interval is bisected (de Casteljau). Halley's method then finishes from where the control polygon
crosses zero. A piece that still has several sign changes after DEEPEST bisections is a touch and is passed over.

A phase that starts on the contact surface starts with f = 0. There the polynomial is divided by uᵐ, m the order of the
first derivative that is not zero, so that a flight of any duration, even one whose f lies below the rounding of larger
numbers, is solved to all digits.

Plain twin: the sign of the quantity at 4096 instants of the block, and polynomials whose roots are known
(tests/engine/kernels/test_first_root.py).
"""

import math

from vibroscope.engine.kernels.compile.options import jit_inlined, jit_no_alloc
from vibroscope.engine.kernels.linear.tables import (
    BERNSTEIN,
    DEEPEST,
    LOW,
    POINTS,
    POSITION,
    POWERS,
    SPAN,
    TERMS,
    TO_BERNSTEIN,
    VALUES,
    WORK,
    curvature_bound,
    dot,
    find_values,
    find_watched,
    pulled_by,
    state_after,
)

_N = TERMS - 1
HALLEY_LIMIT = 12  # iterations; two are enough for most zeros
NONE = -1.0
CHECKED_AT_ONCE = 8
SAFE = 1e-12  # coefficients above this share of a constant that was added to them have a sign beyond rounding


@jit_inlined
def first_at_most(values, level, start):
    """Index of the first value from ``start`` on that does not exceed the level; POINTS if there is none."""
    for chunk in range(start & -CHECKED_AT_ONCE, POINTS, CHECKED_AT_ONCE):
        least = values[chunk]
        for k in range(chunk + 1, chunk + CHECKED_AT_ONCE):
            least = min(least, values[k])
        if not least > level:
            for k in range(max(chunk, start), chunk + CHECKED_AT_ONCE):
                if not values[k] > level:
                    return k
    return POINTS


@jit_no_alloc
def to_bernstein(terms, b):
    """Coefficients in Bernstein's basis on (0, 1), from those of the powers."""
    for j in range(TERMS):
        b[j] = 0.0
        for k in range(j + 1):
            b[j] += TO_BERNSTEIN[k, j] * terms[k]


@jit_inlined
def sign_changes(b, start):
    """Changes of sign from b[start] on, zero counting as negative."""
    count = 0
    for k in range(start + 1, TERMS):
        count += (b[k] > 0.0) != (b[k - 1] > 0.0)
    return count


@jit_no_alloc
def bisect(b, right):
    """De Casteljau's algorithm: b becomes the left half, ``right`` the right one."""
    for k in range(TERMS):
        right[k] = b[k]
    # after round m, right[j] for j ≥ 0 holds the m-th averages from the left end on
    for m in range(1, TERMS):
        for j in range(TERMS - m):
            right[j] = 0.5 * (right[j] + right[j + 1])
        b[m] = right[0]
    # right[j] now is the average of order n − j that ends at the last coefficient


@jit_inlined
def polynomial_and_derivatives(terms, u):
    """Σ terms[k] uᵏ, its derivative, and half its second derivative.

    Even and odd powers apart: two short chains of dependent sums instead of a long one.
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


@jit_inlined
def polygon_root(b, order):
    """Where the control polygon of f/uᵐ crosses zero, as a share of the interval; m = ``order`` is 0 or 1.

    If f = u q, then jbⱼ = n q₍ⱼ₋₁₎.
    """
    k = order + 1
    while b[k] > 0.0:
        k += 1
    before, here = b[k - 1], b[k]
    if order == 1:
        before, here = before * k, here * (k - 1.0)
    return (k - 1.0 - order + before / (before - here)) / (_N - order)


@jit_inlined
def halley(terms, u, low, high):
    """The only zero in (low, high) of a polynomial that falls there, and its slope: Halley's method from ``u``.

    A step that would leave the bracket is replaced by a bisection.
    """
    for _ in range(HALLEY_LIMIT):
        value, slope, curve = polynomial_and_derivatives(terms, u)
        if value > 0.0:
            low = u
        else:
            high = u
        nearer = u - value * slope / (slope * slope - value * curve)
        if not low <= nearer <= high:
            nearer = 0.5 * (low + high)
        change, u = abs(nearer - u), nearer
        # cubic convergence: the next correction is below rounding, near a double zero only if this one is short beside
        # its distance
        if change <= 1e-5 * u and change * abs(curve) <= 1e-5 * abs(slope):
            break
    return u, polynomial_and_derivatives(terms, u)[1]


@jit_no_alloc
def first_zero_by_bisection(terms, b, scratch):
    """First zero in (0, 1), and the slope there, of a polynomial with terms[0] > 0 whose coefficients change sign."""
    low, width, depth = 0.0, 1.0, 0
    while True:
        changes = sign_changes(b, 0)
        if changes == 1:
            return halley(terms, low + width * polygon_root(b, 0), low, low + width)
        if changes > 1 and width > 2.0**-DEEPEST:
            width *= 0.5
            bisect(b, scratch.stack[depth])
            scratch.stack[depth, LOW], scratch.stack[depth, SPAN] = low + width, width
            depth += 1
            continue
        if depth == 0:
            return NONE, 0.0
        depth -= 1
        low, width = scratch.stack[depth, LOW], scratch.stack[depth, SPAN]
        for k in range(TERMS):
            b[k] = scratch.stack[depth, k]
        if not b[0] > 0.0:  # a touch that bisection cannot tell from a zero
            return low, min(polynomial_and_derivatives(terms, low)[1], 0.0)


@jit_no_alloc
def add_constant(value, order, powers, b):
    """Add a constant to a polynomial in both bases; with an order above 0 the sum begins at zero exactly."""
    if order == 0:
        powers[0] += value
        for k in range(TERMS):
            b[k] += value
        return
    powers[0] = b[0] = 0.0
    least = math.inf
    for k in range(1, TERMS):
        b[k] += value
        least = min(least, b[k])
    if not least > SAFE * abs(value):  # the sum of two large numbers loses the digits of a short flight
        to_bernstein(powers, b)


@jit_inlined
def first_zero_in_interval(phase, z, order, scratch):
    """First zero of f in (0, h], as u = s/h, and f′ there; (NONE, 0) if there is none.

    ``order``: of the first derivative that is not zero at the beginning; f is positive just after it.
    """
    find_watched(phase, z, scratch)
    b, powers = scratch.products[BERNSTEIN:POWERS], scratch.products[POWERS:POSITION]
    if phase.watched != 0.0:
        add_constant(phase.watched, order, powers, b)
    least = b[1]
    for k in range(2, TERMS):
        least = min(least, b[k])
    # at first order b[0] = 0, and the others have the signs of the coefficients of f/u
    if least > 0.0 and (order == 1 or (order == 0 and b[0] > 0.0)):
        return NONE, 0.0
    shift = order
    if order == 0 and b[0] <= 0.0:  # zero within rounding: the previous block ended here
        if powers[1] < 0.0:
            return 0.0, powers[1] / phase.spacing
        shift = 1
    terms = scratch.products[WORK : WORK + TERMS]
    for k in range(TERMS):
        terms[k] = powers[k + shift] if k + shift < TERMS else 0.0
    if order <= 1 and shift == order and b[order] > 0.0 and sign_changes(b, order) == 1:
        u, slope = halley(terms, polygon_root(b, order), 0.0, 1.0)
    else:
        if shift > 0:
            to_bernstein(terms, b)
        u, slope = first_zero_by_bisection(terms, b, scratch)
    for _ in range(shift):
        slope *= u
    return u, slope / phase.spacing


@jit_inlined
def first_root(phase, z, order, scratch):
    """First zero of f within the block that begins at z.

    Parameters
    ----------
    phase : Phase
    z : (6,) tuple of float64
    order : int
        0 if f > 0 at the beginning, else the order of the first derivative that is not zero; that must be positive.
    scratch : Scratch

    Returns
    -------
    (int, float, float, int)
        Interval and u where the zero lies, s = (interval + u) h; f′ there; intervals examined.
        The interval is POINTS if there is no zero.
    """
    bound = curvature_bound(phase, z)
    values, level = scratch.products[VALUES:BERNSTEIN], bound - phase.watched
    # a certificate of the first interval, without its polynomial
    certain = False
    if order == 0:  # as for the others, from f at both ends
        find_values(phase, z, scratch)
        certain = values[0] > level and dot(phase.rows[:, POWERS], z) > level
    elif order == 1:  # f begins with u ∂f/∂u at u = 0, from which it deviates by 4u²b at most
        certain = dot(phase.rows[:, POWERS + 1], z) + pulled_by(phase, POWERS + 1) > 4.0 * bound
    if not certain:
        u, slope = first_zero_in_interval(phase, z, order, scratch)
        if u >= 0.0:
            return 0, u, slope, 1
    if order != 0:
        find_values(phase, z, scratch)
    examined, i = 1, 1
    while i < POINTS:
        # values[k] belongs to the instant k + 1
        k = first_at_most(values, level, i - 1) + 1
        if k > POINTS:
            break
        i = max(i, k - 1)
        if i == POINTS:
            break
        u, slope = first_zero_in_interval(phase, state_after(phase, z, i), 0, scratch)
        examined += 1
        if u >= 0.0:
            return i, u, slope, examined
        i += 1
    return POINTS, 0.0, 0.0, examined
