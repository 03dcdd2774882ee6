"""One-step methods whose step is a matrix, one step after the other.

**A stage** maps x = (u, cos ητ₀, sin ητ₀, 1), with u = (ξ₁, g, ξ₁′, g′, ξ₁″, g″, λ) at the beginning of a step, to u at
its end without a contact force, and to the gap and its rate where the contact law takes them. Two more columns are what
a unit of λ changes, that of the stage and that of the stage before (:mod:`engine.drivers.step_maps`). With the status 1
the force of the law acts, which is solved for (:mod:`.law_step`), with 0 it does not. The end of a stage *wants* the
status 1 if the gap is not positive, with the law that is cut only if the force pushes too (Eqs. (5) and (6) of
:mod:`..equations.contact_law`).

**Status from the start of the step**: 1 if the gap there is not positive; where the law is cut and the force would pull
at the end, 0. **From its end**: a status that its own end wants. The former status is tried first. Neither may agree
with its own end: the step has no solution. Both may: it has two, and keeps the former status. An explicit method knows
the gap before the force; its two statuses have one end, so exactly one agrees. Most forces of other laws begin at zero,
so that just one status agrees, too.

A step without a solution ends the run, or keeps the former status, or is cut into 2, 4, … parts until all of them have
a solution.
"""

import math
from typing import NamedTuple

import numpy as np
from vibroscope.engine.kernels.compile.options import jit, jit_inlined, jit_no_alloc
from vibroscope.engine.kernels.compile.packing import Layout
from vibroscope.engine.kernels.compile.record import OpenContact, no_room, with_impulse
from vibroscope.engine.kernels.equations.contact_law import CUT, force_of_law, gain_at, law_force
from vibroscope.engine.kernels.equations.motion import displacements
from vibroscope.engine.kernels.status import CROSSED, FULL, OK, WITHOUT_SOLUTION
from vibroscope.engine.kernels.time_stepping.law_step import linear_root, solve_force
from vibroscope.engine.kernels.time_stepping.newmark import (
    LIMIT,
    Scheme,
    begin_contact,
    end_contact,
    ending_of,
    write_output,
    write_sample,
)
from vibroscope.engine.kernels.time_stepping.stage import ALPHA_F, between, end_with_force, forcing_with, unforced_end

STATE_ROWS, FORCE = 7, 6  # u, and where λ stands in it
COLUMNS = STATE_ROWS + 3
BEFORE, OWN, GAIN = range(COLUMNS, COLUMNS + 3)  # columns of λ of the stage before, of the own; x: c, or h of Eq. (18)
GAP, RATE = STATE_ROWS, STATE_ROWS + 1  # rows of gap and rate where the law takes them
ROWS = RATE + 1
WORK = GAIN + 1
HALVINGS = 10
PARTS = 1 << HALVINGS
STOP, KEEP, HALVE = range(3)  # what a step without a solution does
NONE, TWO = -1, 2  # of a step: it has no solution, or two


class LinearScheme(NamedTuple):
    """The matrices of a method and the contact; of ``system`` only what the contact and the coordinates need."""

    maps: np.ndarray  # (1 or HALVINGS + 1, 1 or 2, GAIN, ROWS) columns of each stage, of steps of Δτ, Δτ/2, …
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

    u: np.ndarray  # (STATE_ROWS,)
    progress: StepProgress


STATE = Layout(LinearState, u=(STATE_ROWS,), progress=Layout(StepProgress, contact=Layout(OpenContact)))
unpack_state = STATE.unpack
write_progress = STATE.writer("progress")  # u is written in place


@jit
def fill_maps(maps, side, forcing, stages, load_rate, h):
    """Write the columns of all stages of a step of length h: what these make of unit vectors.

    Parameters
    ----------
    maps : (1 or 2, GAIN, ROWS) float64
        Of one of the levels of :class:`LinearScheme`.
    side, forcing
        The motion without contact (:func:`.stage.without_contact`).
    stages : Stages
    load_rate : float
        Frequency of the load; 0: it is linear in a step, and x holds its value and its slope.
    h : float
    """
    two, x = stages.count > 1, np.zeros(GAIN)
    for j in range(GAIN):
        x[j] = 1.0
        start, load = ((x[0], x[2], x[4], x[1], x[3], x[5]), x[FORCE]), (x[FORCE + 1], x[FORCE + 2], x[FORCE + 3])
        force, numbers = x[BEFORE] if two else x[OWN], stages.numbers[0]
        felt = forcing_of_stage(forcing, stages.averaged, numbers, load, load_rate, h)
        k = unforced_end(side, stages.averaged, stages.reaction, numbers, start, None, h, felt)
        first = end_with_force(k, force)
        write_column(maps[0, BEFORE + OWN - j if two and j >= BEFORE else j], first, k, force)
        if two:
            force, numbers = x[OWN], stages.numbers[1]
            felt = forcing_of_stage(forcing, stages.averaged, numbers, load, load_rate, h)
            k = unforced_end(side, stages.averaged, stages.reaction, numbers, start, first, h, felt)
            write_column(maps[1, j], end_with_force(k, force), k, force)
        x[j] = 0.0


