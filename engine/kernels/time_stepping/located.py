"""One-step methods with their step cut at each contact change, located within the step (:mod:`.contact_location`).

At the change displacement and velocity continue, the acceleration starts anew from the equations of the other side, and
what is left of the step follows. So the grid stays as it is, whatever happens between its steps. A step is also cut
where a piece of a contact ends (:mod:`.law_pieces`): at a kink of the law.

A cut keeps the order of an integrator where the force of the law is as smooth as that needs. Near touch the damper of
"jankowski" acts as δ^¼ and that of "constant-restitution" as δ^((n−1)/2), which leave the orders 5/4 and 1 + (n − 1)/2
wherever a step ends.

**Resolution of a contact** by Newmark's method. Locating the changes is not enough if a contact then lasts two steps:
average acceleration gives its restitution only where it resolves the contact mode, of fastest rate |s| (Eq. (7) of
:mod:`..equations.contact_law`). On the grid the fastest of what moves without contact has T_f/Δτ steps to the cycle,
T_f = 2π/max(1, κ, η) where no damper is stronger. A contact begins with as many to its own cycle T_c = 2π/|s|. A
contact longer than half a cycle is not an impact; what the beginning of contact excited decays, and the longest step
grows with the time t since then, so that every time scale has the same number of steps:

    s ≤ Δτ · min(1, max(T_c, 2t) / T_f)                                                                     (13)

A step of the grid is therefore halved j times, until its pieces keep to (13) when they begin. A piece ends at the next
point of this sub-grid: a contact that begins within a step begins with a shorter piece, and so does a coarser sub-grid
of which the last piece did not end at a point.

Every step is then proportional to Δτ, and the method is of second order throughout. With N = T_f/Δτ an impact costs N/2
to N solves and some four to locate each change, a contact of duration t > T_c/2 costs up to twice
N/2 (1 + ln(2t/T_c)), however stiff it is. (In an FE code a step of another length costs another factorisation too.)

Plain twin: tests/naive_law_located.py.
"""

import math
from typing import NamedTuple

import numpy as np
from vibroscope.engine.kernels.compile.options import jit, jit_inlined, jit_no_alloc
from vibroscope.engine.kernels.compile.packing import Layout
from vibroscope.engine.kernels.compile.record import (
    OpenContact,
    no_contact,
    no_room,
    record_contact,
    unpack_buffers,
    with_impulse,
)
from vibroscope.engine.kernels.equations.contact_law import contact_law_of, contact_rate
from vibroscope.engine.kernels.equations.motion import (
    coefficients,
    contact_coordinates,
    displacements,
    free_rate,
    pressed_generator,
)
from vibroscope.engine.kernels.status import CROSSED, DIVERGED, OK, PAUSED, UNRESOLVED
from vibroscope.engine.kernels.time_stepping.contact_location import (
    LocatedScheme,
    begin_load_of_step,
    force_of,
    forcing_at,
    side,
    step,
    step_of_stages,
    unpack_scheme,
    with_contact_accelerations,
)
from vibroscope.engine.kernels.time_stepping.law_pieces import FREE, locate_change, piece_at, stays
from vibroscope.engine.kernels.time_stepping.law_step import gain_of
from vibroscope.engine.kernels.time_stepping.newmark import FAR_FROM_STOP, LIMIT, next_output, write_output
from vibroscope.engine.kernels.time_stepping.stage import forcing_with, side_of, with_accelerations, without_contact

MOST_HALVINGS = 60  # of a step of the grid
# Of a piece, and of its longest length: a contact from a step of the grid on has whole ratios, which rounding must not
# decide; where pieces are as short as the rounding of their instants, they grow.
PIECE_ROUNDING = 1e-6
OFFSET_ROUNDING = 1e-15  # relative, of the same
SOLVES_PER_STEP = 10_000_000  # some tenths of a second within one step: contacts too short for this excitation period


class LocatedState(NamedTuple):
    """The discrete solution, at a step of the grid or between two."""

    x: float  # ξ₁ with velocity and acceleration
    v: float
    a: float
    g: float  # the gap likewise
    u: float
    b: float
    piece: int  # of the law, FREE in flight
    step: int  # steps of the grid done
    offset: float  # time since the last of them
    solves: int  # steps solved since the start of the run
    solves_before: int  # … when the last step of the grid ended
    since: float  # time since the open contact began
    contact: OpenContact


STATE = Layout(LocatedState, contact=Layout(OpenContact))
unpack_state, write_state = STATE.unpack, STATE.write


