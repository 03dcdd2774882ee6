"""Located steps with other contact laws than spring and damper: cut at each change of contact, and at kinks of the law.

The grid, the changes of contact and what is recorded are those of :mod:`.located`. The force within a stage is solved
for (:mod:`.law_step`), and of a stage of any length, too. A contact has *pieces*, between which its force is continuous
and its derivative is not; a step is cut where one of these falls below zero:

    "cut"              Kδ + cv                        in the piece that pushes, the reverse in the one without force
    "limited"          Kδ − cv and Kδ + cv            in the middle piece, the reverse in each of the others
    "compression", "jankowski"    v                   while the bodies close, the reverse while they part
    "impact"           Kδⁿ + cS(δ/d)v                 as with "cut"

So the force may end before the gap opens: that ends a piece, and the gap ends the contact. A step is cut at the first
of all that may end its piece. Where both ends of a step are in the piece, it may have ended and begun again between
them: the lowest point of what ends it is looked for, in flight on a parabola as in :mod:`.contact_location`, in contact
on a cubic, and the step that ends there decides. A piece begins where what ended the former one is zero. The search
for its end begins at the end of the step, and takes only what falls to zero: there it rises.

A cut keeps the order of an integrator where the force of the law is as smooth as that needs. Near touch the damper of
"jankowski" acts as δ^¼ and that of "constant-restitution" as δ^((n−1)/2), which leave the orders 5/4 and 1 + (n − 1)/2
wherever a step ends.

Plain twin: tests/naive_law_located.py.
"""

import math
from typing import NamedTuple

from ..compile.options import jit_inlined, jit_no_alloc
from ..compile.packing import Layout
from ..compile.record import OpenContact, no_contact, no_room, with_impulse
from ..equations.contact_law import COMPRESSION, CUT, IMPACT, JANKOWSKI, LIMITED, full_damping, gain_at, law_force
from ..status import DIVERGED, OK, PAUSED, UNRESOLVED
from .contact_location import (
    ITERATIONS,
    PRECISION,
    LocatedScheme,
    cubic_of,
    forcing_at,
    has_converged,
    root_of_cubic,
    vertex_within,
    with_accelerations,
)
from .law_step import solve_force
from .located import (
    SOLVES_PER_STEP,
    LocatedState,
    begin_contact,
    end_contact,
    halvings_at,
    motion_of,
    points_passed,
    write_output,
)
from .newmark import LIMIT

FREE, MAIN, OTHER, BEYOND = range(4)  # pieces: flight, that of most of a contact, and those beyond its kinks
GAP, FIRST, SECOND = range(3)  # what may end a piece
NOTHING = -1
SAME = 1e-12  # causes whose instants differ by less, as a share of the time to them, end a piece together
AT_ONCE = 1e-9  # of a step: a kink that close to its beginning was just passed, or will be passed again at its end


class LawScheme(NamedTuple):
    """The grid and the stages, and the law in the place of the contact's spring and damper."""

    located: LocatedScheme
    law: int
    stiffness: float
    exponent: float
    penetration: float
    gain: float  # as in :class:`..parameters.Parameters`
    relative: float


class LawState(NamedTuple):
    """The discrete solution, at a step of the grid or between two."""

    located: LocatedState
    piece: int


STATE = Layout(LawState, located=Layout(LocatedState, contact=Layout(OpenContact)))
unpack_state, write_state = STATE.unpack, STATE.write


@jit_inlined
def gain_of(m, contact):
    """c, or h of Eq. (18), of the open contact."""
    return gain_at(m, contact.speed1 - contact.speed2)


@jit_inlined
def force_of(m, gain, pressed, z):
    """λ of a motion."""
    return law_force(m.law, m.stiffness, gain, m.exponent, m.penetration, -z[3], -z[4]) if pressed else 0.0


@jit_no_alloc
def with_law_accelerations(m, gain, pressed, z, forcing):
    """The motion with a and b from the equations; ``forcing``: f₁ and f."""
    t, push = m.located.stages, force_of(m, gain, pressed, z)
    x, v, a, g, u, b = with_accelerations(m.located.separated, z, forcing)
    return x, v, a - t.react1 * push, g, u, b + t.inverse_mass * push


