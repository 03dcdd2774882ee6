"""The pieces of a contact, and where within a step each of them ends.

Between two *pieces* the force of a contact is continuous and its derivative is not. Those of a law that is piecewise
linear are :data:`..equations.contact_law.PIECES`. Of the others, a piece ends where one of these falls below zero:

    "jankowski"        v                              while the bodies close, the reverse while they part
    "impact"           Kδⁿ + cS(δ/d)v                 in the piece that pushes, the reverse in the one without force

So the force may end before the gap opens: that ends a piece, and the gap ends the contact. The first of all that may
end a piece ends it. Where both ends of a step are in the piece, it may have ended and begun again between them: the
lowest point of what ends it is looked for, on a cubic, or on a parabola (:mod:`.contact_location`) in flight and with
spring and damper alone, and the step that ends there decides. A piece begins where what ended the former one is zero.
The search for its end begins at the end of the step, and takes only what falls to zero: there it rises.
"""

import math

from vibroscope.engine.kernels.compile.options import jit_inlined, jit_no_alloc
from vibroscope.engine.kernels.equations.contact_law import (
    BEYOND,
    FREE,
    IMPACT,
    JANKOWSKI,
    KELVIN_VOIGT,
    MAIN,
    OTHER,
    count_kinks,
    full_damping,
    is_piecewise_linear,
    kink,
    power,
)
from vibroscope.engine.kernels.time_stepping.contact_location import (
    AWAY,
    ITERATIONS,
    PRECISION,
    cubic_of,
    has_converged,
    motion_between,
    next_root,
    root_by_curvature,
    root_of_cubic,
    step_from,
    vertex_within,
)

GAP, FIRST, SECOND = range(3)  # what may end a piece
NOTHING = -1
SAME = 1e-12  # causes whose instants differ by less, as a share of the time to them, end a piece together
NEAR = 1e-12  # of a step, from which a kink is not solved for again: the motions around it are not of one parabola
# Of laws that are not linear the motion may change with a root of the distance: the last is taken after a change of …
SETTLED = 1e-9  # … so little of a step, where the next change …
FASTER = 1e-3  # … is this much smaller
AT_ONCE = 1e-9  # of a step: a kink that close to its beginning was just passed, or will be passed again at its end


@jit_inlined
def margin_of(law, gain, piece, which, depth, speed, knee):
    """What ends a piece where it falls below zero, of δ and v: the gap, or one of the kinks of the law.

    ``knee``: Kd of a law that is piecewise linear; without it the margin is linear in δ and v.
    """
    if which == GAP:
        return depth if piece != FREE else -depth
    side = 1.0 if piece == MAIN else -1.0
    if is_piecewise_linear(law.kind):
        beyond = OTHER + which - FIRST if piece == MAIN else piece
        return side * kink(law, beyond, law.stiffness * depth, gain * speed, knee)
    if law.kind == JANKOWSKI:
        return side * speed
    if not depth > 0.0:
        return 0.0
    share = full_damping(min(depth / law.penetration, 1.0))
    return side * (law.stiffness * power(depth, law.exponent) + gain * share * speed)


@jit_inlined
def margin(m, gain, piece, which, z):
    """What ends a piece where it falls below zero, of a motion."""
    return margin_of(m.law, gain, piece, which, -z[3], -z[4], m.law.stiffness * m.law.penetration)


@jit_inlined
def margin_rate(m, gain, piece, which, z):
    """The derivative of :func:`margin` over time."""
    depth, speed, growth = -z[3], -z[4], -z[5]
    if m.law.kind != IMPACT or which == GAP:
        return margin_of(m.law, gain, piece, which, speed, growth, 0.0)  # it is linear
    if not depth > 0.0:
        return 0.0
    share = min(depth / m.law.penetration, 1.0)
    damper = 6.0 * share * (1.0 - share) / m.law.penetration * speed * speed + full_damping(share) * growth
    rate = m.law.stiffness * m.law.exponent * power(depth, m.law.exponent) / depth * speed + gain * damper
    return rate if piece == MAIN else -rate


