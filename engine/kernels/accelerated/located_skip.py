"""Skips of whole steps whose changes of contact are located within the step, by the tables of :mod:`.matrix_skip`.

The modes are flight, contact in whole steps, and the beginning of a contact that is resolved by pieces, of which each
step has as many as the one before. What is watched is the gap at the ends of steps. Within a step of length Δτ that
begins with the gap g (with the sign by which it is positive while the mode stays) and whose ends have accelerations of
mean b, a gap that comes back to its side is looked for where 2gb ≤ g′² and −g′ < bΔτ
(:func:`..time_stepping.contact_location.locate_change`), hence g < bΔτ²/2. With the supremum of |g″| over all pieces of
the level in the place of b, this *dip* is added to every bound.

Plain twin: :func:`..time_stepping.located.integrate_located` (tests/engine/kernels/test_located_skip.py).
"""

from ..compile.options import jit_inlined, jit_no_alloc
from ..compile.record import with_impulse
from ..status import OK, PAUSED
from ..time_stepping.contact_location import contact_force
from ..time_stepping.located import (
    LocatedState,
    advance,
    motion_of,
    next_piece,
    unpack_state,
    write_output,
    write_state,
)
from .matrix_skip import ENTRIES, UNLIMITED, find_skip, impulse_of, next_output, write_u_at

FREE, PIECES, WHOLE = range(3)  # modes


@jit_inlined
def mode_of(m, s):
    """The mode from a step of the grid on, −1 if there is none, and the steps that it may last."""
    if not s.pressed:
        return FREE, UNLIMITED
    if next_piece(m, True, s.since, m.h)[0] == 1:
        return WHOLE, UNLIMITED
    left = m.shortest_step - m.step_per_age * s.since  # until pieces grow
    return (PIECES, int(left / (m.step_per_age * m.h))) if left > 0.0 else (-1, 0)


@jit_inlined
def write_relative(z, force, rest, cosine, sine, u):
    """Write u of a motion; ``rest``: ξ₁ at the static equilibrium of the separated bodies."""
    u[0], u[1], u[2], u[3], u[4], u[5] = z[0] - rest, z[3], z[1], z[4], z[2], z[5]
    u[6], u[7], u[8], u[9] = force, cosine, sine, 1.0


@jit_inlined
def motion_at(u, rest):
    """The motion of a u."""
    return u[0] + rest, u[2], u[4], u[1], u[3], u[5]


@jit_no_alloc
def write_skipped(m, t, mode, s, coarse, end, us, rest, window, buffers):
    """Write the section rows and samples of the steps s.step + 1 … end."""
    sampled = buffers.samples.shape[0] > 0
    i = next_output(s.step, m.steps, window, sampled)
    while i <= end:
        if i > window[0] or i == window[1]:
            write_u_at(t, mode, i - s.step, coarse, us)
            write_output(m, i, i % m.steps, motion_at(us[4], rest), s.pressed, window, buffers)
        i = next_output(i, m.steps, window, sampled)


@jit_no_alloc
def integrate_skipping(m, t, pieces, rest, angles, forces, state, us, stop, most, window, buffers):
    """Integrate to the end of step ``stop`` of the grid as :func:`..time_stepping.located.integrate_located` does.

    A skip that reaches beyond is not made, as in :func:`.matrix_skip.integrate_skipping`.

    Parameters
    ----------
    m, forces, state, stop, most, window, buffers
        As there.
    t : SkipTables
    pieces : int
        Of a step at the beginning of a contact.
    rest : float
        ξ₁ at the static equilibrium of the separated bodies.
    angles : (2, n) float64
        cos ητ and sin ητ at the steps of a period.
    us : (5, COLUMNS) float64
        Work space.

    Returns
    -------
    int
        As there.
    """
    s, status, recorded = unpack_state(state), OK, buffers.contacts.shape[0] > 0
    pause = s.solves + most
    if s.offset == 0.0:
        write_output(m, s.step, s.step % m.steps, motion_of(s), s.pressed, window, buffers)
    while s.step < stop and status == OK:
        mode, lasts, coarse, fine = -1, 0, 0, 0
        if s.offset == 0.0:
            mode, lasts = mode_of(m, s)
        if lasts > 0 and t.counts[mode] > 0:
            k = s.step % m.steps
            z = motion_of(s)
            write_relative(z, contact_force(m, s.pressed, z), rest, angles[0, k], angles[1, k], us[0])
            coarse, fine = find_skip(t, mode, us, 0.0, -s.g if s.pressed else s.g, lasts)
        if coarse + fine > 0:
            steps = coarse * t.strides[mode] + fine
            reached = s.step + steps
            if recorded:
                write_skipped(m, t, mode, s, coarse, min(reached, stop), us, rest, window, buffers)
            if reached >= stop:
                break
            contact, solved = s.contact, s.solves + steps * (pieces if mode == PIECES else 1)
            if recorded and s.pressed:
                contact = with_impulse(contact, contact.impulse + impulse_of(t, mode, coarse, fine, us))
            x, v, a, g, u, b = motion_at(us[2], rest)
            since = s.since + steps * m.h if s.pressed else s.since
            s = LocatedState(x, v, a, g, u, b, s.pressed, reached, 0.0, solved, solved, since, contact)
        if max(coarse, fine) < ENTRIES:  # else the table has ended, and not the mode
            s, status = advance(m, forces, s, window, buffers)
        if status == OK and s.solves > pause and s.offset == 0.0 and s.step < stop:
            status = PAUSED
    write_state(state, s)
    return status