@jit_inlined
def margin_of(m, gain, piece, which, depth, speed):
    """What ends a piece where it falls below zero, of δ and v: the gap, or one of the kinks of the law."""
    if which == GAP:
        return depth if piece != FREE else -depth
    side = 1.0 if piece == MAIN else -1.0
    if m.law == LIMITED:
        opposite = which == SECOND if piece == MAIN else piece == BEYOND
        return side * (m.stiffness * depth + (gain if opposite else -gain) * speed)
    if m.law == CUT:
        return side * (m.stiffness * depth + gain * speed)
    if m.law == COMPRESSION or m.law == JANKOWSKI:
        return side * speed
    if not depth > 0.0:
        return 0.0
    share = full_damping(min(depth / m.penetration, 1.0))
    return side * (m.stiffness * depth**m.exponent + gain * share * speed)


@jit_inlined
def margin(m, gain, piece, which, z):
    """What ends a piece where it falls below zero, of a motion."""
    return margin_of(m, gain, piece, which, -z[3], -z[4])


@jit_inlined
def margin_rate(m, gain, piece, which, z):
    """The derivative of :func:`margin` over time."""
    depth, speed, growth = -z[3], -z[4], -z[5]
    if m.law != IMPACT or which == GAP:
        return margin_of(m, gain, piece, which, speed, growth)  # it is linear
    if not depth > 0.0:
        return 0.0
    share = min(depth / m.penetration, 1.0)
    damper = 6.0 * share * (1.0 - share) / m.penetration * speed * speed + full_damping(share) * growth
    rate = m.stiffness * m.exponent * depth ** (m.exponent - 1.0) * speed + gain * damper
    return rate if piece == MAIN else -rate


@jit_inlined
def formula_of(m, gain, piece):
    """K and c of the force Kδ + cv of a piece in contact of a law that is piecewise linear."""
    if piece == MAIN:
        return m.stiffness, gain
    if m.law == COMPRESSION:
        return m.stiffness, 0.0
    return (2.0 * m.stiffness, 0.0) if m.law == LIMITED and piece == OTHER else (0.0, 0.0)


@jit_inlined
def kinks(m, piece):
    """How many kinks of the law may end a piece."""
    if piece == FREE:
        return 0
    if m.law == LIMITED:
        return 2 if piece == MAIN else 1
    return 1 if m.law == CUT or m.law == COMPRESSION or m.law == JANKOWSKI or m.law == IMPACT else 0


@jit_no_alloc
def piece_at(m, gain, z):
    """The piece of a contact with this motion."""
    for which in range(FIRST, FIRST + kinks(m, MAIN)):
        if margin(m, gain, MAIN, which, z) < 0.0:
            return OTHER if which == FIRST else BEYOND
    return MAIN


@jit_no_alloc
def step_of_law(m, gain, pressed, z, s, k, offset):
    """The motion after a step of length ``s``, as :func:`.contact_location.step_of_stages` with the force of a law."""
    x, v, a, g, u, b = z
    t, e, begun = m.located.stages, m.located.separated, force_of(m, gain, pressed, z)
    v1, a1, u1, b1 = v, a, u, b  # of the stage before
    for i in range(t.count):
        end, d0, d1, e0, e1, beta, f0, f1, gamma, alpha_m, alpha_f = t.numbers[i]
        by_q, by_v, now = s * s * beta, s * gamma, 1.0 - alpha_f
        xk, vk = x + s * (d0 * v + d1 * v1) + s * s * (e0 * a + e1 * a1), v + s * (f0 * a + f1 * a1)
        gk, uk = g + s * (d0 * u + d1 * u1) + s * s * (e0 * b + e1 * b1), u + s * (f0 * b + f1 * b1)
        felt = now * xk + alpha_f * x, now * vk + alpha_f * v, 0.0, now * gk + alpha_f * g, now * uk + alpha_f * u, 0.0
        felt_q, felt_v = now * by_q, 0.0 if t.explicit else now * by_v
        if t.averaged:
            ended, started = forcing_at(m.located, k, offset + s * end), forcing_at(m.located, k, offset)
            forcing = now * ended[0] + alpha_f * started[0], now * ended[1] + alpha_f * started[1]
        else:
            forcing = forcing_at(m.located, k, offset + s * end * now)
        _, _, p, _, _, q = with_accelerations(e, felt, forcing)
        p, q = p - alpha_m * a, q - alpha_m * b
        m11, m12 = 1.0 - alpha_m - e.ax * felt_q - e.av * felt_v, -e.ag * felt_q - e.au * felt_v
        m21, m22 = -e.bx * felt_q - e.bv * felt_v, 1.0 - alpha_m - e.bg * felt_q - e.bu * felt_v
        over = 1.0 / (m11 * m22 - m12 * m21)
        # accelerations without contact force, and what a unit of it adds
        a1, b1 = (m22 * p - m12 * q) * over, (m11 * q - m21 * p) * over
        by_a, by_b = (-m22 * t.react1 - m12 * t.inverse_mass) * over, (m11 * t.inverse_mass + m21 * t.react1) * over
        if pressed:
            if t.averaged:
                known = b1 + by_b * alpha_f * begun
                step_q, step_v = by_q * by_b * now, by_v * by_b * now
                push = solve_force(m, gain, gk + by_q * known, uk + by_v * known, step_q, step_v)
                push = now * push + alpha_f * begun
            else:
                step_q, step_v = felt_q * by_b, felt_v * by_b
                push = solve_force(m, gain, felt[3] + felt_q * b1, felt[4] + felt_v * b1, step_q, step_v)
            a1, b1 = a1 + by_a * push, b1 + by_b * push
        v1, u1 = vk + by_v * a1, uk + by_v * b1
        x1, g1 = xk + by_q * a1, gk + by_q * b1
    return x1, v1, a1, g1, u1, b1