@jit_inlined
def forcing_of_stage(forcing, averaged, numbers, load, load_rate, h):
    """f₁ and f as a stage takes them; ``load``: that at the beginning of the step, as x holds it, and 1."""
    (cosine, sine, one), end, alpha_f = load, numbers[0], numbers[ALPHA_F]
    (a1, b1, c1), (a2, b2, c2) = forcing
    forcing = (a1, b1, c1 * one), (a2, b2, c2 * one)
    at = h * (end if averaged else end * (1.0 - alpha_f))
    if load_rate == 0.0:
        ended = forcing_with(forcing, cosine + at * sine, sine)
    else:
        c, s = math.cos(load_rate * at), math.sin(load_rate * at)
        ended = forcing_with(forcing, c * cosine - s * sine, s * cosine + c * sine)
    if not averaged:
        return ended
    started = forcing_with(forcing, cosine, sine)
    return between(alpha_f, ended[0], started[0]), between(alpha_f, ended[1], started[1])


@jit_inlined
def write_column(column, z, k, force):
    """Write a column of a stage from its end and λ; ``k``: :class:`.stage.Unforced`."""
    column[0], column[2], column[4], column[1], column[3], column[5] = z
    gap, rate, by_gap, by_rate = k.point
    column[FORCE], column[GAP], column[RATE] = force, gap + by_gap * force, rate + by_rate * force


@jit_inlined
def write_free_end(columns, x, end):
    """Write the end of a stage without its contact force."""
    v0, v1, v2, v3, v4, v5, v6, v7 = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    for j in range(OWN):  # column by column: vector instructions
        c, q = columns[j], x[j]
        v0, v1, v2, v3 = v0 + c[0] * q, v1 + c[1] * q, v2 + c[2] * q, v3 + c[3] * q
        v4, v5, v6, v7 = v4 + c[4] * q, v5 + c[5] * q, v6 + c[GAP] * q, v7 + c[RATE] * q
    end[0], end[1], end[2], end[3], end[4], end[5], end[FORCE] = v0, v1, v2, v3, v4, v5, 0.0
    end[GAP], end[RATE] = v6, v7


@jit_inlined
def force_of_stage(law, gain, free, own):
    """λ of a stage, from its end without it and what a unit of it adds."""
    if law.kind <= CUT:  # of most runs, without a call
        root = linear_root(law.stiffness, gain, 0.0, free[GAP], free[RATE], own[GAP], own[RATE])
        return force_of_law(law.kind, root)
    return solve_force(law, gain, free[GAP], free[RATE], own[GAP], own[RATE])


@jit_inlined
def take_stage(m, level, k, former, x, ends):
    """Write the end of stage k with the status s to ``ends[s]``; returns s, and NONE, 1 or TWO solutions."""
    columns, free, end, law = m.maps[level, k], ends[0], ends[1], m.system.law
    write_free_end(columns, x, free)
    if not m.at_end and former == 0:
        return 0, 1
    own = columns[OWN]
    push = force_of_stage(law, x[GAIN], free, own)
    for i in range(ROWS):
        end[i] = free[i] + own[i] * push
    acts = push > 0.0 or law.kind != CUT
    if not m.at_end:
        return int(acts), 1
    closed, stays_closed = free[GAP] <= 0.0 and acts, end[GAP] <= 0.0 and acts
    kept, other = (stays_closed, not closed) if former == 1 else (not closed, stays_closed)
    if other:
        return (former, TWO) if kept else (1 - former, 1)
    return former, 1 if kept else NONE


@jit_inlined
def gain_of_step(m, u, pressed, contact):
    """c, or h of Eq. (18): of the open contact, or with the speed with which the coming step may begin one."""
    return gain_at(m.system.law, m.system.sign * (contact.speed1 - contact.speed2) if pressed else -u[3])


@jit_inlined
def motion_of(m, u):
    """ξ₁, ξ₁′, ξ₂, ξ₂′ of a state u."""
    return displacements(m.system, u[0], u[2], u[1], u[3])


@jit_inlined
def force_at(m, u, pressed, contact):
    """λ of a state u, as the step that now begins will feel it."""
    if not pressed:
        return 0.0
    return m.system.sign * law_force(m.system.law, gain_of_step(m, u, pressed, contact), -u[1], -u[3])


