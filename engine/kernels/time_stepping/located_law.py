"""Located steps with other contact laws than spring and damper: cut at each change of contact, and at kinks of the law.

The grid, the changes of contact and what is recorded are those of :mod:`.located`. The force within a stage is solved
for (:mod:`.law_step`), and of a stage of any length, too. A step is cut where a piece of a contact ends
(:mod:`.law_pieces`).

A cut keeps the order of an integrator where the force of the law is as smooth as that needs. Near touch the damper of
"jankowski" acts as δ^¼ and that of "constant-restitution" as δ^((n−1)/2), which leave the orders 5/4 and 1 + (n − 1)/2
wherever a step ends.

Plain twin: tests/naive_law_located.py.
"""

from typing import NamedTuple

from ..compile.options import jit_inlined, jit_no_alloc
from ..compile.packing import Layout
from ..compile.record import OpenContact, no_contact, no_room, with_impulse
from ..status import DIVERGED, OK, PAUSED, UNRESOLVED
from .contact_location import forcing_at
from .law_pieces import FREE, locate_change, piece_at, stays
from .law_step import force_of, gain_of, step_of_law, with_law_accelerations
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
from .newmark import LIMIT, next_output


class LawState(NamedTuple):
    """The discrete solution, at a step of the grid or between two."""

    located: LocatedState
    piece: int


STATE = Layout(LawState, located=Layout(LocatedState, contact=Layout(OpenContact)))
unpack_state, write_state = STATE.unpack, STATE.write


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
def glide(m, at, stop, window, sampled):
    """The state after the next whole steps in contact in which nothing ends, as :func:`advance` takes them.

    That takes the step that follows, and those at whose end something is recorded.
    """
    s, g, piece = at.located, m.located, at.piece
    _, parts = halvings_at(g, True, s.since)
    if s.offset != 0.0 or parts > 1.0:
        return at
    left, k, taken = min(next_output(s.step, g.steps, window, sampled), stop) - s.step - 1, s.step % g.steps, 0
    z, since, gain = motion_of(s), s.since, gain_of(m, s.contact)
    push, impulse = force_of(m, gain, True, z), s.contact.impulse
    while taken < left:
        end = step_of_law(m, gain, True, z, g.h, k + taken, 0.0)
        if not (stays(m, gain, piece, z, end, g.h) and abs(end[3]) < LIMIT):
            break
        after = force_of(m, gain, True, end)
        since, impulse = since + g.h, impulse + 0.5 * g.h * (push + after)
        z, push, taken = end, after, taken + 1
    if taken == 0:
        return at
    x, v, a, gap, u, b = z
    contact, solves = with_impulse(s.contact, impulse), s.solves + taken
    s = LocatedState(x, v, a, gap, u, b, True, s.step + taken, 0.0, solves, solves, since, contact)
    return LawState(s, piece)


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
        if at.piece != FREE:
            at = glide(m, at, stop, window, buffers.samples.shape[0] > 0)
        at, status = advance(m, at, window, buffers)
        s = at.located
        if status == OK and s.solves > pause and s.offset == 0.0 and s.step < stop:
            status = PAUSED
    write_state(state, at)
    return status
