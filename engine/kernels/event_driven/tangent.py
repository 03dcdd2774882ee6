"""The march once more, with the derivative of the state with respect to its start: the Jacobian of the Poincaré map.

What a phase and an event make of that derivative :mod:`.saltation` says.
"""

import numpy as np

from ..compile.options import jit
from ..linear.first_root import NEWTON_LIMIT, first_root
from ..linear.tables import POINTS
from .events import parts, settle, strike
from .integrate import (
    DONE,
    MOST_EFFORT,
    MOST_EVENTS,
    PAUSED,
    PILED_UP,
    UNRESOLVED,
    calmed,
    end_of_block,
    end_of_phase,
    state_at,
)
from .saltation import Change, advance, apply, common, leave, meet, over_chatter, reset
from .state import CALM, COLLIDING, TOUCHING, Anchor, clock, state

COURSES = 2**61 - 1  # a prime


@jit
def at_end(p, phase, change, z, s):
    """(ξ₁, ξ₁′, g, g′) at s within the block that begins at z, δ being carried there."""
    i = min(max(int(s / phase.spacing), 0), POINTS - 1)
    advance(phase, change, i, s / phase.spacing - i)
    return state_at(p, phase, z, s)


@jit
def at_event(p, change, a, stop):
    """The anchor after what is due at a, d being carried over it; the flag: within a chatter that outlasts ``stop``."""
    before, a = a, strike(p, a)
    reset(p, change, before, a)
    before, a = a, settle(p, a)
    if clock(p, a) > clock(p, before):
        if (stop - a.period) * p.period < a.tau:
            return before, True
        over_chatter(p, change, before, a)
    else:
        reset(p, change, before, a)
    return a, False


@jit
def march_along(p, a, stop):
    """Carry the motion and its derivative to the end of period ``stop``.

    Parameters
    ----------
    p : Contact
    a : Anchor
        The start, at a whole period.
    stop : float
        Number of periods since the start of the run.

    Returns
    -------
    ((4,) tuple, (4, 4) float64, int, int)
        (ξ₁, ξ₁′, g, g′) there; its derivative with respect to that at ``a``; a number that tells one sequence of phases
        from another; and how the march ended (see ``march``). Unless DONE, the other numbers
        mean nothing; PAUSED: it is not worth going on.
    """
    change, nothing, examined, course = Change(np.eye(4), np.zeros(4)), (0.0, 0.0, 0.0, 0.0), 0, 1
    phases = (p.flight, p.touching, p.calm)
    if a.mode == COLLIDING and a.rate < 0.0:
        meet(p.flight, change, state(p, a), a.rate)
    while True:
        a, within = at_event(p, change, a, stop)
        horizon = (stop - a.period) * p.period - a.tau
        if within:
            z = common(p, change, state(p, a))
            leave(p.touching, change, z)
            return at_end(p, p.touching, change, z, horizon), change.state, course, DONE
        if not parts(p, a):
            return nothing, change.state, course, UNRESOLVED
        before, a = a, calmed(p, a)
        if a.mode == CALM and before.mode == TOUCHING:
            apply(np.eye(4) - p.fast[:, :4], change)
        phase = phases[int(a.mode)]
        z = state(p, a)
        leave(phase, change, z)
        i, u, slope, tries = first_root(phase, z, int(a.order), NEWTON_LIMIT, p.scratch)
        examined += tries
        if (i + u) * phase.spacing >= horizon:
            return at_end(p, phase, change, z, horizon), change.state, course, DONE
        advance(phase, change, i, u)
        if i == POINTS:
            if examined > MOST_EFFORT:
                return nothing, change.state, course, PAUSED
            a = end_of_block(p, phase, a, z)
            continue
        a = end_of_phase(p, phase, a, z, i, u, slope)
        meet(phase, change, state(p, a), slope)
        course = (course * 4 + int(a.mode)) % COURSES
        a = Anchor(a.period, a.tau, a.x1, a.v1, a.gap, a.rate, a.mode, a.order, a.events + 1.0, a.touch)
        if a.events > MOST_EVENTS:
            return nothing, change.state, course, PILED_UP