@jit_inlined
def has_ended(piece, value):
    """Whether what ends a piece says so; a gap that is zero is closed."""
    return value < 0.0 or (value == 0.0 and piece == FREE)


@jit_no_alloc
def locate_end(m, gain, piece, which, z, end, length, k, s):
    """Where a piece ends that the step from ``z`` to ``end`` leaves, the motion there, and steps solved to find it.

    Arguments as those of :func:`.contact_location.locate_change`.
    """
    low, high, theta, there, beyond, solves = 0.0, length, length, end, end, 0
    value, begun = margin(m, gain, piece, which, end), margin(m, gain, piece, which, z)
    rates = margin_rate(m, gain, piece, which, z), margin_rate(m, gain, piece, which, end)
    better = root_of_cubic(begun, rates[0], value, rates[1], length)
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
        if not low < better < high or i % 8 == 7:
            better = 0.5 * (low + high)
        there = step_of_law(m, gain, piece != FREE, z, better, k, s)
        before, passed = value, better - theta
        value = margin(m, gain, piece, which, there)
        theta, solves = better, solves + 1
        slope = margin_rate(m, gain, piece, which, there) if i == 0 else (value - before) / passed
        better = theta - value / slope if slope < 0.0 else -length  # outside, where it does not fall
        if has_converged(passed, better - theta, length):
            high, beyond = theta, there
            break
    if which == GAP:  # a law that pulls to the last ends with a jump, beyond which nothing acts
        beyond = beyond[0], beyond[1], beyond[2], 0.0, beyond[4], beyond[5]
    return high, beyond, solves


@jit_inlined
def lowest(value, rate, last, last_rate, length):
    """When a cubic is lowest within a step, from its values and rates at both ends; 0 if it stays positive there."""
    if not length > 0.0 or (value + length / 3.0 * rate > 0.0 and last - length / 3.0 * last_rate > 0.0):
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

    In flight that is the vertex of a parabola, as in :mod:`.contact_location`, in contact the one of a cubic.
    """
    value, last = margin(m, gain, piece, which, z), margin(m, gain, piece, which, end)
    if has_ended(piece, last):
        return length
    if piece == FREE:
        return vertex_within(value, z[4], 0.5 * (z[5] + end[5]), length)
    rates = margin_rate(m, gain, piece, which, z), margin_rate(m, gain, piece, which, end)
    return lowest(value, rates[0], last, rates[1], length)


@jit_inlined
def stays(m, gain, piece, z, end, length):
    """Whether nothing can have ended a piece within a step, as in most steps."""
    staying = True
    for which in range(1 + kinks(m, piece)):
        staying = staying and asked_at(m, gain, piece, which, z, end, length) == 0.0
    return staying


@jit_inlined
def passed_by(m, gain, piece, which, z, end, length, k, s):
    """A time within a step by which one of its causes has ended a piece, or 0; the motion then; steps solved.

    The step that ends at the lowest point decides whether the piece has ended there.
    """
    reach = asked_at(m, gain, piece, which, z, end, length)
    if reach == 0.0 or reach == length:
        return reach, end, 0
    there = step_of_law(m, gain, piece != FREE, z, reach, k, s)
    return (reach if has_ended(piece, margin(m, gain, piece, which, there)) else 0.0), there, 1


@jit_inlined
def following(piece, which):
    """The piece after one that is ended; of a contact that begins, MAIN for any."""
    if which == GAP:
        return MAIN if piece == FREE else FREE
    return MAIN if piece != MAIN else OTHER if which == FIRST else BEYOND


@jit_no_alloc
def locate_change(m, gain, piece, z, end, length, k, s):
    """The end of a piece within a step: the first of all that may end it.

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
        reach, motion, more = passed_by(m, gain, piece, which, z, there, theta, k, s)
        solves, left = solves + more, left - 1
        if reach > 0.0 and which == GAP and rests:
            after = following(piece, which)
        elif reach > 0.0:
            at, motion, more = locate_end(m, gain, piece, which, z, motion, reach, k, s)
            solves += more
            if which != GAP and at <= AT_ONCE * length:
                after = piece_at(m, gain, there) if after == piece else after
            elif cause == NOTHING or at < theta * (1.0 - SAME):
                theta, there, after, cause, left = at, motion, following(piece, which), which, kinks(m, piece)
        which = which + 1 if which < kinks(m, piece) else GAP
    return theta, there, after, solves