@jit_no_alloc
def take_step(m, level, former, x, ends):
    """Write the end of a step of this ``level`` with the status s, of its last stage, to ``ends[s]``.

    Returns
    -------
    tuple
        s; NONE, 1 or TWO solutions; mean contact force over the step.
    """
    x[BEFORE] = 0.0
    status, solutions = take_stage(m, level, 0, former, x, ends)
    push = m.weights[0] * ends[status, FORCE]
    if m.maps.shape[1] > 1:
        former = status if m.at_end else int(ends[status, GAP] <= 0.0)
        x[BEFORE] = ends[status, FORCE]
        status, more = take_stage(m, level, 1, former, x, ends)
        solutions = min(solutions, more) if NONE in (solutions, more) else max(solutions, more)
        push += m.weights[1] * ends[status, FORCE]
    return status, solutions, push


@jit_inlined
def begin_step(x, u, cosine, sine):
    """Write x at the beginning of a step from the state u."""
    for k in range(STATE_ROWS):
        x[k] = u[k]
    x[STATE_ROWS], x[STATE_ROWS + 1], x[STATE_ROWS + 2] = cosine, sine, 1.0


@jit_no_alloc
def take_parts(m, status, angle, x, ends):
    """Take a step cut into the fewest parts, 2, 4, … PARTS, each half of the one before, that have a solution.

    ``angle``: ητ at its beginning. A part without a solution is halved, and so are all that follow. Returns what
    :func:`take_step` does, of the whole; x is no longer that of the beginning.
    """
    level, done, impulse, solutions, load, slope = 1, 0, 0.0, 1, x[STATE_ROWS], x[STATE_ROWS + 1]
    while done < PARTS:
        former = status if m.at_end else int(x[1] <= 0.0)
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
def advance(m, angles, u, at, work, window, buffers):
    """Take one step and record it; u is changed in place unless the step ends the run.

    Returns
    -------
    tuple
        :class:`StepProgress`; OK, DIVERGED, FULL, or WITHOUT_SOLUTION: then u is that before the step that has none.
        CROSSED: the next step is to be seen from the other stop; if this one is all in flight it is taken again.
    """
    n, recorded, x, ends = angles.shape[1], buffers.contacts.shape[0] > 0, work[0], work[1:]
    k, code = at.step % n, OK
    begin_step(x, u, angles[0, k], angles[1, k])
    former = at.status if m.at_end else int(at.pressed)
    x[GAIN] = gain_of_step(m, u, at.pressed, at.contact)
    after, solutions, push = take_step(m, 0, former, x, ends)
    none, two = at.none + (solutions == NONE), at.two + (solutions == TWO)
    if solutions == NONE and m.without == HALVE:
        after, solutions, push = take_parts(m, former, k * m.turn, x, ends)
    if solutions == NONE and m.without != KEEP:
        return StepProgress(at.status, at.pressed, at.step, none, two, at.contact), WITHOUT_SOLUTION
    before, v, rate = u[1], u[2], u[3]
    for j in range(STATE_ROWS):
        u[j] = ends[after, j]
    i, k = at.step + 1, (k + 1 if k + 1 < n else 0)
    impulse, gap, pressed = m.system.h * push, u[1], u[1] <= 0.0
    contact = with_impulse(at.contact, at.contact.impulse + impulse)
    if pressed != at.pressed:
        now = motion_of(m, u)
        if pressed:
            if push != 0.0:  # the force has acted in this step already: the speeds are those before it
                _, v1, _, v2 = displacements(m.system, 0.0, v, 0.0, rate)
                now = now[0], v1, now[2], v2
            closing = (before - gap) / m.system.h if recorded else 0.0
            contact = with_impulse(begin_contact(m.system, i, now, closing), impulse)
        elif recorded:
            end_contact(m.system, contact, i, now, u[FORCE], buffers)
            code = FULL if no_room(buffers) else OK
    if recorded and (k == 0 or (i >= window[1] and k % window[2] == 0)):
        write_output(i, k, n, motion_of(m, u), force_at(m, u, pressed, contact), window, buffers)
    if not -LIMIT < gap < m.system.reach:
        code = ending_of(gap)
        if code == CROSSED and push == 0.0 and m.without != HALVE and x[1] > 0.0:
            i -= 1  # the step is taken again from the other stop, which it may have met
            for j in range(STATE_ROWS):
                u[j] = x[j]
    return StepProgress(after, pressed, i, none, two, contact), code


@jit_inlined
def write_first_sample(m, u, at, window, buffers):
    """Write the sample at the step with which sampling begins, if the run stands there."""
    if at.step == window[1] and buffers.samples.shape[0] > 0:
        write_sample(buffers.samples[0], motion_of(m, u), force_at(m, u, at.pressed, at.contact))


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
    u, at = s.u, s.progress
    write_first_sample(m, u, at, window, buffers)
    while at.step < stop and code == OK:
        at, code = advance(m, angles, u, at, work, window, buffers)
    write_progress(state, at)
    return code
