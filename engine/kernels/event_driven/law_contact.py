"""A contact whose law is not linear, from step to step by a method of high order.

The extrapolated midpoint rule of Gragg, Bulirsch and Stoer (Hairer, Nørsett & Wanner, Solving Ordinary Differential
Equations I (1993), section II.9): COLUMNS midpoint rules with 2, 4, 6, … parts of a step, extrapolated in the square of
their parts to order 2·COLUMNS. Numbers are counted from the beginning of the step, so that rounding is a share of what
a step changes. The step is chosen so that the last two columns agree within CONTACT_TOLERANCE, relative to the speeds:
where the law has a kink, or where the force begins as a power δⁿ, steps become as short as that needs.

A contact ends where the gap is zero again: there the last step is repeated with other sizes, by Newton's method within
a bracket. The excursion of a gap that opens and closes within one step is sought at its largest.

The force of "impact", Eq. (21), has kinks: at the penetration d of full damping, and where it begins or ends to be cut
at zero. A step that would pass one, either way, ends there. Until then its midpoint rules keep to the formula of the
side that it begins on, which is smooth. A cut that begins and ends within one step, or a push between two cuts, is
sought where what is cut has its turn.

Plain twin: DOP853 with events (tests/engine/test_law_exact.py).
"""

import math
from typing import NamedTuple

import numpy as np
from vibroscope.engine.kernels.compile.options import jit_inlined, jit_no_alloc
from vibroscope.engine.kernels.equations.contact_law import IMPACT, ContactLaw, full_damping, gain_at, law_force, power
from vibroscope.engine.kernels.event_driven.state import load_at
from vibroscope.engine.kernels.linear.tables import Phase, Scratch

COLUMNS = 6
ORDER = 2 * COLUMNS - 1  # of the column that is compared with the last
CONTACT_TOLERANCE = 3e-14
TRIES = 60  # sizes of one step
REPEATS = 60  # of the last step
FALSE_POSITIONS = 10  # of these, after which the bracket is halved
TURN = 1e-5  # of a step, within which the turn of what is cut is known
LARGEST, SMALLEST = 4.0, 0.1  # factors from step to step
NUMBERS = 5  # ξ₁, ξ₁′, g, g′ and ∫λ, each from the beginning of a step; of the start: ξ₁, ξ₁′, g, g′, side
BELOW, BEYOND, PULLS = 0.0, 1.0, 2.0  # sides of kinks: below d, beyond d, the force cut at zero
START, FIRST, SLOPE, FORMER, HERE, POINT, TABLE = 0, 1, 2, 3, 4, 5, 6  # rows of the work space
WORK = TABLE + COLUMNS


class LawSystem(NamedTuple):
    """Flight, the pieces of a piecewise linear law, and the numbers of any law; a row or an item for each piece.

    Pieces: :data:`..equations.contact_law.PIECES`, 0 is the flight. Each watches one quantity or two, item
    2·piece + k of their tables.
    """

    period: float
    eta: float
    rigid: bool  # false
    wall: float  # as in HybridSystem, and so the next three
    clearance: float
    play: float
    sign: float
    law: ContactLaw
    react1: float  # what a unit of λ does to ξ₁″ and to g″
    inverse_mass: float
    generator: np.ndarray  # (4, 7) of the separated bodies
    flight: Phase
    spacing: np.ndarray  # (4,) as in linear.tables.Phase, and so the next seven
    position: np.ndarray
    gap: np.ndarray
    pulled: np.ndarray
    watched: np.ndarray  # (8,)
    rows: np.ndarray  # (8, 7, …)
    transitions: np.ndarray  # (4, …)
    offsets: np.ndarray  # (4, …)
    counts: np.ndarray  # (4,) int64: watched quantities
    targets: np.ndarray  # (8,) int64: the mode that follows
    mirrored: np.ndarray  # (8,) int64: which of its watched quantities then begins at zero, −1 if none
    impulse: np.ndarray  # (4, 7): ∫λ = row·Δz + last·s
    load: np.ndarray  # (7,) as in HybridSystem
    segments: np.ndarray  # of its load, one after the other
    scratch: Scratch
    work: np.ndarray  # (WORK, NUMBERS)


@jit_inlined
def damping_of(p, depth, side):
    """S of Eq. (21) by the formula of a side."""
    return 1.0 if side == BEYOND else full_damping(depth / p.law.penetration)