@jit_inlined
def kinks(m, piece):
    """How many kinks of the law may end a piece."""
    return 0 if piece == FREE else count_kinks(m.law.kind) if piece == MAIN else min(count_kinks(m.law.kind), 1)


@jit_inlined
def has_no_kinks(m, piece):
    """Whether a piece is a flight, or all of a contact of spring and damper alone: the gap alone ends it."""
    return piece == FREE or m.law.kind == KELVIN_VOIGT


@jit_no_alloc
def piece_at(m, gain, z):
    """The piece of a contact with this motion."""
    for which in range(FIRST, FIRST + kinks(m, MAIN)):
        if margin(m, gain, MAIN, which, z) < 0.0:
            return OTHER if which == FIRST else BEYOND
    return MAIN


@jit_inlined
def has_ended(piece, value):
    """Whether what ends a piece says so; a gap that is zero is closed."""
    return value < 0.0 or (value == 0.0 and piece == FREE)


@jit_no_alloc
def locate_end(m, gain, piece, which, z, end, length, at):
    """Where a piece ends that the step from ``z`` to ``end`` leaves, the motion there, and steps solved to find it.

    Arguments as those of :func:`locate_change`.
    """
    low, high, theta, there, beyond, solves = 0.0, length, length, end, end, 0
    value, begun = margin(m, gain, piece, which, end), margin(m, gain, piece, which, z)
    last, rate = value, margin_rate(m, gain, piece, which, z)
    least, near = AWAY if which == GAP and not begun > 0.0 else 0.0, 1.0 if has_no_kinks(m, piece) else NEAR
    if which == GAP:
        better = root_by_curvature(begun, rate, z[5] if piece == FREE else -z[5], value, length)
    else:
        better = root_of_cubic(begun, rate, value, margin_rate(m, gain, piece, which, end), length)
    for i in range(ITERATIONS):
        if has_ended(piece, value):
            high, beyond = theta, there
        else:
            low = theta
        if abs(better - theta) <= PRECISION * length:
            high, beyond = theta, there
            break
        if high - low <= PRECISION * length:
            break
        if not max(low, least * high) < better < high or i % 8 == 7:
            better = 0.5 * (low + high)
        former, earlier, before = there, theta, value
        there = step_from(m, gain, piece != FREE, z, better, at)
        value = margin(m, gain, piece, which, there)
        theta, solves = better, solves + 1
        if i == 0:
            better = next_root(begun, rate, last, length, theta, value)
            continue
        passed = theta - earlier
        slope = (value - before) / passed
        better = theta - value / slope if slope < 0.0 else -length  # outside, where it does not fall
        change = abs(better - theta)
        if piece != FREE and not is_piecewise_linear(m.law.kind):
            if abs(passed) <= SETTLED * length and change <= FASTER * abs(passed):
                high, beyond = theta, there
                break
        elif 0.0 < better < length and change <= near * length and has_converged(passed, change, length):
            high, beyond = better, motion_between(end, length, former, earlier, there, theta, better)
            break
    if which == GAP:  # a law that pulls to the last ends with a jump, beyond which nothing acts
        beyond = beyond[0], beyond[1], beyond[2], 0.0, beyond[4], beyond[5]
    return high, beyond, solves


@jit_inlined
def lowest(value, rate, last, last_rate, length):
    """When a cubic is lowest within a step, from its values and rates at both ends; 0 if it stays positive there."""
    beyond = last - length / 3.0 * last_rate
    ends = beyond > 0.0 or (last == 0.0 and last_rate == 0.0)  # … where the gap opens: not by rounding
    if not length > 0.0 or (value + length / 3.0 * rate > 0.0 and ends):
        return 0.0  # its coefficients in Bernstein's basis are positive, as those of most steps
    square, cube = cubic_of(value, rate, last, last_rate, length)
    square, linear = 3.0 * cube, 2.0 * square  # of the derivative, over length
    inner = linear * linear - 4.0 * square * rate
    if not inner > 0.0:
        return 0.0
    # the zero at which it rises, without a difference of like numbers
    root = math.sqrt(inner)
    at = -2.0 * rate / (linear + root) if linear > 0.0 else (root - linear) / (2.0 * square) if square != 0.0 else 0.0
    if not 0.0 < at < 1.0:
        return 0.0
    least = value + length * at * (rate + at * (0.5 * linear + at * square / 3.0))
    return at * length if least < 0.0 else 0.0


