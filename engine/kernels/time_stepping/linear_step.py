"""One-step methods whose step is a matrix for each contact status, one step after the other.

**A stage** maps x = (y, cos ητ₀, sin ητ₀, 1) at the beginning of a step to y and the gap where the contact law takes it
(the matrices: :mod:`engine.drivers.step_maps`). With the status 1 the force of spring and damper acts, with 0 it does
not. The end of a stage *wants* the status 1 if the gap is not positive, with the law that is cut only if the force
pushes too (Eqs. (5) and (6) of :mod:`..equations.contact_law`).

**Status from the start of the step**: 1 if the gap there is not positive; where the law is cut and the force would pull
at the end, 0. **From its end**: a status that its own end wants. The former status is tried first. Neither may agree
with its own end: the step has no solution. Both may: it has two, and keeps the former status. An explicit method knows
the gap before the force; its two statuses have one end, so exactly one agrees.

**Other laws** are solved for within each stage (:mod:`.law_step`). Their maps, one for each stage, are those of a step
without contact; a further row is the rate of the gap, and further columns are what a unit of λ changes, that of the
stage and that of the stage before. Most of these forces begin at zero, so that just one status agrees.

A step without a solution ends the run, or keeps the former status, or is cut into 2, 4, … parts until all of them have
a solution.
"""

import math
from typing import NamedTuple

import numpy as np
from vibroscope.engine.kernels.compile.options import jit_inlined, jit_no_alloc
from vibroscope.engine.kernels.compile.packing import Layout
from vibroscope.engine.kernels.compile.record import OpenContact, no_room, with_impulse
from vibroscope.engine.kernels.equations.contact_law import CUT, gain_at, law_force
from vibroscope.engine.kernels.status import CROSSED, FULL, OK, WITHOUT_SOLUTION
from vibroscope.engine.kernels.time_stepping.law_step import solve_force
from vibroscope.engine.kernels.time_stepping.newmark import (
    LIMIT,
    Scheme,
    begin_contact,
    displaced,
    end_contact,
    ending_of,
    write_output,
    write_sample,
)

STATE_ROWS, FORCE = 7, 6  # y, and where λ stands in it
GAP = STATE_ROWS  # row of the gap
COLUMNS = STATE_ROWS + 3
RATE = GAP + 1  # row of its rate, of other laws
OWN, BEFORE, CLOSING = range(COLUMNS, COLUMNS + 3)  # columns of λ of a stage, of that before; x: closing speed at touch
WORK = CLOSING + 1
HALVINGS = 10
PARTS = 1 << HALVINGS
STOP, KEEP, HALVE = range(3)  # what a step without a solution does
NONE, TWO = -1, 2  # of a step: it has no solution, or two


class LinearScheme(NamedTuple):
    """The matrices of a method and the contact; of ``system`` only what the contact and the coordinates need."""

    # (1 or HALVINGS + 1, 2 or 6, STATE_ROWS + 1, COLUMNS) or (…, 1 or 2, RATE + 1, CLOSING): of steps of Δτ, Δτ/2, …
    maps: np.ndarray
    weights: tuple  # share of the impulse that each of two stages gives; the second is 0 if there is one
    at_end: bool  # whether the status is that of the end
    without: int  # STOP, KEEP or HALVE
    turn: float  # ηΔτ; 0: the load is linear in a step
    system: Scheme


class StepProgress(NamedTuple):
    """What has been done, and what the next step goes on from beside the motion."""

    status: int  # of the last stage
    pressed: bool  # whether the gap is not positive
    step: int  # steps done
    none: int  # steps that had no solution
    two: int  # steps that had two
    contact: OpenContact


class LinearState(NamedTuple):
    """The discrete solution at the end of a step."""

    y: np.ndarray  # (STATE_ROWS,)
    progress: StepProgress


STATE = Layout(LinearState, y=(STATE_ROWS,), progress=Layout(StepProgress, contact=Layout(OpenContact)))
unpack_state = STATE.unpack
write_progress = STATE.writer("progress")  # y is written in place


@jit_inlined
def row(m, level, k, i, x):
    """Row i of matrix k of a level times x."""
    value = 0.0
    for j in range(COLUMNS):
        value += m.maps[level, k, i, j] * x[j]
    return value


@jit_inlined
def write_end(m, level, k, x, end):
    """Write what matrix k of a level makes of x."""
    for i in range(STATE_ROWS + 1):
        end[i] = row(m, level, k, i, x)


@jit_inlined
def wants_contact(m, gap, force):
    """Whether the end of a stage wants the force to act."""
    return gap <= 0.0 and (m.system.law.kind != CUT or force > 0.0)


