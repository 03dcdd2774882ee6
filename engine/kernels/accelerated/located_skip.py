"""Skips of pieces of steps whose changes of contact are located within them, by tables (:mod:`.skip_search`).

The modes are flight, in whole steps, and contact with steps that are halved j = 0, 1, … times (Eq. (13) of
:mod:`..time_stepping.located`); of one mode all pieces from one point of its sub-grid to the next are alike. What is
watched is the gap at the ends of pieces. Within a piece of length s that begins with the gap g (with the sign by which
it is positive while the mode stays) and whose ends have accelerations of mean b, a gap that comes back to its side is
looked for where 2gb ≤ g′² and −g′ < bs (:func:`..time_stepping.contact_location.locate_change`), hence g < bs²/2. With
the supremum of |g″| over all pieces of the table in the place of b, this *dip* is added to every bound. A flight that
has just begun is nearer to the surface than that, and rises: in a step at whose beginning g′ > 0 no dip is looked for.

The tables of a mode are made when a run first needs them: most runs need few.

A flight is the same whatever the contact law is. So it is the one mode of laws whose contact is not linear. The pieces
of a law that is piecewise linear (:mod:`..time_stepping.law_pieces`) are modes, too, each with the force of a spring
and a damper of its own. Watched are then the gap and the kinks that may end the piece, and these wherever a stage takes
the force, too. Within a step of length s an end is looked for where the cubic through the values m and rates m′ at both
ends falls below zero. It does not where its four coefficients in Bernstein's basis, m₀, m₀ + sm₀′/3, m₁ − sm₁′/3 and
m₁, are positive: of a kink m ± sm′/3 is watched at the ends of steps. Of the gap it is m alone. With the slope c of its
chord, the cubic lies below the chord by at most 4s/27 (|m₀′ − c| + |m₁′ − c|), the supremum of which is the dip.

Plain twins: :func:`..time_stepping.located.integrate_located` and
:func:`..time_stepping.located_law.integrate_located_law` (tests/engine/kernels/test_located_skip.py).
"""

from typing import NamedTuple

import numpy as np

from ..compile.options import jit_inlined, jit_no_alloc, jit_spliced
from ..compile.record import unpack_buffers, with_impulse
from ..linear.cos_sin import cos_sin
from ..status import OK, PAUSED
from ..time_stepping import law_pieces, located_law
from ..time_stepping.contact_location import LocatedScheme, contact_force, side, step, unpack_scheme
from ..time_stepping.law_step import gain_of
from ..time_stepping.linear_step import COLUMNS
from ..time_stepping.located import (
    PIECE_ROUNDING,
    LocatedState,
    advance,
    halvings_at,
    motion_of,
    points_passed,
    unpack_state,
    write_output,
    write_state,
)
from ..time_stepping.newmark import next_output
from .skip_search import (
    CHUNK,
    CHUNKS,
    ENTRIES,
    FIRSTS,
    FREE,
    LEAST,
    LEVELS,
    RISING,
    UNLIMITED,
    SkipTables,
    find_skip,
    impulse_of,
    write_u_at,
)

CONTACT = FREE + 1  # modes: FREE; CONTACT + pieces·j + i: in piece i of a contact, with steps halved j times
TABULATED = 30  # halvings: with more, all pieces are solved
MISSING, ASKED = -1, -2  # in the place of a number of watched rows: tables that have not been made, and shall be

# What follows a skip: another one; a piece that is solved for; nothing, since it reaches beyond the end; new tables
SKIP_ON, TAKE_PIECE, BEYOND, WAIT = range(4)


class Pieces(NamedTuple):
    """The next pieces of steps."""

    mode: int
    most: int  # that the mode may last; 0 before a point of its sub-grid
    parts: int  # of a step
    done: int  # of the current step


class LocatedSkips(NamedTuple):
    """What a run with located contact changes skips with."""

    tables: SkipTables
    pieces: int  # of a contact that are skipped, 1 of spring and damper
    rest: float  # ξ₁ at the static equilibrium of the separated bodies
    angles: np.ndarray  # cos ητ and sin ητ at the steps of a period, (2, n)
    us: np.ndarray  # work space, (LEAST + 1, COLUMNS)


def size_of_skips(modes, most, steps):
    """Numbers of a run's :class:`LocatedSkips` in its packed array; ``most``: watched rows."""
    tables = modes * LEVELS * ENTRIES * COLUMNS * (most + COLUMNS + 1) + RISING * CHUNK * COLUMNS
    small = modes * most * (COLUMNS * (FIRSTS + 3) + 1)
    return tables + small + 2 * steps + (LEAST + 1) * COLUMNS + 2


