"""The state of a march in closed form, and what it needs to know about the pendulums and their contact."""

import math
from typing import NamedTuple

import numpy as np

from .jit import inlined
from .phase import Phase, Scratch, circle

# what follows an anchor. CALM: pressed together, what was fast in it having died away; COLLIDING: an impact or a touch
# is due
SEPARATED, TOUCHING, CALM, COLLIDING = 0.0, 1.0, 2.0, 3.0


class Contact(NamedTuple):
    """The two phases and the laws between them.

    Touching pendulums are joined (reference) or pressed together by a spring and a damper (exact penalty).
    """

    period: float
    rigid: bool  # whether the contact is the reference's
    flight: Phase  # its watched quantity is the gap
    touching: Phase  # its watched quantity is the contact force (reference) or the penetration −g (penalty)
    calm: Phase  # what touching is left with when its fast modes have died away, see engine.drivers.slow
    fast: np.ndarray  # (4, 6) what of z is fast; (0, 6) if there is no phase of its own for the rest
    force_position: float  # contact force λ = force_position ξ₁ + force_velocity ξ₁′ + force_gap g + force_rate g′
    force_velocity: float
    force_gap: float
    force_rate: float
    mass_share: float  # μ/(1 + μ)
    restitution: float  # of the reference, as all that follows
    threshold: float
    completion: float  # how far a chatter must have come to be completed (see chatter.py)
    scratch: Scratch


class Touch(NamedTuple):
    """The contact that is open."""

    begun: float  # τ since the start of the run
    closing: float  # closing speed at its beginning; 0 if it began without an impact, or before the kept periods
    position: float  # ξ₁ at its beginning
    speed1: float  # ξ₁′
    speed2: float  # ξ₂′
    impulse: float  # ∫λ dτ so far


class Anchor(NamedTuple):
    """Where a phase begins, or where the search for its end goes on.

    Of pendulum 2 it holds gap and rate instead, so that a short flight keeps its digits.
    """

    period: float  # whole periods since the start of the run
    tau: float  # time since the beginning of that period
    x1: float
    v1: float
    gap: float  # g = ξ₂ − ξ₁
    rate: float  # g′
    mode: float  # SEPARATED, TOUCHING, CALM or COLLIDING
    order: float  # of the first derivative of the watched quantity that is not zero
    events: float  # in this period so far
    touch: Touch


@inlined
def untouched():
    """No contact is open."""
    return Touch(0.0, 0.0, 0.0, 0.0, 0.0, 0.0)


@inlined
def touches(a):
    """Whether the pendulums touch from this anchor on."""
    return a.mode in (TOUCHING, CALM)


@inlined
def state(p, a):
    """z of an anchor (see :mod:`.phase`)."""
    c, s = circle(a.tau / p.period)
    return a.x1, a.v1, a.gap, a.rate, c, s


@inlined
def clock(p, a):
    """τ of an anchor since the start of the run."""
    return a.period * p.period + a.tau


@inlined
def after(p, a, s, x1, v1, gap, rate, mode, order, touch):
    """An anchor s later."""
    tau = a.tau + s
    whole = math.floor(tau / p.period)
    events = a.events if whole == 0.0 else 0.0
    return Anchor(a.period + whole, tau - whole * p.period, x1, v1, gap, rate, mode, order, events, touch)