@jit_inlined
def force_of_side(p, gain, depth, speed, side):
    """λ in a step, by the formula of the side that it begins on."""
    if p.law.kind == IMPACT and depth > 0.0:
        if side == PULLS:
            return 0.0
        return p.law.stiffness * power(depth, p.law.exponent) + gain * damping_of(p, depth, side) * speed
    return law_force(p.law, gain, depth, speed)


@jit_no_alloc
def pushes(p, gain, gap, rate):
    """A number with the sign of what Eq. (21) cuts at zero: it over δⁿ, and in the limit where δ is not positive."""
    depth = -gap
    if depth > 0.0:
        share = full_damping(min(depth / p.law.penetration, 1.0))
        return p.law.stiffness - gain * share * rate / power(depth, p.law.exponent)
    if p.law.exponent < 2.0:
        return p.law.stiffness
    damper = -3.0 * gain * rate / (p.law.penetration * p.law.penetration)
    return p.law.stiffness + damper if p.law.exponent == 2.0 else damper


@jit_inlined
def write_slope(p, tau, gain, begin, y, out):
    """Write y′ of what a step has changed so far, y, since ``begin``."""
    c, s = load_at(p, tau, tau / p.period)
    x, v, g, r = begin[0] + y[0], begin[1] + y[1], begin[2] + y[2], begin[3] + y[3]
    force = force_of_side(p, gain, -g, -r, begin[4])
    x, h = x - p.position[0], g - p.gap[0]
    a = p.generator
    out[0], out[2], out[4] = v, r, force
    out[1] = a[1, 0] * x + a[1, 1] * v + a[1, 4] * c + a[1, 5] * s + a[1, 6] - p.react1 * force
    out[3] = a[3, 0] * x + a[3, 1] * v + a[3, 2] * h + a[3, 3] * r + a[3, 4] * c + a[3, 5] * s + a[3, 6]
    out[3] += p.inverse_mass * force


@jit_no_alloc
def extrapolate(p, tau, gain, size):
    """Take a step of this size from the row START at ``tau``; returns its error over the tolerance.

    What it changes is in the row TABLE. A size of zero changes nothing.
    """
    begin, first, slope = p.work[START], p.work[FIRST], p.work[SLOPE]
    before, here, point = p.work[FORMER], p.work[HERE], p.work[POINT]
    table = p.work[TABLE:]
    for i in range(NUMBERS):
        point[i] = 0.0
    write_slope(p, tau, gain, begin, point, first)
    for j in range(COLUMNS):
        parts = 2 * (j + 1)
        h = size / parts
        for i in range(NUMBERS):
            before[i], here[i] = 0.0, h * first[i]
        for m in range(1, parts):
            write_slope(p, tau + m * h, gain, begin, here, slope)
            for i in range(NUMBERS):
                before[i], here[i] = here[i], before[i] + 2.0 * h * slope[i]
        write_slope(p, tau + size, gain, begin, here, slope)
        for i in range(NUMBERS):  # Gragg's smoothing; without it the slope at the beginning would have no part
            table[j, i] = 0.5 * (here[i] + before[i] + h * slope[i])
        for k in range(j - 1, -1, -1):
            ratio = (j + 1.0) / (k + 1.0)
            for i in range(NUMBERS):
                table[k, i] = table[k + 1, i] + (table[k + 1, i] - table[k, i]) / (ratio * ratio - 1.0)
    speed = abs(begin[1]) + abs(begin[3]) + size * (abs(first[1]) + abs(first[3])) + abs(table[0, 1]) + abs(table[0, 3])
    error = abs(table[0, 1] - table[1, 1]) + abs(table[0, 3] - table[1, 3])
    if size > 0.0:
        error += (abs(table[0, 0] - table[1, 0]) + abs(table[0, 2] - table[1, 2])) / size
    if not speed < math.inf:  # the formula of a side overflows far from it
        return math.inf
    return error / (CONTACT_TOLERANCE * speed) if speed > 0.0 else 0.0


@jit_inlined
def is_beyond(p, a):
    """Whether a contact goes on beyond the penetration of full damping."""
    level = a.gap + p.law.penetration
    return level < 0.0 or (level == 0.0 and a.rate < 0.0)


@jit_inlined
def set_start(p, a):
    """Let steps begin at a hybrid state; returns c or h of its contact."""
    row = p.work[START]
    row[0], row[1], row[2], row[3] = a.x1, a.v1, a.gap, a.rate
    row[4], gain = BELOW, gain_at(p.law, a.contact.closing)
    if p.law.kind == IMPACT:
        pulls = a.order < 0.0 or (a.order == 0.0 and pushes(p, gain, a.gap, a.rate) < 0.0)
        row[4] = PULLS if pulls else BEYOND if is_beyond(p, a) else BELOW
    return gain