@jit_inlined
def take_stage(m, level, k, former, x, ends):
    """Write the end of a stage with the status s to ``ends[s]``, with the matrices k + s.

    Returns s, and NONE, 1 or TWO solutions.
    """
    status, solutions = former, 1
    write_end(m, level, k + former, x, ends[former])
    if m.at_end:
        other = 1 - former
        kept = wants_contact(m, ends[former, GAP], ends[former, FORCE]) == (former == 1)
        wanted = wants_contact(m, row(m, level, k + other, GAP, x), row(m, level, k + other, FORCE, x))
        if wanted == (former == 1):
            solutions = 1 if kept else NONE
        elif kept:
            solutions = TWO
        else:
            status = other
            write_end(m, level, k + other, x, ends[other])
    elif former == 1 and m.system.law.kind == CUT and ends[1, FORCE] < 0.0:
        status = 0
        write_end(m, level, k, x, ends[0])
    return status, solutions


@jit_no_alloc
def take_law_stage(m, level, k, former, x, ends):
    """As :func:`take_stage` for another law, with the matrix k of stage k."""
    maps, base, end = m.maps[level, k], ends[0], ends[1]
    for i in range(RATE + 1):
        base[i] = row(m, level, k, i, x) + maps[i, BEFORE] * x[BEFORE]
    base[FORCE] = 0.0
    push = 0.0
    if m.at_end or former == 1:
        gain = gain_at(m.system.law, x[CLOSING])
        push = solve_force(m.system.law, gain, base[GAP], base[RATE], maps[GAP, OWN], maps[RATE, OWN])
    for i in range(RATE + 1):
        end[i] = base[i] + maps[i, OWN] * push
    end[FORCE] = push
    if not m.at_end:
        return former, 1
    kept, wanted = (ends[former, GAP] <= 0.0) == (former == 1), ends[1 - former, GAP] <= 0.0
    if wanted == (former == 1):
        return former, 1 if kept else NONE
    return (former, TWO) if kept else (1 - former, 1)


@jit_inlined
def closing_speed(m, y, pressed, contact):
    """−g′ at touch: that of the open contact, or the one with which the coming step may begin a contact."""
    return m.system.sign * (contact.speed1 - contact.speed2) if pressed else y[2] - y[3]


@jit_inlined
def motion_of(m, y):
    """ξ₁, ξ₁′, ξ₂, ξ₂′ of a state y."""
    return displaced(m.system, y[0], y[2], y[1], y[3])


@jit_inlined
def force_at(m, y, pressed, contact):
    """λ of a state y, as the step that now begins will feel it."""
    if not pressed:
        return 0.0
    s, gain = m.system, gain_at(m.system.law, closing_speed(m, y, pressed, contact))
    depth, speed = s.touch - (y[1] - y[0]), y[2] - y[3]
    return s.sign * law_force(s.law, gain, depth, speed)


@jit_no_alloc
def take_step(m, level, former, x, ends):
    """Write the end of a step of this ``level`` with the status s, of its last stage, to ``ends[s]``.

    Returns
    -------
    tuple
        s; NONE, 1 or TWO solutions; mean contact force over the step.
    """
    law = m.system.law.kind > CUT
    if law:
        x[BEFORE] = 0.0
        status, solutions = take_law_stage(m, level, 0, former, x, ends)
    else:
        status, solutions = take_stage(m, level, 0, former, x, ends)
    push = m.weights[0] * ends[status, FORCE] * status
    if m.maps.shape[1] > (1 if law else 2):
        first = status
        former = first if m.at_end else int(ends[status, GAP] <= 0.0)
        if law:
            x[BEFORE] = ends[first, FORCE] * first
            status, more = take_law_stage(m, level, 1, former, x, ends)
        else:
            status, more = take_stage(m, level, 2 + 2 * first, former, x, ends)
        solutions = min(solutions, more) if NONE in (solutions, more) else max(solutions, more)
        push += m.weights[1] * ends[status, FORCE] * status
    ends[status, FORCE] *= status
    return status, solutions, push


@jit_inlined
def is_pressed(m, y):
    """Whether the gap is not positive."""
    return y[1] - y[0] <= m.system.touch


@jit_inlined
def begin_step(x, y, cosine, sine):
    """Write x at the beginning of a step from the state y."""
    for k in range(STATE_ROWS):
        x[k] = y[k]
    x[STATE_ROWS], x[STATE_ROWS + 1], x[STATE_ROWS + 2] = cosine, sine, 1.0