@jit_inlined
def advance(m, at, window, buffers):
    """As :func:`.located.advance`; returns a :class:`LawState` and the status."""
    s, piece, g = at.located, at.piece, m.located
    z, i, offset, since, contact = motion_of(s), s.step, s.offset, s.since, s.contact
    solves, before, status, k = s.solves, s.solves_before, OK, s.step % g.steps
    pressed, gain = piece != FREE, gain_of(m, contact)
    _, parts = halvings_at(g, pressed, since)
    length_of_part = g.h / parts
    point = min(parts, points_passed(length_of_part, offset) + 1.0)
    length = point * length_of_part - offset
    end = step_of_law(m, gain, pressed, z, length, k, offset)
    after, more = piece, 0
    if not stays(m, gain, piece, z, end, length):
        length, end, after, more = locate_change(m, gain, piece, z, end, length, k, offset)
    changed = after != piece
    if pressed:
        since += length
        twice = force_of(m, gain, True, z) + force_of(m, gain, True, end)
        contact = with_impulse(contact, contact.impulse + 0.5 * length * twice)
    solves += 1 + more
    offset = offset + length if changed else point * length_of_part
    z = end
    if changed:
        if not pressed:
            since, contact = 0.0, begin_contact(g, i * g.h + offset, z, buffers.contacts.shape[0] > 0)
            gain = gain_of(m, contact)
            after = piece_at(m, gain, z)
        elif after == FREE:
            if buffers.contacts.shape[0] > 0:
                end_contact(g, contact, i * g.h + offset, z, buffers)
            since, contact = 0.0, no_contact()
        z = with_law_accelerations(m, gain, after != FREE, z, forcing_at(g, k, offset))
        if no_room(buffers):
            status = PAUSED
    elif point == parts:
        i, offset, before = i + 1, 0.0, solves
        k = k + 1 if k + 1 < g.steps else 0
        if k == 0 or i >= window[1]:
            write_output(g, i, k, z, force_of(m, gain, pressed, z), window, buffers)
    if not abs(z[3]) < LIMIT:
        status = DIVERGED
    elif solves - before > SOLVES_PER_STEP:
        status = UNRESOLVED
    x, v, a, gap, u, b = z
    s = LocatedState(x, v, a, gap, u, b, after != FREE, i, offset, solves, before, since, contact)
    return LawState(s, after), status


@jit_inlined
def write_first_output(m, s, window, buffers):
    """Write the section row and the sample of the step at which a call begins, if they are asked for."""
    if s.offset == 0.0:
        push = force_of(m, gain_of(m, s.contact), s.pressed, motion_of(s))
        write_output(m.located, s.step, s.step % m.located.steps, motion_of(s), push, window, buffers)


@jit_no_alloc
def integrate_located_law(m, state, stop, most, window, buffers):
    """Integrate to the end of step ``stop`` of the grid, as :func:`.located.integrate_located` does.

    Parameters
    ----------
    m : LawScheme
    state : (STATE.size,) float64
        A :class:`LawState`, changed in place.
    """
    at, status = unpack_state(state), OK
    pause = at.located.solves + most
    write_first_output(m, at.located, window, buffers)
    while at.located.step < stop and status == OK:
        at, status = advance(m, at, window, buffers)
        s = at.located
        if status == OK and s.solves > pause and s.offset == 0.0 and s.step < stop:
            status = PAUSED
    write_state(state, at)
    return status