@jit_inlined
def asked_at(m, gain, piece, which, z, end, length):
    """When within a step one cause may have ended a piece: at the end, or at the lowest point of what ends it; else 0.

    Where the law has no kinks that is the vertex of a parabola (:mod:`.contact_location`), else the one of a cubic.
    """
    value, last = margin(m, gain, piece, which, z), margin(m, gain, piece, which, end)
    if has_ended(piece, last):
        return length
    if has_no_kinks(m, piece):
        sign = 1.0 if piece == FREE else -1.0
        rate, curvature = sign * z[4], 0.5 * sign * (z[5] + end[5])
        if m.stages.count > 0 and length > 0.0:
            curvature = 2.0 * ((last - value) / length - rate) / length
        return vertex_within(value, rate, curvature, length)
    rates = margin_rate(m, gain, piece, which, z), margin_rate(m, gain, piece, which, end)
    return lowest(value, rates[0], last, rates[1], length)


@jit_inlined
def stays(m, gain, piece, z, end, length):
    """Whether nothing can have ended a piece within a step, as in most steps."""
    if has_no_kinks(m, piece):
        return asked_at(m, gain, piece, GAP, z, end, length) == 0.0
    staying = True
    for which in range(1 + kinks(m, piece)):
        staying = staying and asked_at(m, gain, piece, which, z, end, length) == 0.0
    return staying


@jit_inlined
def passed_by(m, gain, piece, which, z, end, length, at):
    """A time within a step by which one of its causes has ended a piece, or 0; the motion then; steps solved.

    The step that ends at the lowest point decides whether the piece has ended there.
    """
    reach = asked_at(m, gain, piece, which, z, end, length)
    if reach == 0.0 or reach == length:
        return reach, end, 0
    there = step_from(m, gain, piece != FREE, z, reach, at)
    return (reach if has_ended(piece, margin(m, gain, piece, which, there)) else 0.0), there, 1


@jit_inlined
def following(piece, which):
    """The piece after one that is ended; of a contact that begins, MAIN for any."""
    if which == GAP:
        return MAIN if piece == FREE else FREE
    return MAIN if piece != MAIN else OTHER if which == FIRST else BEYOND


@jit_no_alloc
def locate_change(m, gain, piece, z, end, length, at):
    """The end of a piece within a step: the first of all that may end it.

    ``z`` and ``end`` are the motions at the beginning of the step, ``at`` an instant as in
    :func:`.contact_location.forcing_at`, and ``length`` later.

    Returns
    -------
    tuple
        When it ends, or ``length``; the motion there; the next piece, MAIN for any of a contact that begins, or the
        same; steps solved to find it.
    """
    solves, theta, there, after, cause = 0, length, end, piece, NOTHING
    # it begins on the surface, and does not move away from it: it ends where the step ends
    rests = not (margin(m, gain, piece, GAP, z) > 0.0 or margin_rate(m, gain, piece, GAP, z) > 0.0)
    which, left = GAP, 1 + kinks(m, piece)
    while left > 0:  # an end that is found shortens the step, in which the other causes are asked for again
        reach, motion, more = passed_by(m, gain, piece, which, z, there, theta, at)
        solves, left = solves + more, left - 1
        if reach > 0.0 and which == GAP and rests:
            after = following(piece, which) if reach == theta else after
        elif reach > 0.0:
            ended, motion, more = locate_end(m, gain, piece, which, z, motion, reach, at)
            solves += more
            if which != GAP and ended <= AT_ONCE * length:
                after = piece_at(m, gain, there) if after == piece else after
            elif cause == NOTHING or ended < theta * (1.0 - SAME):
                theta, there, after, cause, left = ended, motion, following(piece, which), which, kinks(m, piece)
        which = which + 1 if which < kinks(m, piece) else GAP
    return theta, there, after, solves
