"""Located steps with other contact laws than spring and damper: cut at each change of contact, and at kinks of the law.

The grid, the changes of contact and what is recorded are those of :mod:`.located`. The force within a stage is solved
for (:mod:`.law_step`), and of a stage of any length, too. A contact has *pieces*, between which its force is continuous
and its derivative is not; a step is cut where one of these falls below zero:

    "cut"              Kδ + cv                        in the piece that pushes, the reverse in the one without force
    "limited"          Kδ − cv and Kδ + cv            in the middle piece, the reverse in each of the others
    "compression", "jankowski"    v                   while the bodies close, the reverse while they part
    "impact"           Kδⁿ + cS(δ/d)v                 as with "cut"

So the force may end before the gap opens: that ends a piece, and the gap ends the contact. Of a piece only its end is
looked for: one that begins and ends within a step of the grid is not seen. Its force acts all the same, since every
stage takes the force of the whole law.

A cut keeps the order of an integrator where the force of the law is as smooth as that needs. Near touch the damper of
"jankowski" acts as δ^¼ and that of "constant-restitution" as δ^((n−1)/2), which leave the orders 5/4 and 1 + (n − 1)/2
wherever a step ends.

Plain twin: tests/naive_law_located.py.
"""

from typing import NamedTuple

from ..compile.options import jit_inlined, jit_no_alloc
from ..compile.packing import Layout
from ..compile.record import OpenContact, no_contact, no_room, with_impulse
from ..equations.contact_law import COMPRESSION, CUT, IMPACT, JANKOWSKI, LIMITED, gain_at, law_force
from ..status import DIVERGED, OK, PAUSED, UNRESOLVED
from .contact_location import ITERATIONS, PRECISION, LocatedScheme, forcing_at, with_accelerations
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


@jit_no_alloc
def margin(m, gain, piece, which, z):
    """What ends a piece where it falls below zero: the gap, or one of the kinks of the law."""
    depth, speed = -z[3], -z[4]
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
    share = min(depth / m.penetration, 1.0)
    return side * (m.stiffness * depth**m.exponent + gain * share * share * (3.0 - 2.0 * share) * speed)


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
def with_closed_gap(which, theta, z, solves):
    """What is found: at the end of a piece by the gap, that is zero."""
    return theta, (z[0], z[1], z[2], 0.0 if which == GAP else z[3], z[4], z[5]), solves


@jit_no_alloc
def locate_end(m, gain, piece, which, z, end, length, k, s):
    """Where a piece ends that the step from ``z`` to ``end`` leaves, the motion there, and steps solved to find it.

    Arguments as those of :func:`.contact_location.locate_change`.
    """
    low, high, theta, there, beyond, solves = 0.0, length, length, end, end, 0
    before, passed = margin(m, gain, piece, which, z), -length
    for i in range(ITERATIONS):
        value = margin(m, gain, piece, which, there)
        if value > 0.0 or (value == 0.0 and piece != FREE):
            low = theta
        else:
            high, beyond = theta, there
        change = before - value
        better = theta - value * passed / change if change != 0.0 else low
        if high - low <= PRECISION * length:
            break
        if abs(better - theta) <= PRECISION * length:
            return with_closed_gap(which, theta, there, solves)
        if not low < better < high or i % 8 == 7:
            better = 0.5 * (low + high)
        before, passed = value, theta - better
        there = step_of_law(m, gain, piece != FREE, z, better, k, s)
        theta, solves = better, solves + 1
    # a law that pulls to the last ends with a jump, beyond which nothing acts
    return with_closed_gap(which, high, beyond, solves)


@jit_no_alloc
def locate_change(m, gain, piece, z, end, length, k, s):
    """The end of a piece within a step.

    Returns
    -------
    tuple
        When it ends, or ``length``; the motion there; the next piece, MAIN for any of a contact that begins, or the
        same; steps solved to find it.
    """
    pressed, solves, theta, there, after = piece != FREE, 0, length, end, piece
    sign = -1.0 if pressed else 1.0
    gap, rate = sign * z[3], sign * z[4]
    opened = MAIN if piece == FREE else FREE
    if (end[3] <= 0.0) != pressed:
        after = opened
        if gap > 0.0 or rate > 0.0:  # else it begins on the surface, and does not move away from it
            theta, there, solves = locate_end(m, gain, piece, GAP, z, end, length, k, s)
    else:
        curvature = 0.5 * sign * (z[5] + end[5])
        approaches = gap > 0.0 and rate < 0.0 and -rate < curvature * length
        if approaches and 2.0 * gap * curvature <= rate * rate:
            reach, solves = -rate / curvature, 1
            vertex = step_of_law(m, gain, pressed, z, reach, k, s)
            if (vertex[3] <= 0.0) != pressed:
                after = opened
                theta, there, more = locate_end(m, gain, piece, GAP, z, vertex, reach, k, s)
                solves += more
    for which in range(FIRST, FIRST + kinks(m, piece)):
        if margin(m, gain, piece, which, there) < 0.0:
            at, motion, more = locate_end(m, gain, piece, which, z, there, theta, k, s)
            solves += more
            if at > AT_ONCE * length:
                theta, there = at, motion
                after = MAIN if piece != MAIN else OTHER if which == FIRST else BEYOND
            elif after == piece:
                after = piece_at(m, gain, there)
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
