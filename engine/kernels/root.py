"""The first zero of a sum of exponentials, found by steps that cannot pass one.

With |f‴| ≤ M₃ (see :mod:`.modes`), Taylor's formula gives for a step h ≤ r

    f(s + h) ≥ f + f′h + (f″ − M₃ r/3) h²/2,

a parabola whose first positive root h(r) is known. On (0, min(r, h(r))) there is no zero. The largest such step is the
fixed point r = h(r); since h(r) falls with r, one trial and one correction come close to it from the safe side.

Where the same bounds show that f′ < 0 up to a point at which f < 0, exactly one zero lies between, and Newton's method,
held inside that bracket, finishes on the Taylor series about its beginning.

A short flight of a chatter rises less than f can be evaluated to: its f is a difference of large numbers. It starts at
f = 0 with a known f′, so there f/s is taken from its Taylor series, which keeps all digits.
"""

import math
from typing import NamedTuple

from .jit import jit
from .modes import REACH, at_anchor, bounds, cexp, combined, derivative, enough, nearby, rung, taylor

ROUNDING = 16 * 2.0**-52  # a derivative below this share of its bound is not told from zero
HIGHEST_ORDER = 5  # derivatives tried where a phase starts on the surface
LONGEST = 2.0  # steps are cut at this many M₂/M₃, about a third of a turn; beyond it the bounds certify nothing
MOST_TRIES = 100_000  # evaluations for one root; ordinary ones take 5 to 13
NEWTON_LIMIT = 8  # quadratic from within a quarter: 3 or 4 do


class Arrival(NamedTuple):
    """Where a phase ends: s (inf: not before the horizon; nan: undecided), f′ there, the exponentials, evaluations."""

    s: float
    rate: float
    e1: complex
    e2: complex
    e3: complex
    evaluations: int


@jit
def parabola_root(f, d1, m):
    """First positive root of f + d1 h + m h²/2, with f ≥ 0; inf if there is none."""
    disc = d1 * d1 - 2.0 * m * f
    if disc < 0.0:
        return math.inf
    if d1 < 0.0:
        return 2.0 * f / (math.sqrt(disc) - d1)
    return -(d1 + math.sqrt(disc)) / m if m < 0.0 else math.inf


@jit
def safe_step(f, d1, d2, m3, trial):
    """A step h ≤ trial with f > 0 on (0, h), near the largest that |f‴| ≤ m3 certifies."""
    reach = parabola_root(f, d1, d2 - m3 * trial / 3.0)
    if reach >= trial:
        return trial
    # h(r) falls about as r^(-1/2), so the fixed point lies near the mean weighted 1 : 2
    second = (trial + 2.0 * reach) / 3.0
    # where the cubic that bounds f from below has one positive root, its sign tells on which side of it a point lies
    if (d1 >= 0.0 or d2 <= 0.0) and f + second * (d1 + second * (0.5 * d2 - second * m3 / 6.0)) > 0.0:
        return second
    return reach


@jit
def falls_through(f, d1, d2, m3, b):
    """Whether certainly f′ < 0 on [0, b] and f(b) < 0."""
    falling = d1 + max(d2, 0.0) * b + 0.5 * m3 * b * b < 0.0
    return falling and f + b * (d1 + b * (0.5 * d2 + b * m3 / 6.0)) < 0.0


@jit
def horner(terms, first, count, s):
    """Σ terms[k] sᵏ⁻ᶠ over f = ``first`` ≤ k < ``count``, and its derivative."""
    value, slope = 0.0, 0.0
    for k in range(count - 1, first - 1, -1):
        slope = slope * s + value
        value = value * s + terms[k]
    return value, slope


@jit
def newton(terms, count, high):
    """The one zero in [0, high] of the polynomial Σ terms[k] sᵏ, which falls there, and its slope."""
    low, s = 0.0, 0.8 * high
    for _ in range(NEWTON_LIMIT):
        f, slope = horner(terms, 0, count, s)
        if f >= 0.0:
            low = s
        else:
            high = s
        nearer = s - f / slope
        if not low <= nearer <= high:
            nearer = 0.5 * (low + high)
        moved, s = abs(nearer - s), nearer
        if moved <= 1e-8 * s:  # quadratic: the next correction is below rounding
            break
    return s, horner(terms, 0, count, s)[1]


@jit
def hop(modes, terms, fastest, rate, d2, m3):
    """Zero s > 0 of a short f with f(0) = 0, f′(0) = ``rate`` > 0, f″(0) = ``d2``, and f′(s); (0, 0) if not short.

    The zero of the parabola is 2f′/|f″|. Where M₃ s stays small beside |f″| up to twice that, f has one zero there.
    """
    if d2 >= 0.0:
        return 0.0, 0.0
    s = -2.0 * rate / d2
    if m3 * s > -0.1 * d2 or fastest * s > 0.5 * REACH:
        return 0.0, 0.0
    one = complex(1.0, 0.0)
    count = enough(1.1 * fastest * s)
    taylor(modes, one, one, one, terms, count)
    terms[1] = rate
    for _ in range(NEWTON_LIMIT):
        quotient, slope = horner(terms, 1, count, s)  # f/s
        moved = quotient / slope
        s -= moved
        if abs(moved) <= 1e-8 * s:
            break
    return s, s * horner(terms, 1, count, s)[1]  # f′ = f/s + s (f/s)′