@jit_inlined
def stepped(p):
    """(ξ₁, ξ₁′, g, g′) at the end of the step."""
    begin, change = p.work[START], p.work[TABLE]
    return begin[0] + change[0], begin[1] + change[1], begin[2] + change[2], begin[3] + change[3]


@jit_inlined
def first_size(p, a):
    """The first step to try in a contact: a share of the time that the closing speed takes to use up its energy."""
    size = 0.1 * p.flight.spacing
    if a.rate < 0.0:
        squared = 0.5 * (p.law.exponent + 1.0) * a.rate * a.rate / (p.inverse_mass * p.law.stiffness)
        size = min(size, -0.02 * squared ** (1.0 / (p.law.exponent + 1.0)) / a.rate)
    return size


@jit_no_alloc
def step_to(p, tau, gain, level, sign, passed_after):
    """The step after which the gap has a level, known to be passed after the step ``passed_after``.

    ``sign``: 1 where the gap grows to it, −1 where it falls.
    """
    low, high, size = 0.0, passed_after, passed_after
    for _ in range(REPEATS):
        extrapolate(p, tau, gain, size)
        _, _, gap, rate = stepped(p)
        gap, rate = sign * (gap - level), sign * rate
        if gap > 0.0:
            high = size
        else:
            low = size
        nearer = size - gap / rate if rate > 0.0 else low
        if not low < nearer < high:
            nearer = 0.5 * (low + high)
        if abs(nearer - size) <= 2.0**-52 * passed_after:
            break
        size = nearer
    extrapolate(p, tau, gain, size)
    return size


@jit_no_alloc
def step_to_depth(p, a, gain, size):
    """The step to the penetration of full damping, or ``size`` if a step of that does not pass it; steps tried.

    A penetration that passes it and returns is sought at its turn. The work space holds the step that is returned.
    """
    level, sign, passed_after = -p.law.penetration, 1.0 if is_beyond(p, a) else -1.0, size
    _, _, gap, rate = stepped(p)
    if not sign * (gap - level) > 0.0:
        if not sign * a.rate > 0.0 > sign * rate:
            return size, 0
        passed_after = size * a.rate / (a.rate - rate)
        extrapolate(p, a.tau, gain, passed_after)
        if not sign * (stepped(p)[2] - level) > 0.0:
            extrapolate(p, a.tau, gain, size)
            return size, 2
    return step_to(p, a.tau, gain, level, sign, passed_after), 2


@jit_no_alloc
def change_of_push(p, gain, gap, rate, acceleration):
    """The rate of what :func:`pushes` returns, at a positive penetration δ: that of K + cS(δ/d)v/δⁿ."""
    depth, share = -gap, min(-gap / p.law.penetration, 1.0)
    damping, slope = full_damping(share), 6.0 * share * (1.0 - share) / p.law.penetration
    inner = rate * rate * (slope - p.law.exponent * damping / depth) - damping * acceleration
    return gain * inner / power(depth, p.law.exponent)


@jit_no_alloc
def stepped_change_of_push(p, tau, gain, size, sign):
    """The same at the end of the step, times ``sign``; where the contact is open there, it has had its turn: −1."""
    _, _, gap, rate = stepped(p)
    if not gap < 0.0:
        return -1.0
    write_slope(p, tau + size, gain, p.work[START], p.work[TABLE], p.work[SLOPE])
    return sign * change_of_push(p, gain, gap, rate, p.work[SLOPE, 3])


@jit_inlined
def narrowed(low, below, high, above, last, at, value):
    """A bracket of a zero, with the values at its ends, narrowed by a value within (Illinois).

    The value at an end that stays is halved if it has stayed before; ``last``: 1 if the upper end moved, −1 the lower.
    """
    if (value > 0.0) == (above > 0.0):
        return low, below * (0.5 if last > 0 else 1.0), at, value, 1
    return at, value, high, above * (0.5 if last < 0 else 1.0), -1