@jit
def located_scheme(p, stages, resolves):
    """Both sides and the time grid, from :class:`..parameters.Parameters`.

    ``stages``: of the method, :class:`.stage.Stages`; ``resolves``: whether contacts are resolved by shorter
    steps, Eq. (13).
    """
    h, fastest = 2 * math.pi / p.eta / p.steps, free_rate(p)
    rate = contact_rate(p.stiffness, p.damping, coefficients(p).inverse_mass)
    separated, forcing = without_contact(p)
    return LocatedScheme(
        separated,
        side_of(pressed_generator(p)),
        forcing,
        p.clearance,
        p.wall,
        contact_law_of(p),
        p.eta,
        p.eta / (2.0 * math.pi),
        h,
        int(p.steps),
        h * fastest / rate if resolves else h,
        h * fastest / math.pi,
        np.array([1.0 if p.pulse >= 0.0 else 0.0, 0.0, 0.0, 0.0, 0.0]),
        p.sign,
        min(FAR_FROM_STOP * p.play, LIMIT),
        stages,
    )


@jit
def start_state(m, start, kept, at_rest):
    """The discrete solution at τ = 0.

    ``start``: ξ₁, ξ₁′, ξ₂, ξ₂′; ``kept``: whether the first period is recorded; ``at_rest``: without acceleration.
    """
    x, v, g, u = contact_coordinates(m, start[0], start[1], start[2], start[3])
    forcing = forcing_with(m.forcing, 1.0, 0.0)
    z = with_accelerations(m.separated, (x, v, 0.0, g, u, 0.0), forcing)
    a, b = z[2], z[5]
    # at zero gap the first derivative of the free motion that is not zero decides
    jerk = with_accelerations(m.separated, (v, a, 0.0, u, b, 0.0), (0.0, m.eta * m.forcing[1][1]))[5]
    deciding = g if g != 0.0 else u if u != 0.0 else b if b != 0.0 else jerk
    pressed = deciding < 0.0 or deciding == 0.0
    contact = begin_contact(m, 0.0, z, kept and pressed and g == 0.0)
    if g != 0.0:  # a contact that was open before: of its beginning nothing is known
        contact = OpenContact(0.0, 0.0, contact.position, contact.speed1, contact.speed1, 0.0)
    gain = gain_of(m, contact)
    piece = piece_at(m, gain, z) if pressed else FREE
    z = with_contact_accelerations(m, gain, pressed, z, forcing)
    a, b = (0.0, 0.0) if at_rest else (z[2], z[5])
    return LocatedState(x, v, a, g, u, b, piece, 0, 0.0, 0, 0, 0.0, contact)


@jit_inlined
def begin_contact(m, now, z, kept):
    """The contact that begins at τ = ``now``; its impact is recorded only in the kept periods."""
    x1, v1, _, v2 = displacements(m, z[0], z[1], z[3], z[4])
    return OpenContact(now, -z[4] if kept else 0.0, x1, v1, v2, 0.0)


@jit_inlined
def end_contact(m, contact, now, z, buffers):
    """Record the contact that ends at τ = ``now``, and its impact if it began with a closing speed."""
    _, v1, _, v2 = displacements(m, z[0], z[1], z[3], z[4])
    record_contact(buffers, with_impulse(contact, m.sign * contact.impulse), now, (v1, v2), True)


@jit_inlined
def motion_of(s):
    """The motion of a state."""
    return s.x, s.v, s.a, s.g, s.u, s.b


@jit_inlined
def write_motion(m, i, k, z, push, window, buffers):
    """Write the section row and the sample of step i, the k-th of its period, if they are asked for."""
    write_output(i, k, m.steps, displacements(m, z[0], z[1], z[3], z[4]), m.sign * push, window, buffers)


@jit_inlined
def longest_piece(m, since):
    """The longest piece that Eq. (13) allows."""
    return max(m.shortest_step, m.step_per_age * since) * (1.0 + PIECE_ROUNDING)


@jit_inlined
def halvings_at(m, pressed, since):
    """How often a step is halved until its pieces keep to Eq. (13), and into how many pieces that cuts it."""
    halvings, parts = 0, 1.0
    if pressed:
        longest = longest_piece(m, since)
        while parts * longest < m.h and halvings < MOST_HALVINGS:
            halvings, parts = halvings + 1, 2.0 * parts
    return halvings, parts


@jit_inlined
def points_passed(piece, offset):
    """Points of a sub-grid from a step of the grid to the time ``offset`` after it."""
    return math.floor(offset / piece * (1.0 + OFFSET_ROUNDING) + PIECE_ROUNDING)


@jit_inlined
def step_of_grid(m, forces, gain, pressed, z, length, at, ends):
    """As :func:`.contact_location.step_from`; ``ends``: whether the step ends at the next step of the grid."""
    if m.stages.count > 0:
        return step_of_stages(m, gain, pressed, z, length, at)
    k, offset = at
    forcing = (forces[k + 1, 0], forces[k + 1, 1]) if ends else forcing_at(m, (k, offset + length))
    return step(side(m, pressed), z, length, forcing)


@jit_inlined
def next_part(m, pressed, since, offset):
    """Into how many parts the step is cut, their length, and the next point of this sub-grid, at which a part ends."""
    _, parts = halvings_at(m, pressed, since)
    if parts == 1.0 and offset == 0.0:
        return 1.0, m.h, 1.0
    length_of_part = m.h / parts
    return parts, length_of_part, min(parts, points_passed(length_of_part, offset) + 1.0)