@jit_spliced
def unpack_skips(packed, whole):
    """The :class:`LocatedSkips` as views of packed arrays, since a call from Python takes time for each argument.

    ``packed``: float64, as many as :func:`size_of_skips` says; ``whole``: int64: modes, watched rows, pieces, steps per
    period, then ``counts`` and ``strides`` of the tables.
    """
    modes, most, pieces, steps = whole[0], whole[1], whole[2], whole[3]
    a = modes * most * LEVELS * COLUMNS * ENTRIES
    b = a + modes * LEVELS * ENTRIES * COLUMNS * COLUMNS
    c = b + modes * LEVELS * ENTRIES * COLUMNS
    d = c + RISING * COLUMNS * CHUNK
    e = d + modes * most * FIRSTS * COLUMNS
    f, each = e + modes * most, modes * most * COLUMNS
    g, h, i = f + each, f + 2 * each, f + 3 * each
    j = i + 2 * steps
    k = j + (LEAST + 1) * COLUMNS
    tables = SkipTables(
        packed[:a].reshape((modes, most, LEVELS, CHUNKS, COLUMNS, CHUNK)),
        packed[d:e].reshape((modes, most, FIRSTS, COLUMNS)),
        packed[f:g].reshape((modes, most, COLUMNS)),
        packed[e:f].reshape((modes, most)),
        whole[4 : 4 + modes],
        whole[4 : 4 + modes],  # all rows decide
        whole[4 : 4 + modes],
        whole[4 : 4 + modes],  # not needed
        whole[4 + modes :],
        packed[a:b].reshape((modes, LEVELS, ENTRIES, COLUMNS, COLUMNS)),
        packed[b:c].reshape((modes, LEVELS, ENTRIES, COLUMNS)),
        packed[g:h].reshape((modes, most, COLUMNS)),
        packed[h:i].reshape((modes, most, COLUMNS)),
        packed[c:d].reshape((RISING, COLUMNS, CHUNK)),
        packed[k],
    )
    us = packed[j:k].reshape((LEAST + 1, COLUMNS))
    return LocatedSkips(tables, pieces, packed[k + 1], packed[i:j].reshape((2, steps)), us)


@jit_inlined
def pieces_ahead(m, skips, s, kind):
    """The next pieces; ``kind``: which piece of its law a contact is in."""
    halvings, parts = halvings_at(m, s.pressed, s.since)
    piece = m.h / parts
    done = points_passed(piece, s.offset)
    if done * piece != s.offset or halvings > TABULATED or (s.pressed and skips.pieces == 0):
        return Pieces(FREE, 0, 1, 0)
    lasts = UNLIMITED
    if halvings > 0:
        lasts = int(
            2.0 / (m.step_per_age * (1.0 + PIECE_ROUNDING)) - s.since / piece
        )  # until the longest piece is twice this
    mode = CONTACT + skips.pieces * halvings + kind if s.pressed else FREE
    return Pieces(mode, lasts, int(parts), int(done))


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
def write_piece_matrix(m, pressed, s, rest, out):
    """Write Φ of a piece of length s of Newmark's own step: what it makes of each unit vector u, a column each."""
    (f1, f2, f3), (f4, f5, f6) = m.forcing
    cosine, sine = cos_sin(s * m.frequency)
    last = COLUMNS - 1
    for j in range(COLUMNS):
        u = out[:, j]
        u[:] = 0.0
        u[j] = 1.0
        one, c, d = u[last], cosine * u[last - 2] - sine * u[last - 1], sine * u[last - 2] + cosine * u[last - 1]
        forcing = f1 * c + f2 * d + f3 * one, f4 * c + f5 * d + f6 * one
        z = step(side(m, pressed), motion_at(u, rest * one), s, forcing)
        write_relative(z, contact_force(m, pressed, z), rest * one, c, d, u)
        u[last] = one


@jit_no_alloc
def write_skipped(m, skips, ahead, s, coarse, end, window, buffers):
    """Write the section rows and samples of the steps s.step + 1 … end."""
    us, sampled = skips.us, buffers.samples.shape[0] > 0
    i = next_output(s.step, m.steps, window, sampled)
    while i <= end:
        if i > window[0] or i == window[1]:
            write_u_at(skips.tables, ahead.mode, (i - s.step) * ahead.parts - ahead.done, coarse, us)
            z = motion_at(us[4], skips.rest)
            write_output(m, i, i % m.steps, z, contact_force(m, s.pressed, z), window, buffers)
        i = next_output(i, m.steps, window, sampled)


