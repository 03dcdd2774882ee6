"""The growth of a small disturbance along the motion of each cell (:mod:`..event_driven.disturbance`)."""

import math
from typing import NamedTuple

import numpy as np
from vibroscope.engine.kernels.batch.run import WorkSpace, set_up
from vibroscope.engine.kernels.compile.options import jit
from vibroscope.engine.kernels.equations.coordinates import contact_coordinates, displacements
from vibroscope.engine.kernels.event_driven.disturbance import follow_disturbance
from vibroscope.engine.kernels.event_driven.saltation import Variation
from vibroscope.engine.kernels.event_driven.state import unpack_system

PERIODS_A_LOOK = 512  # periods between two looks at whether the call is withdrawn: some milliseconds


class FollowSpace(NamedTuple):
    """What one thread works in."""

    work: WorkSpace
    variation: Variation  # of one number
    ends: np.ndarray  # (2, 4) the state and the disturbance


@jit
def follow_pieces(space, growth, section, signals):
    """Follow a disturbance as :func:`follow_disturbance` does, to the end or until the call is withdrawn (False)."""
    work, y, direction = space.work, space.ends[0], space.ends[1]
    growth[:] = math.nan
    for begin in range(0, growth.shape[0], PERIODS_A_LOOK):
        if signals[0] != 0:
            return False
        end, nothing = min(begin + PERIODS_A_LOOK, growth.shape[0]), (work.nothing, work.no_sizes)
        rows = growth[begin:end], section[begin:end]
        follow_disturbance(work.packed, work.state, space.variation, nothing, y, direction, rows[0], rows[1])
        if math.isnan(growth[end - 1]):
            break
    return True


@jit
def follow_cell(cells, i, plan, space, settling, growth, section, signals):
    """Follow the motion of one cell, and a disturbance of it; False if the call was withdrawn.

    Parameters
    ----------
    cells : BatchCells
    i : int
    plan : BatchPlan
        Of the reference or the exact penalty method.
    space : FollowSpace
    settling : int
        Periods before those of ``growth``, and at most as many, in which the disturbance turns into the direction of
        fastest growth.
    growth : (n,) float64
        ln of the growth in each period: −∞ where nothing is left of the disturbance; nan from the period on that ends
        early or has no derivative.
    section : (n, 4) float64
        ξ₁, ξ₁′, ξ₂, ξ₂′ at the end of each period.
    signals : (n,) int64
        ``signals[0]`` is set to withdraw the call.
    """
    set_up(space.work, cells, plan, i)
    system, start = unpack_system(space.work.packed), cells.initial[i]
    y, direction = space.ends[0], space.ends[1]
    y[0], y[1], y[2], y[3] = contact_coordinates(system, start[0], start[1], start[2], start[3])
    direction[:] = 0.5
    before = growth[:settling]
    if not follow_pieces(space, before, section[:settling], signals):
        return False
    if math.isnan(before[settling - 1]):
        growth[:] = math.nan
        return True
    if not follow_pieces(space, growth, section, signals):
        return False
    for n in range(growth.shape[0]):
        x = section[n]
        x[0], x[1], x[2], x[3] = displacements(system, x[0], x[1], x[2], x[3])
    return True
