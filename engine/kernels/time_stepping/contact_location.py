"""A step of any length, and the instant within it at which contact changes.

**Step.** One of any length s is made of the same stages (:mod:`.stage`), and is solved for the contact force by
:mod:`.law_step`. Newmark's, with the contact of spring and damper, is that of the equations (12) of either side.

**Instant of change.** A step of length θ is itself such a step, so the gap g(θ) that it ends with is a known function.
If the gap at the end of the step is not on the side of its beginning, secants in a bracket find the θ with g(θ) = 0.
They begin at the zeros of two cubics, through what is known at the beginning and the gap at the end, then through the
gap of the first step, too. Two steps are enough in most cases: the motion at the next instant follows from a parabola
through those at the end of the step and at the last two instants, to rounding. A gap that changes sides
twice within a step is on the same side at both ends. It shows in the motion between them, which is Newmark's own:
constant acceleration (b₀ + b₁)/2, a parabola. Where the vertex of the parabola lies beyond the surface, the step that
ends at the vertex decides. Of other integrators the parabola is that through the gaps at both ends, with the rate at
the beginning.
"""

from typing import NamedTuple

import numpy as np
from vibroscope.engine.kernels.compile.options import jit_inlined, jit_no_alloc
from vibroscope.engine.kernels.compile.packing import Layout
from vibroscope.engine.kernels.equations.contact_law import KELVIN_VOIGT, ContactLaw, law_force
from vibroscope.engine.kernels.linear.cos_sin import cos_sin
from vibroscope.engine.kernels.time_stepping.law_step import solve_force
from vibroscope.engine.kernels.time_stepping.stage import (
    ALPHA_F,
    AVERAGE_ACCELERATION,
    STAGE_NUMBERS,
    Side,
    Stages,
    between,
    end_with,
    end_with_force,
    forcing_with,
    unforced_end,
    with_accelerations,
)

CUBIC_NEWTON = 3  # iterations for the zero of a cubic, which are cheap, and the step there is solved in any case
PRECISION = 1e-14  # of an instant of change, as a share of its step: the rounding of the gap allows little more
ITERATIONS = 100  # two to four are needed, half of this with bisection alone
AWAY = 1e-3  # of a bracket that begins at a zero of the gap, which rises there: so close to that, bisection is safer
# Of a squared step: the last change of an instant times the next one, which is then not solved for
LOCATED_INSTANT = 1e-15


class LocatedScheme(NamedTuple):
    """Both sides, the contact law, and the time grid."""

    separated: Side
    pressed: Side
    forcing: tuple  # f₁ and f as factors of cos ητ and sin ητ, and constants: (2, 3)
    clearance: float
    wall: float  # 1 if body 1 is a wall, else 0
    law: ContactLaw
    eta: float
    frequency: float  # 1/T
    h: float  # T/n
    steps: int  # n
    shortest_step: float  # Δτ T_c/T_f, the step with which a contact begins (see located.py)
    step_per_age: float  # 2Δτ/T_f, by how much the next ones grow with the time since then
    load: np.ndarray  # (5,) 1 of a load that is linear between steps, f₁ and f at the step, their slopes; else zeros
    sign: float  # as in ..parameters
    reach: float  # gap beyond which steps are seen from another stop, else LIMIT of .newmark
    stages: Stages  # none of Newmark's own step above, which takes the contact of spring and damper alone


STAGES = Layout(Stages, reaction=(2,), numbers=(2, STAGE_NUMBERS))
SIDE, LAW = Layout(Side), Layout(ContactLaw)
SCHEME = Layout(LocatedScheme, separated=SIDE, pressed=SIDE, forcing=(2, 3), law=LAW, load=(5,), stages=STAGES)
unpack_scheme = SCHEME.unpack


@jit_inlined
def side(m, pressed):
    """The equations of a side."""
    return m.pressed if pressed else m.separated


@jit_inlined
def step(e, z, s, forcing):
    """The motion after Newmark's step of length ``s`` on one side of the surface; ``forcing``: f₁ and f at its end."""
    k = unforced_end(e, False, (0.0, 0.0), AVERAGE_ACCELERATION, (z, 0.0), None, s, forcing)
    return end_with(k, k.a, k.b)


@jit_inlined
def forcing_at(m, at):
    """f₁ and f at an instant: a step of the period, and the time after it."""
    k, s = at
    if m.load[0] > 0.0:
        return m.load[1] + s * m.load[3], m.load[2] + s * m.load[4]
    cosine, sine = cos_sin((k * m.h + s) * m.frequency)
    return forcing_with(m.forcing, cosine, sine)


@jit_inlined
def begin_load_of_step(m, forces, k):
    """Set the load of step k, if it is one that is linear between steps."""
    if m.load[0] > 0.0:
        for i in range(2):
            m.load[1 + i], m.load[3 + i] = forces[k, i], (forces[k + 1, i] - forces[k, i]) / m.h


@jit_inlined
def force_of(m, gain, pressed, z):
    """λ of a motion."""
    if m.law.kind == KELVIN_VOIGT:  # of most runs, without a call
        return -m.law.stiffness * z[3] - gain * z[4] if pressed else 0.0
    return law_force(m.law, gain, -z[3], -z[4]) if pressed else 0.0


@jit_no_alloc
def with_contact_accelerations(m, gain, pressed, z, forcing):
    """The motion with a and b from the equations of motion with the force of the law; ``forcing``: f₁ and f."""
    t, push = m.stages, force_of(m, gain, pressed, z)
    x, v, a, g, u, b = with_accelerations(m.separated, z, forcing)
    return x, v, a + t.reaction[0] * push, g, u, b + t.reaction[1] * push