@jit_no_alloc
def take_parts(m, status, angle, x, ends):
    """Take a step cut into the fewest parts, 2, 4, … PARTS, each half of the one before, that have a solution.

    ``angle``: ητ at its beginning. A part without a solution is halved, and so are all that follow. Returns what
    :func:`take_step` does, of the whole; x is no longer that of the beginning.
    """
    level, done, impulse, solutions, load, slope = 1, 0, 0.0, 1, x[STATE_ROWS], x[STATE_ROWS + 1]
    while done < PARTS:
        former = status if m.at_end else int(is_pressed(m, x))
        after, solutions, push = take_step(m, level, former, x, ends)
        if solutions != NONE:
            part = PARTS >> level
            done, status, impulse = done + part, after, impulse + push * part / PARTS
            if m.turn == 0.0:
                begin_step(x, ends[status], load + slope * m.system.h * done / PARTS, slope)
            else:
                now = angle + done * m.turn / PARTS
                begin_step(x, ends[status], math.cos(now), math.sin(now))
        elif level < HALVINGS:
            level += 1
        else:
            break
    return status, solutions, impulse


@jit_inlined
def advance(m, angles, y, at, work, window, buffers):
    """Take one step and record it; y is changed in place unless the step ends the run.

    Returns
    -------
    tuple
        :class:`StepProgress`; OK, DIVERGED, FULL, or WITHOUT_SOLUTION: then y is that before the step that has none.
        CROSSED: the next step is to be seen from the other stop; if this one is all in flight it is taken again.
    """
    n, recorded, x, ends = angles.shape[1], buffers.contacts.shape[0] > 0, work[0], work[1:]
    k, code = at.step % n, OK
    begin_step(x, y, angles[0, k], angles[1, k])
    former = at.status if m.at_end else int(at.pressed)
    if m.system.law.kind > CUT:
        x[CLOSING] = closing_speed(m, y, at.pressed, at.contact)
    after, solutions, push = take_step(m, 0, former, x, ends)
    none, two = at.none + (solutions == NONE), at.two + (solutions == TWO)
    if solutions == NONE and m.without == HALVE:
        after, solutions, push = take_parts(m, former, k * m.turn, x, ends)
    if solutions == NONE and m.without != KEEP:
        return StepProgress(at.status, at.pressed, at.step, none, two, at.contact), WITHOUT_SOLUTION
    before, v1, v2 = y[1] - y[0], y[2], y[3]
    for j in range(STATE_ROWS):
        y[j] = ends[after, j]
    i, k = at.step + 1, (k + 1 if k + 1 < n else 0)
    impulse, gap, pressed = m.system.h * push, y[1] - y[0], is_pressed(m, y)
    contact = with_impulse(at.contact, at.contact.impulse + impulse)
    if pressed != at.pressed:
        now = motion_of(m, y)
        if pressed:
            if push != 0.0:  # the force has acted in this step already: the speeds are those before it
                _, v1, _, v2 = displaced(m.system, 0.0, v1, 0.0, v2)
                now = now[0], v1, now[2], v2
            closing = (before - gap) / m.system.h if recorded else 0.0
            contact = with_impulse(begin_contact(m.system, i, now, closing), impulse)
        elif recorded:
            end_contact(m.system, contact, i, now, y[FORCE], buffers)
            code = FULL if no_room(buffers) else OK
    if recorded and (k == 0 or (i >= window[1] and k % window[2] == 0)):
        write_output(i, k, n, motion_of(m, y), force_at(m, y, pressed, contact), window, buffers)
    if not -LIMIT < gap < m.system.reach:
        code = ending_of(gap)
        if code == CROSSED and push == 0.0 and m.without != HALVE and not is_pressed(m, x):
            i -= 1  # the step is taken again from the other stop, which it may have met
            for j in range(STATE_ROWS):
                y[j] = x[j]
    return StepProgress(after, pressed, i, none, two, contact), code


@jit_inlined
def write_first_sample(m, y, at, window, buffers):
    """Write the sample at the step with which sampling begins, if the run stands there."""
    if at.step == window[1] and buffers.samples.shape[0] > 0:
        write_sample(buffers.samples[0], motion_of(m, y), force_at(m, y, at.pressed, at.contact))


@jit_no_alloc
def integrate_linear(m, angles, state, work, stop, window, buffers):
    """Integrate to the end of step ``stop``, and fill the buffers if they have room for contacts.

    Parameters
    ----------
    m : LinearScheme
    angles : (2, n) float64
        cos ητ and sin ητ at the beginning of each step of a period.
    state : (STATE.size,) float64
        A :class:`LinearState`, changed in place.
    work : (3 or more, WORK) float64
        Work space.
    stop : int
    window : (3,) int64
        As in :func:`.newmark.integrate`.
    buffers : Buffers

    Returns
    -------
    int
        What :func:`advance` returns.
    """
    s, code = unpack_state(state), OK
    y, at = s.y, s.progress
    write_first_sample(m, y, at, window, buffers)
    while at.step < stop and code == OK:
        at, code = advance(m, angles, y, at, work, window, buffers)
    write_progress(state, at)
    return code
