"""The growth of a small disturbance along the motion of each cell (:mod:`..event_driven.disturbance`)."""

import math

from ..compile.options import jit
from ..equations.coordinates import contact_coordinates, displacements
from ..event_driven.disturbance import follow_disturbance
from ..event_driven.state import unpack_system
from .run import set_up

PERIODS_A_LOOK = 512  # periods between two looks at whether the call is withdrawn: some milliseconds


@jit
def follow_pieces(work, variation, y, direction, growth, section, signals):
    """Follow a disturbance as :func:`follow_disturbance` does, to the end or until the call is withdrawn (False)."""
    growth[:] = math.nan
    for begin in range(0, growth.shape[0], PERIODS_A_LOOK):
        if signals[0] != 0:
            return False
        end, nothing = min(begin + PERIODS_A_LOOK, growth.shape[0]), (work.nothing, work.no_sizes)
        rows = growth[begin:end], section[begin:end]
        follow_disturbance(work.packed, work.state, variation, nothing, y, direction, rows[0], rows[1])
        if math.isnan(growth[end - 1]):
            break
    return True


@jit
def follow_cell(cells, i, plan, work, variation, settling, ends, growth, section, signals):
    """Follow the motion of one cell, and a disturbance of it; False if the call was withdrawn.

    Parameters
    ----------
    cells : BatchCells
    i : int
    plan : BatchPlan
        Of the reference or the exact penalty method.
    work : WorkSpace
    variation : Variation
        Of one number.
    settling : int
        Periods before those of ``growth``, and at most as many, in which the disturbance turns into the direction of
        fastest growth.
    ends : (2, 4) float64
        Work space: the state and the disturbance.
    growth : (n,) float64
        ln of the growth in each period: −∞ where nothing is left of the disturbance; nan from the period on that ends
        early or has no derivative.
    section : (n, 4) float64
        ξ₁, ξ₁′, ξ₂, ξ₂′ at the end of each period.
    signals : (n,) int64
        ``signals[0]`` is set to withdraw the call.
    """
    set_up(work, cells, plan, i)
    system, start = unpack_system(work.packed), cells.initial[i]
    y, direction = ends[0], ends[1]
    y[0], y[1], y[2], y[3] = contact_coordinates(system, start[0], start[1], start[2], start[3])
    direction[:] = 0.5
    before = growth[:settling]
    if not follow_pieces(work, variation, y, direction, before, section[:settling], signals):
        return False
    if math.isnan(before[settling - 1]):
        growth[:] = math.nan
        return True
    if not follow_pieces(work, variation, y, direction, growth, section, signals):
        return False
    for n in range(growth.shape[0]):
        x = section[n]
        x[0], x[1], x[2], x[3] = displacements(system, x[0], x[1], x[2], x[3])
    return True