@jit_inlined
def skip_pieces(m, skips, s, kind, stop, window, buffers):
    """The state after the next skip, if there is one, and what follows: SKIP_ON, TAKE_PIECE, BEYOND or WAIT.

    ``m``: with the spring and the damper of the piece ``kind`` of a law.
    """
    recorded = buffers.contacts.shape[0] > 0
    t, us, rest = skips.tables, skips.us, skips.rest
    ahead, coarse, fine = pieces_ahead(m, skips, s, kind), 0, 0
    mode, parts, done = ahead.mode, ahead.parts, ahead.done
    if ahead.most > 0 and t.counts[mode] < 0:
        t.counts[mode] = ASKED
        return s, WAIT
    if ahead.most > 0 and t.counts[mode] > 0:
        k, z = s.step % m.steps, motion_of(s)
        cosine, sine = skips.angles[0, k], skips.angles[1, k]
        if done > 0:
            cosine, sine = cos_sin((k * m.h + s.offset) * m.frequency)
        write_relative(z, contact_force(m, s.pressed, z), rest, cosine, sine, us[0])
        coarse, fine = find_skip(t, mode, us, 0.0, ahead.most)
    if coarse + fine > 0:
        pieces = coarse * t.strides[mode] + fine
        steps, after = (done + pieces) // parts, (done + pieces) % parts
        reached = s.step + steps
        if recorded:
            write_skipped(m, skips, ahead, s, coarse, min(reached, stop), window, buffers)
        if reached >= stop:
            return s, BEYOND
        contact, since, solves = s.contact, s.since, s.solves + pieces
        if s.pressed:
            since += pieces * (m.h / parts)
            if recorded:
                contact = with_impulse(contact, contact.impulse + impulse_of(t, mode, coarse, fine, us))
        before = solves - after if steps > 0 else s.solves_before
        x, v, a, g, u, b = motion_at(us[2], rest)
        offset = after * (m.h / parts)
        s = LocatedState(x, v, a, g, u, b, s.pressed, reached, offset, solves, before, since, contact)
    return s, TAKE_PIECE if max(coarse, fine) < ENTRIES else SKIP_ON


@jit_no_alloc
def integrate_skipping(packed, tables, whole, forces, state, stop, most, window, flat, sizes):
    """Integrate to the end of step ``stop`` of the grid as :func:`..time_stepping.located.integrate_located` does.

    A skip that reaches beyond is not made, as in :func:`.matrix_skip.integrate_skipping`.

    Parameters
    ----------
    packed, forces, state, stop, most, window, flat, sizes
        As there.
    tables, whole
        A packed :class:`LocatedSkips`.

    Returns
    -------
    int
        As there; PAUSED, too, for want of tables: those of which ``counts`` is ASKED.
    """
    m, skips, buffers = unpack_scheme(packed), unpack_skips(tables, whole), unpack_buffers(flat, sizes)
    s, status = unpack_state(state), OK
    pause = s.solves + most
    if s.offset == 0.0:
        z = motion_of(s)
        write_output(m, s.step, s.step % m.steps, z, contact_force(m, s.pressed, z), window, buffers)
    while s.step < stop and status == OK:
        s, follows = skip_pieces(m, skips, s, 0, stop, window, buffers)
        if follows == BEYOND:
            break
        if follows == WAIT:
            status = PAUSED
        elif follows == TAKE_PIECE:
            s, status = advance(m, forces, s, window, buffers)
        if status == OK and s.solves > pause and s.offset == 0.0 and s.step < stop:
            status = PAUSED
    write_state(state, s)
    return status


@jit_inlined
def scheme_of_piece(m, at):
    """The grid with the spring and the damper of a piece of a law."""
    g = m.located
    stiffness, gain = law_pieces.formula_of(m, gain_of(m, at.located.contact), at.piece)
    return LocatedScheme(
        g.separated,
        g.pressed,
        g.forcing,
        g.clearance,
        g.wall,
        stiffness,
        0.5 * gain,
        g.eta,
        g.frequency,
        g.h,
        g.steps,
        g.shortest_step,
        g.step_per_age,
        g.stages,
    )


@jit_no_alloc
def integrate_law_skipping(m, skips, state, stop, most, window, buffers):
    """The same with any contact law, as :func:`..time_stepping.located_law.integrate_located_law` does.

    Flights are skipped, and the pieces of a law that is piecewise linear; else every piece in contact is solved for.

    Parameters
    ----------
    m : LawScheme
    state : (STATE.size,) float64
        A :class:`..time_stepping.located_law.LawState`, changed in place.
    """
    at, status = located_law.unpack_state(state), OK
    pause = at.located.solves + most
    located_law.write_first_output(m, at.located, window, buffers)
    while at.located.step < stop and status == OK:
        follows = TAKE_PIECE
        if at.piece == law_pieces.FREE or skips.pieces > 0:
            kind = max(at.piece - law_pieces.MAIN, 0)
            s, follows = skip_pieces(scheme_of_piece(m, at), skips, at.located, kind, stop, window, buffers)
            at = located_law.LawState(s, at.piece)
        if follows == BEYOND:
            break
        if follows == WAIT:
            status = PAUSED
        elif follows == TAKE_PIECE:
            if at.piece != law_pieces.FREE and skips.pieces == 0:
                at = located_law.glide(m, at, stop, window, buffers.samples.shape[0] > 0)
            at, status = located_law.advance(m, at, window, buffers)
        s = at.located
        if status == OK and s.solves > pause and s.offset == 0.0 and s.step < stop:
            status = PAUSED
    located_law.write_state(state, at)
    return status
