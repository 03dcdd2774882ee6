"""A periodic orbit of a piecewise linear contact law as a sequence of events: its equations and their derivative.

The equations are those of :mod:`.orbit`, Eq. (52), with the pieces of :mod:`.law_integrate` as phases. Besides touch
and part there are events at which a contact changes its piece; each is the zero of one quantity, in units of length or
of speed, δ = −g being the penetration, v = −g′ and c = 2D:

    UNLOAD, LOAD       δ + (c/K) v      the force falls to zero, and rises again      "cut", "limited"
    LIMIT, UNLIMIT     (c/K) v − δ      the damper's force is limited, and no longer  "limited"
    RELAX, DAMP        v                the damper ceases to act, and acts again      "compression"

Nothing jumps at an event but the damper's force at touch. What the equation of an event has as a trivial zero, since an
event before it is a zero of the same quantity, is divided out: of a touch the last part, of a part the touch with which
its contact began, of another event the one before if that watches the same.

Plain twin: runs of the event loop, and differences of them (tests/engine/test_law_branches.py).
"""

import numpy as np

from ..compile.options import jit, jit_inlined, jit_no_alloc
from ..equations.contact_law import COMPRESSION, LIMITED
from ..linear.cos_sin import cos_sin
from .law_integrate import phase_of
from .orbit import (
    CLOSING,
    DAMP,
    DEPTH,
    LIMIT,
    LOAD,
    LOWEST,
    OTHER_LOWEST,
    OTHER_WHERE,
    PART,
    PARTING,
    RELAX,
    TOUCH,
    UNLIMIT,
    UNLOAD,
    WHERE,
    are_within,
    close_cycle,
    divide_by_length,
    start_at,
    write_after,
    write_nan,
)
from .orbit_phase import BACKWARDS, flow, lowest_minimum, relative_state, state_later, write_section
from .saltation import leave_event, make_variation, scale_row, shift, slope_of
from .state import absolute

IN_FLIGHT, IN_OVERLAP, IN_PUSH, IN_EXTRA = range(4)  # numbers of pieces
RISING = (PART, LOAD, LIMIT, DAMP)  # events at which the quantity grows through zero


@jit_inlined
def piece_after(law, kind):
    """The piece that an event begins."""
    if kind == PART:
        return IN_FLIGHT
    if kind == UNLOAD:
        return IN_OVERLAP
    if kind in (LIMIT, RELAX) or (kind == TOUCH and law == LIMITED):
        return IN_EXTRA
    return IN_PUSH


@jit_inlined
def event_row(p, kind):
    """Factors of g and g′ in the quantity whose zero an event is."""
    if kind in (TOUCH, PART):
        return 1.0, 0.0
    if kind in (UNLOAD, LOAD):
        return -1.0, -p.gain / p.stiffness
    if kind in (LIMIT, UNLIMIT):
        return 1.0, -p.gain / p.stiffness
    return 0.0, -1.0


@jit_inlined
def unit_of_watched(p, piece, k):
    """The k-th quantity that a piece watches (:mod:`.law_integrate`), over its length or speed."""
    if piece == IN_FLIGHT:
        return 1.0
    turns = p.law == COMPRESSION and (piece == IN_PUSH or k == 1)
    return p.gain if turns else p.stiffness


@jit_inlined
def event_before(kinds, k):
    """The event in this cycle that is a trivial zero of the equation of event k, −1 if there is none."""
    kind = kinds[k]
    if kind == PART:
        for j in range(k - 1, -1, -1):
            if kinds[j] == TOUCH:
                return j
            if kinds[j] == PART:
                return -1
        return -1
    if k == 0:
        return -1
    before = kinds[k - 1]
    same = before == PART if kind == TOUCH else before // 2 == kind // 2  # kinds of switches are numbered in pairs
    return k - 1 if same else -1


@jit_no_alloc
def write_lowest(p, piece, z, length, begun, turn, row, whole):
    """Write the lowest minimum of each watched quantity within a piece, and when; ``whole``: it is the whole cycle."""
    row[LOWEST] = row[OTHER_LOWEST] = np.inf
    for j in range(p.counts[piece]):
        lowest, where = lowest_minimum(phase_of(p, piece, j), z, length, begun, whole, p.scratch)
        row[LOWEST if j == 0 else OTHER_LOWEST] = lowest / unit_of_watched(p, piece, j)
        row[WHERE if j == 0 else OTHER_WHERE] = turn + where / p.period


