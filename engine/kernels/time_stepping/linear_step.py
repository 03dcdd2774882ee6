"""One-step methods whose step is a matrix for each contact status, one step after the other.

**A stage** maps x = (y, cos ητ₀, sin ητ₀, 1) at the beginning of a step to y and the gap where the contact law takes it
(the matrices: :mod:`engine.drivers.step_maps`). With the status 1 the force of spring and damper acts, with 0 it does
not. The end of a stage *wants* the status 1 if the gap is not positive, with the law that is cut only if the force
pushes too (Eqs. (5) and (6) of :mod:`..equations.contact_law`).

**Status from the start of the step**: 1 if the gap there is not positive; where the law is cut and the force would pull
at the end, 0. **From its end**: a status that its own end wants. The former status is tried first. Neither may agree
with its own end: the step has no solution. Both may: it has two, and keeps the former status. An explicit method knows
the gap before the force; its two statuses have one end, so exactly one agrees.

A step without a solution ends the run, or keeps the former status, or is cut into 2, 4, … parts until all of them have
a solution.
"""

import math
from typing import NamedTuple

import numpy as np

from ..compile.options import jit, jit_inlined
from ..compile.packing import Layout
from ..compile.record import OpenContact, no_room, with_impulse
from ..equations.contact_law import CUT
from ..status import DIVERGED, FULL, OK, WITHOUT_SOLUTION
from .newmark import LIMIT, Scheme, begin_contact, displaced, end_contact, write_output, write_sample

STATE_ROWS, FORCE = 7, 6  # y, and where λ stands in it
GAP = STATE_ROWS  # row of the gap
COLUMNS = STATE_ROWS + 3
HALVINGS = 10
PARTS = 1 << HALVINGS
STOP, KEEP, HALVE = range(3)  # what a step without a solution does
NONE, TWO = -1, 2  # of a step: it has no solution, or two


class LinearScheme(NamedTuple):
    """The matrices of a method and the contact; of ``system`` only what the contact and the coordinates need."""

    maps: np.ndarray  # (1 or HALVINGS + 1, 2 or 6, STATE_ROWS + 1, COLUMNS): of steps of size Δτ, Δτ/2, …
    weights: tuple  # share of the impulse that each of two stages gives; the second is 0 if there is one
    at_end: bool  # whether the status is that of the end
    without: int  # STOP, KEEP or HALVE
    turn: float  # ηΔτ
    system: Scheme


class LinearState(NamedTuple):
    """The discrete solution at the end of a step."""

    y: np.ndarray  # (STATE_ROWS,)
    status: int  # of the last stage
    pressed: bool  # whether the gap is not positive
    step: int  # steps done
    none: int  # steps that had no solution
    two: int  # steps that had two
    contact: OpenContact


STATE = Layout(LinearState, y=(STATE_ROWS,), contact=Layout(OpenContact))
unpack_state, write_state = STATE.unpack, STATE.write


@jit_inlined
def row(matrix, k, x):
    """Row k of a matrix times x."""
    value = 0.0
    for j in range(COLUMNS):
        value += matrix[k, j] * x[j]
    return value


@jit_inlined
def wants_contact(m, matrix, x):
    """Whether the end of a stage wants the force to act."""
    return row(matrix, GAP, x) <= 0.0 and (m.system.law != CUT or row(matrix, FORCE, x) > 0.0)


@jit_inlined
def decide(m, pair, former, x):
    """Status of a stage with the matrices ``pair``, and NONE, 1 or TWO solutions."""
    if not m.at_end:
        pulls = former == 1 and m.system.law == CUT and row(pair[1], FORCE, x) < 0.0
        return (0 if pulls else former), 1
    kept = wants_contact(m, pair[former], x) == (former == 1)
    other = wants_contact(m, pair[1 - former], x) == (former == 0)
    if kept:
        return former, TWO if other else 1
    return (1 - former, 1) if other else (former, NONE)


@jit
def take_step(m, level, former, x, y):
    """Write the end of a step of this ``level`` to ``y``.

    Returns
    -------
    tuple
        Status of the last stage; NONE, 1 or TWO solutions; mean contact force over the step.
    """
    maps = m.maps[level]
    status, solutions = decide(m, maps[:2], former, x)
    matrix = maps[status]
    push = m.weights[0] * row(matrix, FORCE, x) if status == 1 else 0.0
    if maps.shape[0] > 2:
        pair = maps[2 + 2 * status : 4 + 2 * status]
        former = status if m.at_end else int(row(matrix, GAP, x) <= 0.0)
        status, more = decide(m, pair, former, x)
        matrix = pair[status]
        solutions = NONE if NONE in (solutions, more) else max(solutions, more)
        push += m.weights[1] * row(matrix, FORCE, x) if status == 1 else 0.0
    for k in range(STATE_ROWS):
        y[k] = row(matrix, k, x)
    y[FORCE] *= status
    return status, solutions, push