@jit_inlined
def advance(m, forces, s, stop, window, buffers):
    """Solve steps and their parts, the last of which is a step that is recorded or ends with a change; record it.

    Returns
    -------
    tuple
        :class:`LocatedState`; OK, PAUSED for want of room, DIVERGED or UNRESOLVED; CROSSED before a step that is to be
        seen from the other stop.
    """
    z, piece, i, offset, since, contact = motion_of(s), s.piece, s.step, s.offset, s.since, s.contact
    solves, before, status, k = s.solves, s.solves_before, OK, s.step % m.steps
    pressed, gain, impulse = piece != FREE, gain_of(m, contact), contact.impulse
    last = min(next_output(i, m.steps, window, buffers.samples.shape[0] > 0), stop) - 1  # step without a record
    push = force_of(m, gain, pressed, z)
    while True:
        begin_load_of_step(m, forces, k)
        parts, length_of_part, point = next_part(m, pressed, since, offset)
        length, ends = point * length_of_part - offset, point == parts
        end = step_of_grid(m, forces, gain, pressed, z, length, (k, offset), ends)
        staying = stays(m, gain, piece, z, end, length)
        goes_on = staying and -LIMIT < end[3] < m.reach and solves - before < SOLVES_PER_STEP
        if not goes_on or (ends and i >= last):
            break
        if pressed:
            after = force_of(m, gain, True, end)
            since, impulse, push = since + length, impulse + 0.5 * length * (push + after), after
        z, solves, offset = end, solves + 1, point * length_of_part
        if ends:
            i, k, offset, before = i + 1, k + 1, 0.0, solves
    following, more = piece, 0
    crosses = staying and m.reach < end[3] < LIMIT
    if crosses:
        end, length, ends = z, 0.0, False
    if not staying:
        length, end, following, more = locate_change(m, gain, piece, z, end, length, (k, offset))
    changed = following != piece
    if pressed:
        since += length
        contact = with_impulse(contact, impulse + 0.5 * length * (push + force_of(m, gain, True, end)))
    solves += 1 + more
    offset = offset + length if changed or crosses else point * length_of_part
    z = end
    if changed:
        if not pressed:
            since, contact = 0.0, begin_contact(m, i * m.h + offset, z, buffers.contacts.shape[0] > 0)
            gain = gain_of(m, contact)
            following = piece_at(m, gain, z)
        elif following == FREE:
            if buffers.contacts.shape[0] > 0:
                end_contact(m, contact, i * m.h + offset, z, buffers)
            since, contact = 0.0, no_contact()
        z = with_contact_accelerations(m, gain, following != FREE, z, forcing_at(m, (k, offset)))
        if no_room(buffers):
            status = PAUSED
    elif ends:
        i, offset, before = i + 1, 0.0, solves
        k = k + 1 if k + 1 < m.steps else 0
        if k == 0 or i >= window[1]:
            write_motion(m, i, k, z, force_of(m, gain, pressed, z), window, buffers)
    if not abs(z[3]) < LIMIT:
        status = DIVERGED
    elif solves - before > SOLVES_PER_STEP:
        status = UNRESOLVED
    elif crosses:
        status = CROSSED
    x, v, a, g, u, b = z
    return LocatedState(x, v, a, g, u, b, following, i, offset, solves, before, since, contact), status


@jit_no_alloc
def integrate_located(packed, forces, state, stop, most, window, flat, sizes):
    """Integrate to the end of step ``stop`` of the grid.

    Parameters
    ----------
    packed : (SCHEME.size,) float64
        A :class:`.contact_location.LocatedScheme`.
    forces : (n + 1, 2) float64
        f₁ and f at the steps of one period.
    state : (STATE.size,) float64
        A :class:`LocatedState`, changed in place.
    stop : int
    most : int
        Solves after which to pause, so that a run can be withdrawn.
    window : (3,) int64
        The step at which the kept periods begin, the step at which sampling begins, and the steps from sample to
        sample, counted anew in each period.
    flat, sizes
        Packed record buffers, without rows for sections and contacts outside the kept periods.

    Returns
    -------
    int
        OK; CROSSED; PAUSED (call again), after ``most`` solves or for want of room; DIVERGED; UNRESOLVED if a step
        took more than SOLVES_PER_STEP solves.
    """
    m, buffers, s, status = unpack_scheme(packed), unpack_buffers(flat, sizes), unpack_state(state), OK
    pause = s.solves + most
    if s.offset == 0.0:
        push = force_of(m, gain_of(m, s.contact), s.piece != FREE, motion_of(s))
        write_motion(m, s.step, s.step % m.steps, motion_of(s), push, window, buffers)
    while s.step < stop and status == OK:
        s, status = advance(m, forces, s, stop, window, buffers)
        if status == OK and s.solves > pause and s.offset == 0.0 and s.step < stop:
            status = PAUSED
    write_state(state, s)
    return status