@jit_inlined
def stage_end(m, numbers, gain, pressed, start, former, s, at):
    """The motion at the end of a stage with the force of the law.

    ``gain``: c, or h of Eq. (18), of the open contact; ``at``: the beginning of the step, as in :func:`forcing_at`; the
    others as of :func:`.stage.unforced_end`.
    """
    (k, offset), t, end, alpha_f = at, m.stages, numbers[0], numbers[ALPHA_F]
    if t.averaged:
        ended, started = forcing_at(m, (k, offset + s * end)), forcing_at(m, at)
        forcing = between(alpha_f, ended[0], started[0]), between(alpha_f, ended[1], started[1])
    else:
        forcing = forcing_at(m, (k, offset + s * end * (1.0 - alpha_f)))
    known = unforced_end(m.separated, t.averaged, t.reaction, numbers, start, former, s, forcing)
    if not pressed:
        return end_with(known, known.a, known.b)
    return end_with_force(known, solve_force(m.law, gain, *known.point))


@jit_no_alloc
def step_of_stages(m, gain, pressed, z, s, at):
    """The motion after a step of length ``s`` that begins ``at`` an instant as in :func:`forcing_at`."""
    t = m.stages
    start = z, force_of(m, gain, pressed and t.averaged, z)
    end = stage_end(m, t.numbers[0], gain, pressed, start, None, s, at)
    return stage_end(m, t.numbers[1], gain, pressed, start, end, s, at) if t.count > 1 else end


@jit_inlined
def step_from(m, gain, pressed, z, s, at):
    """The same, by Newmark's own step where the scheme has no stages."""
    if m.stages.count > 0:
        return step_of_stages(m, gain, pressed, z, s, at)
    return step(side(m, pressed), z, s, forcing_at(m, (at[0], at[1] + s)))


@jit_inlined
def vertex_within(gap, rate, curvature, length):
    """When within a step a parabola that begins with a positive gap is lowest, at zero or below; else 0."""
    approaches = gap > 0.0 and rate < 0.0 and -rate < curvature * length
    return -rate / curvature if approaches and 2.0 * gap * curvature <= rate * rate else 0.0


@jit_inlined
def cubic_of(value, rate, last, last_rate, length):
    """The factors of t² and t³ of a cubic over t = τ/length, from its values and its rates in τ at both ends."""
    mean = (last - value) / length
    return 3.0 * mean - 2.0 * rate - last_rate, rate + last_rate - 2.0 * mean


@jit_inlined
def falling_root(value, rate, square, cube, length):
    """Where a cubic with these factors over t = τ/length falls to zero, or a time outside the step."""
    at = 1.0
    for _ in range(CUBIC_NEWTON):
        slope = rate + at * (2.0 * square + 3.0 * cube * at)
        if not slope < 0.0:
            return -length
        at -= (value / length + at * (rate + at * (square + at * cube))) / slope
    return at * length


@jit_inlined
def root_of_cubic(value, rate, last, last_rate, length):
    """Where the cubic with these values and rates at both ends of a step falls to zero, or a time outside the step."""
    square, cube = cubic_of(value, rate, last, last_rate, length)
    return falling_root(value, rate, square, cube, length)


@jit_inlined
def root_by_curvature(gap, rate, curvature, last, length):
    """The same of a gap, from its rate and its second derivative at the beginning, and from its value at both ends.

    At the end of a step the derivative of the gap over the length of the step is not the rate there: it differs by
    terms of second order, which the cubic through the rates would be wrong by.
    """
    square = 0.5 * curvature * length
    return falling_root(gap, rate, square, (last - gap) / length - rate - square, length)


@jit_inlined
def next_root(value, rate, last, length, at, here):
    """The zero next to ``at`` of the cubic with a value and a rate at the beginning and values ``here`` and at the end.

    Beyond the step where it does not fall at ``at``.
    """
    left, right = 1.0 / at, 1.0 / (at - length)
    chord, mean = (here - value) * left, (last - value) / length
    curve = (chord - rate) * left  # divided differences: of 0, 0, at
    cube = (curve - (mean - rate) / length) * right  # … and of the end
    to_end = (here - last) * right
    curve = (to_end - mean) * left  # of 0, at, the end
    slope = to_end + (curve + cube * at) * (at - length)
    if not slope < 0.0:
        return -length
    change = -here / slope
    return at - here / (slope + (curve + cube * (2.0 * at - length)) * change)


@jit_inlined
def has_converged(passed, next_change, length):
    """Whether secants have converged within a step of a length, by their last change of an instant and the next one.

    A parabola through the motions at the end of the step and at the last two instants then gives the motion at the
    next one (:func:`motion_between`): it is wrong by both changes times a sixth of a third derivative.
    """
    return abs(passed * next_change) <= LOCATED_INSTANT * (length * length) and abs(next_change) <= 0.5 * abs(passed)


@jit_inlined
def motion_between(end, length, before, earlier, there, at, instant):
    """The motion at an instant, on the parabola through those at ``length``, ``earlier`` and ``at``."""
    share = (instant - at) / (earlier - at)
    weight = share * (instant - length) / (earlier - length)  # of ``before``
    other = (share - weight) * (earlier - at) / (length - at)  # of ``end``
    own = 1.0 - weight - other
    return (
        own * there[0] + (weight * before[0] + other * end[0]),
        own * there[1] + (weight * before[1] + other * end[1]),
        own * there[2] + (weight * before[2] + other * end[2]),
        own * there[3] + (weight * before[3] + other * end[3]),
        own * there[4] + (weight * before[4] + other * end[4]),
        own * there[5] + (weight * before[5] + other * end[5]),
    )