@jit_inlined
def is_pressed(m, y):
    """Whether the gap is not positive."""
    return y[1] - y[0] <= m.system.touch


@jit
def take_parts(m, status, angle, x, y):
    """Take a step cut into the fewest parts, 2, 4, … PARTS, each half of the one before, that have a solution.

    ``angle``: ητ at its beginning. A part without a solution is halved, and so are all that follow. Returns what
    :func:`take_step` does, of the whole.
    """
    level, done, impulse, solutions = 1, 0, 0.0, 1
    angles = m.turn / PARTS
    while done < PARTS:
        former = status if m.at_end else int(is_pressed(m, x))
        after, solutions, push = take_step(m, level, former, x, y)
        if solutions == NONE:
            if level == HALVINGS:
                break
            level += 1
            continue
        part = PARTS >> level
        done, status, impulse = done + part, after, impulse + push * part / PARTS
        x[:STATE_ROWS] = y
        x[STATE_ROWS], x[STATE_ROWS + 1] = math.cos(angle + done * angles), math.sin(angle + done * angles)
    return status, solutions, impulse


@jit_inlined
def motion_of(m, y):
    """ξ₁, ξ₁′, ξ₂, ξ₂′ of a state y."""
    return displaced(m.system, y[0], y[2], y[1], y[3])


@jit
def integrate_linear(m, angles, state, stop, window, buffers):
    """Integrate to the end of step ``stop``, and fill the buffers if they have room for contacts.

    Parameters
    ----------
    m : LinearScheme
    angles : (2, n) float64
        cos ητ and sin ητ at the beginning of each step of a period.
    state : (STATE.size,) float64
        A :class:`LinearState`, changed in place.
    stop : int
    window : (3,) int64
        As in :func:`.newmark.integrate_recorded`.
    buffers : Buffers

    Returns
    -------
    int
        OK, DIVERGED, FULL, or WITHOUT_SOLUTION: then the state is that before the step that has none.
    """
    s, n, status = unpack_state(state), angles.shape[1], OK
    y, acting, pressed, i, none, two, contact = s.y, s.status, s.pressed, s.step, s.none, s.two, s.contact
    recorded, x, end = buffers.contacts.shape[0] > 0, np.empty(COLUMNS), np.empty(STATE_ROWS)
    k, impulse, x[COLUMNS - 1] = i % n, contact.impulse, 1.0
    if recorded and i == window[1] and buffers.samples.shape[0] > 0:
        write_sample(m.system, buffers.samples[0], motion_of(m, y), pressed)
    while i < stop and status == OK:
        x[:STATE_ROWS] = y
        x[STATE_ROWS], x[STATE_ROWS + 1] = angles[0, k], angles[1, k]
        former = acting if m.at_end else int(pressed)
        after, solutions, push = take_step(m, 0, former, x, end)
        none, two = none + (solutions == NONE), two + (solutions == TWO)
        if solutions == NONE and m.without == HALVE:
            after, solutions, push = take_parts(m, former, k * m.turn, x, end)
        if solutions == NONE and m.without != KEEP:
            status = WITHOUT_SOLUTION
            break
        before = y[1] - y[0]
        y[:], acting = end, after
        i, k = i + 1, (k + 1 if k + 1 < n else 0)
        impulse += m.system.h * push
        gap = y[1] - y[0]
        if is_pressed(m, y) != pressed:
            pressed = not pressed
            now = motion_of(m, y)
            if pressed:
                contact = begin_contact(m.system, i, now, (before - gap) / m.system.h if recorded else 0.0)
                impulse = 0.0
            elif recorded:
                end_contact(m.system, with_impulse(contact, impulse), i, now, buffers)
                status = FULL if no_room(buffers) else OK
        if recorded and (k == 0 or (i >= window[1] and k % window[2] == 0)):
            write_output(m.system, i, k, n, motion_of(m, y), pressed, window, buffers)
        if not abs(gap) < LIMIT:
            status = DIVERGED
    write_state(state, LinearState(y, acting, pressed, i, none, two, with_impulse(contact, impulse)))
    return status