@jit_no_alloc
def step_to_turn(p, a, gain, size, sign):
    """The step to where what is cut has the other sign, at or before its turn, or ``size`` if it keeps its own.

    ``sign``: 1 where the force is cut. The work space holds the step that is returned.
    """
    _, _, _, rate = stepped(p)
    if not rate > 0.0:  # while the bodies close, the damper pushes
        return size
    low, high, above = 0.0, size, stepped_change_of_push(p, a.tau, gain, size, sign)
    begun = sign * change_of_push(p, gain, a.gap, a.rate, p.work[FIRST, 3]) if a.rate > 0.0 > a.gap else -above
    if not begun > 0.0 > above:
        return size
    below, last = begun, 0
    while high - low > TURN * size:
        middle = (low * above - high * below) / (above - below)
        if not low + 0.5 * TURN * size < middle < high - 0.5 * TURN * size:
            middle = 0.5 * (low + high)
        extrapolate(p, a.tau, gain, middle)
        _, _, gap, rate = stepped(p)
        if gap < 0.0 and sign * pushes(p, gain, gap, rate) > 0.0:
            return middle
        value = stepped_change_of_push(p, a.tau, gain, middle, sign)
        low, below, high, above, last = narrowed(low, below, high, above, last, middle, value)
    extrapolate(p, a.tau, gain, size)
    return size


@jit_no_alloc
def step_to_cut(p, a, gain, size):
    """The step to where the force begins or ends to be cut, or ``size`` if a step of that does not pass it.

    By false position (Illinois), since what :func:`pushes` returns has no derivative at hand, and by halves where that
    is slow: shortly before a contact opens it is steep. Where the force would set in so late that rounding does not
    show it before the contact opens, it stays cut.
    """
    sign = 1.0 if p.work[START, 4] == PULLS else -1.0
    _, _, gap, rate = stepped(p)
    above, below = sign * pushes(p, gain, gap, rate), sign * pushes(p, gain, a.gap, a.rate)
    high = size
    if not above > 0.0:
        high = step_to_turn(p, a, gain, size, sign)
        if high == size:
            return size
        _, _, gap, rate = stepped(p)
        above = sign * pushes(p, gain, gap, rate)
    low, last = 0.0, 0
    for repeat in range(REPEATS):
        if high - low <= 2.0**-50 * size:
            break
        middle = high - above * (high - low) / (above - below) if below < 0.0 and repeat < FALSE_POSITIONS else low
        if not low < middle < high:
            middle = 0.5 * (low + high)
        extrapolate(p, a.tau, gain, middle)
        _, _, gap, rate = stepped(p)
        value = sign * pushes(p, gain, gap, rate)
        low, below, high, above, last = narrowed(low, below, high, above, last, middle, value)
    extrapolate(p, a.tau, gain, high)
    if sign > 0.0 and stepped(p)[2] >= 0.0:
        extrapolate(p, a.tau, gain, size)
        return size
    return high


@jit_no_alloc
def take_step(p, a, longest):
    """A step of the contact from a hybrid state, no longer than ``longest``; its changes are in the row TABLE.

    Returns
    -------
    tuple
        Its size, negative if there is none that is exact enough; the size to try next, negative where the force then
        is cut; whether the contact ends with it; whether it ends at the penetration of full damping; steps tried.
    """
    gain, asked, tries = set_start(p, a), (abs(a.order) if a.order != 0.0 else first_size(p, a)), 0
    size = min(asked, longest)
    while True:
        error = extrapolate(p, a.tau, gain, size)
        tries += 1
        if error <= 1.0:
            break
        if tries > TRIES:
            return -1.0, 0.0, False, False, tries
        size *= max(SMALLEST, 0.9 * error ** (-1.0 / ORDER)) if error < math.inf else SMALLEST
    following = size * (LARGEST if error < 1e-9 else min(LARGEST, 0.9 * error ** (-1.0 / ORDER)))
    following = min(following, p.flight.spacing * 4.0)
    if size == longest:
        following = max(following, asked)
    if p.law.kind == IMPACT:
        to_depth, more = step_to_depth(p, a, gain, size)
        shorter = step_to_cut(p, a, gain, to_depth)
        pulls = (p.work[START, 4] == PULLS) == (shorter == to_depth)
        _, _, gap, rate = stepped(p)
        if pulls:
            following = -following
        elif shorter < to_depth and rate > 0.0:  # the force sets in: no long step, whose parts lie beyond the end
            following = min(following, -0.1 * gap / rate)
        if shorter < size:
            return shorter, following, False, shorter == to_depth, tries + more
    _, _, gap, rate = stepped(p)
    ends = gap > 0.0
    if not ends and a.rate > 0.0 > rate:
        largest = size * a.rate / (a.rate - rate)
        extrapolate(p, a.tau, gain, largest)
        tries += 1
        if stepped(p)[2] > 0.0:
            size, ends = largest, True
        else:
            extrapolate(p, a.tau, gain, size)
    if ends:
        size = step_to(p, a.tau, gain, 0.0, 1.0, size)
    return size, following, ends, False, tries