@jit_no_alloc
def find_law_orbit(p, kinds, piece, periods, unknowns, out, d, begun):
    """Fill what :func:`evaluate_law_orbit` fills; False if a phase is too short for its tables.

    ``d``: the variation of all unknowns; ``begun``: work space, (4 + m,).
    """
    residual, jacobian, facts, after, section = out
    m, turn = kinds.shape[0], 0.0
    y = start_at(p, d, unknowns, piece != IN_FLIGHT)
    for k in range(m + 1):
        end = unknowns[4 + k] if k < m else periods
        phase = phase_of(p, piece, 0)
        z, length = relative_state(p, phase, y, turn), (end - turn) * p.period
        if length < BACKWARDS * phase.spacing:
            return False
        leave_event(phase, d, z)
        if facts.shape[0] > 0:
            write_lowest(p, piece, z, length, k > 0, turn, facts[k], m == 0)
            write_section(p, phase, z, turn, end, section)
        x1, v1, gap, rate = flow(phase, z, length, d)
        y = absolute(phase, (x1, v1, gap, rate))
        if k == m:
            break
        kind = kinds[k]
        c, s = cos_sin(end - np.floor(end))
        d.time[4 + k] = p.period
        slope = slope_of(phase, (x1, v1, gap, rate, c, s))
        shift(d, slope, 1.0)
        of_gap, of_rate = event_row(p, kind)
        residual[4 + k] = of_gap * y[2] + of_rate * y[3]
        for j in range(unknowns.shape[0]):
            jacobian[4 + k, j] = of_gap * d.state[2, j] + of_rate * d.state[3, j]
        if facts.shape[0] > 0:
            growth = of_gap * slope[2] + of_rate * slope[3]
            facts[k, CLOSING] = growth if kind in RISING else -growth
            facts[k, PARTING], facts[k, DEPTH] = y[3], -y[2]
        before = event_before(kinds, k)
        if before >= 0:
            for j in range(begun.shape[0]):
                begun[j] = 1.0 if j == 4 + before else 0.0
            divide_by_length(residual, jacobian, k, 1, end - unknowns[4 + before], begun)
        if kind in (TOUCH, PART):
            y = y[0], y[1], 0.0, y[3]
            scale_row(d, 2, 0.0)
        else:  # the quantity is zero whatever the residual
            share = -of_gap / of_rate
            y = y[0], y[1], y[2], share * y[2]
            for j in range(unknowns.shape[0]):
                d.state[3, j] = share * d.state[2, j]
        turn, piece = end, piece_after(p.law, kind)
        write_after(after[k], y, turn)
    close_cycle(y, periods, unknowns, out, d)
    return True


@jit
def evaluate_law_orbit(p, kinds, piece, periods, unknowns, out):
    """Evaluate the equations of an orbit and their Jacobian, as :func:`.orbit.evaluate_orbit` does.

    Parameters
    ----------
    p : LawSystem
        Of a piecewise linear law with a damper.
    kinds : (m,) int64
        TOUCH, PART, and the switches of the law.
    piece : int
        At τ = 0.
    periods, unknowns, out
        As there, but ``facts`` (m + 1, LAW_FACTS): "closing speed" is the rate at which the quantity of an event passes
        zero in the direction of the event, and beside it stands the penetration; the lowest minimum is of the first
        quantity that a piece watches, and of the second, if there is one.
    """
    n = unknowns.shape[0]
    d = make_variation(n)
    if not are_within(unknowns, periods) or not find_law_orbit(p, kinds, piece, periods, unknowns, out, d, np.zeros(n)):
        write_nan(out)


@jit_no_alloc
def law_state_later(p, piece, y, turn, length):
    """(ξ₁, ξ₁′, g, g′) a number of excitation periods after y, which belongs to a time in them; without an event."""
    return state_later(p, phase_of(p, piece, 0), y, turn, length * p.period)