@jit
def first_order(modes, start):
    """Order and value of the first derivative, from order ``start`` on, that is told from zero at s = 0.

    Returns (HIGHEST_ORDER + 1, 0.0) if none is.
    """
    d = modes
    for _ in range(start):
        d = derivative(d)
    for order in range(start, HIGHEST_ORDER + 1):
        value = at_anchor(d)
        if abs(value) > ROUNDING * bounds(d)[0]:
            return order, value
        d = derivative(d)
    return HIGHEST_ORDER + 1, 0.0


@jit
def leave(modes, order):
    """A first step from s = 0 where f, …, f⁽ⁿ⁻¹⁾ vanish by construction; inf if nothing moves, nan if f falls.

    f ≥ f⁽ⁿ⁾ sⁿ/n! − Mₙ₊₁ sⁿ⁺¹/(n+1)! is positive up to (n+1) f⁽ⁿ⁾/Mₙ₊₁; half of it, to arrive well above zero.
    """
    order, value = first_order(modes, order)
    if value == 0.0:
        return math.inf
    if value < 0.0:
        return math.nan
    d = modes
    for _ in range(order):
        d = derivative(d)
    return 0.5 * (order + 1) * value / bounds(d)[1]


@jit
def nearby_all(modes, s, count):
    """The three exponentials at a small s."""
    return nearby(modes.pole1, s, count), nearby(modes.pole2, s, count), nearby(modes.pole3, s, count)


@jit
def undecided(s, tries):
    """An arrival that is none: s is inf or nan."""
    one = complex(1.0, 0.0)
    return Arrival(s, 0.0, one, one, one, tries)


@jit
def first_root(modes, ladder, together, order, rate, horizon):
    """First s > 0 with f(s) = 0, for f that starts positive.

    Parameters
    ----------
    modes : Modes
        f; its first derivative that is not zero at s = 0 has the given order and is positive.
    ladder : Ladder
    together : bool
        Whether the poles of f are the ladder's second set, those of the joined pendulums.
    order : int
        0 for f(0) > 0; the derivatives below ``order`` are zero by construction and taken as exactly zero.
    rate : float
        f′(0), where order is 1; more exact than the modes give it.
    horizon : float
        Search no further.

    Returns
    -------
    Arrival
        With s = inf if there is no zero before the horizon, and nan if bounds and rounding leave it open (amplitudes
        that cancel, as at the resonance of an almost undamped pendulum).
    """
    lengths, factors, terms = ladder.lengths, ladder.factors[1 if together else 0], ladder.terms
    m0, _, m2, m3 = bounds(modes)
    e1 = e2 = e3 = complex(1.0, 0.0)
    f, d1, d2 = combined(modes, e1, e2, e3)
    longest = LONGEST * m2 / m3 if m3 > 0.0 else math.inf
    margin = ROUNDING * m0  # what lies between f > −margin and f > 0 cannot be told; steps must not end in it
    s, step, tries = 0.0, 0.0, 0
    if order == 1:
        s, d1 = hop(modes, terms, ladder.fastest, rate, d2, m3)
        if s > 0.0:
            if s >= horizon:
                return undecided(math.inf, 1)
            e1, e2, e3 = nearby_all(modes, s, enough(ladder.fastest * s))
            return Arrival(s, d1, e1, e2, e3, 1)
        f, d1 = 0.0, rate
    elif order > 1:
        step = leave(modes, order)
        if not step < math.inf:
            return undecided(step, 0)
    while s < horizon:
        if tries > 0 or order < 2:
            if f <= 0.0 and d1 < 0.0:  # there is no zero before s, so f(s) is zero within rounding
                return Arrival(s, d1, e1, e2, e3, tries)
            guess = parabola_root(max(f, margin), d1, d2)
            length = 1.25 * guess
            if d1 < 0.0 and length * ladder.fastest <= REACH and falls_through(f, d1, d2, m3, length):
                count = enough(length * ladder.fastest)
                taylor(modes, e1, e2, e3, terms, count)
                more, d1 = newton(terms, count, length)
                if s + more >= horizon:
                    break
                n1, n2, n3 = nearby_all(modes, more, count)
                return Arrival(s + more, d1, e1 * n1, e2 * n2, e3 * n3, tries + 1)
            step = safe_step(max(f, margin), d1, d2, m3, min(guess, longest))
        j = rung(lengths, step)
        if j < lengths.shape[0]:
            step = lengths[j]
            e1, e2, e3 = e1 * factors[j, 0], e2 * factors[j, 1], e3 * factors[j, 2]
        else:
            e1, e2, e3 = e1 * cexp(modes.pole1, step), e2 * cexp(modes.pole2, step), e3 * cexp(modes.pole3, step)
        s += step
        f, d1, d2 = combined(modes, e1, e2, e3)
        tries += 1
        if tries > MOST_TRIES:
            return undecided(math.nan, tries)
    return undecided(math.inf, tries)
