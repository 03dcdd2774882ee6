"""Newmark's method with its step cut at each contact change, located within the step (α = ½, β = ¼).

**Unknowns.** ξ₁ with its speed and acceleration (x, v, a), and the gap with its own (g, u, b): subtracting ξ₁ from ξ₂
would lose the digits that a stiff contact needs. With c₁ = 2d₁, k₁ = 1, c₂ = 2d₂κ, k₂ = κ² MODEL.md's equations read

    a = η² cos ητ − c₁v − k₁x + Kg + 2Du
    b = −(c₂ − c₁)v − (k₂ − k₁)x − (c₂ + 2D(1 + 1/μ))u − (k₂ + K(1 + 1/μ))g

in contact, and with K = D = 0 in flight. A step of any length s is Newmark's: a and b at its end solve these two
equations there, with x = p + s²a/4, v = q + sa/2, from the predictors p = x + sv + s²a/4, q = v + sa/2, and g and u
likewise.

**Where contact changes.** A step of length θ is itself such a step, so the gap g(θ) it lands on is a known function. If
the side of the gap at its end is not that at its start, a bracketed secant iteration finds the θ at which g(θ) = 0. A
gap that changes twice within a step is on the same side at both ends; it shows in the motion between them, which is
Newmark's own: constant acceleration (b₀ + b₁)/2, a parabola. Where its vertex lies beyond the surface, the step that
ends at the vertex decides. At the change displacement and speed go on, the acceleration starts anew from the equations
of the other side, and what is left of the grid's step comes next. So states lie on the grid, whatever happens between.

**How finely a contact is resolved.** Landing on the changes is not enough if a contact then lasts two steps: average
acceleration gives its restitution only where it resolves the relative motion, of fastest rate r = ω_c for ζ ≤ 1, else
ω_c (ζ + √(ζ² − 1)). On the grid, the fastest of what moves without contact, T_f = 2π/max(1, κ, η), gets T_f/Δτ steps to
the cycle. A contact begins with as many to its own cycle T_c = 2π/r. After half a cycle it was no impact; what the
landing excited dies away, and the step s grows with the time t since the landing, so that every scale of time gets the
same number of steps:

    s = Δτ · min(1, max(T_c, 2t) / T_f).

Every step is then proportional to Δτ and the method of second order throughout. With N = T_f/Δτ an impact costs N/2
solves and some four to locate each change, a contact of duration t > T_c/2 costs N/2 (1 + ln(2t/T_c)), however stiff it
is. (In an FE code a step of another length is another factorisation too.)
"""

import math
from typing import NamedTuple

from .jit import jit
from .record import no_room

# slots of the state: the motion, the side, where in time (steps done, offset within the next), solves, solves when that
# step began; then the contact that is open, from the time since it began
X, V, A, G, U, B, CONTACT, STEP, OFFSET, SOLVES, BEFORE, SINCE = range(12)
BEGIN, CLOSING, POSITION, SPEED1, SPEED2, IMPULSE, SLOTS = range(12, 19)
# how a march ends
DONE, PAUSED, DIVERGED, CROWDED = range(4)
LIMIT = 1e9  # a gap of 1e9 base amplitudes is no motion; short of overflow, so that no NaN is ever made
SOLVES_PER_STEP = 10_000_000  # some tenths of a second within one step: contacts too short for this excitation period
PRECISION = 1e-14  # of an instant of change, as a share of its step: rounding of the gap leaves little more
ITERATIONS = 100  # three or four are needed, by bisection half of these


class Law(NamedTuple):
    """Coefficients of the equations, and the time grid; 1 and 2: the pendulums."""

    load: float  # η²
    damping1: float  # c₁
    stiffness1: float  # k₁
    damping2: float  # c₂
    stiffness2: float  # k₂
    both: float  # 1 + 1/μ
    stiffness: float  # K
    damper: float  # D
    eta: float
    h: float  # T/n
    steps: int  # n
    first: float  # Δτ T_c/T_f, the step with which a contact begins
    growth: float  # 2Δτ/T_f, the later ones per time since the landing


@jit
def squeezing(m, contact):
    """K and D as they act."""
    return (m.stiffness, m.damper) if contact else (0.0, 0.0)


@jit
def accelerations(m, contact, z, cosine):
    """The motion with a and b from the equations of a side."""
    x, v, _, g, u, _ = z
    k, d = squeezing(m, contact)
    a = m.load * cosine - m.damping1 * v - m.stiffness1 * x + k * g + 2.0 * d * u
    b = (m.damping1 - m.damping2) * v + (m.stiffness1 - m.stiffness2) * x
    b -= (m.damping2 + 2.0 * d * m.both) * u + (m.stiffness2 + k * m.both) * g
    return x, v, a, g, u, b


@jit
def step(m, contact, z, s, cosine):
    """The motion after a step of length ``s`` on one side of the gap; ``cosine`` is cos ητ at its end."""
    x, v, a, g, u, b = z
    half, quarter = 0.5 * s, 0.25 * s * s
    p, q = x + s * v + quarter * a, v + half * a
    pg, qg = g + s * u + quarter * b, u + half * b
    # accelerations as the predictors alone would have them, and the matrix that stands before those at the end
    _, _, a, _, _, b = accelerations(m, contact, (p, q, 0.0, pg, qg, 0.0), cosine)
    k, d = squeezing(m, contact)
    m11 = 1.0 + half * m.damping1 + quarter * m.stiffness1
    m12 = -(2.0 * half * d + quarter * k)
    m21 = half * (m.damping2 - m.damping1) + quarter * (m.stiffness2 - m.stiffness1)
    m22 = 1.0 + half * (m.damping2 + 2.0 * d * m.both) + quarter * (m.stiffness2 + k * m.both)
    over = 1.0 / (m11 * m22 - m12 * m21)
    a, b = (m22 * a - m12 * b) * over, (m11 * b - m21 * a) * over
    return p + quarter * a, q + half * a, a, pg + quarter * b, qg + half * b, b


@jit
def cosine_at(m, k, s):
    """Cos ητ at the offset s beyond step k of a period."""
    return math.cos(m.eta * (k * m.h + s))


@jit
def change_within(m, contact, z, end, length, k, s):
    """Where contact changes within a step, the motion there, and the solves that it took to find it.

    ``z`` and ``end`` are the motions at the start of the step, s beyond step k of the period, and ``length`` later. inf
    stands for a step without change.
    """
    side = -1.0 if contact else 1.0
    gap, speed = side * z[3], side * z[4]
    solves, reach, there = 0, length, end
    if (end[3] <= 0.0) == contact:
        bend = 0.5 * side * (z[5] + end[5])
        if not (gap > 0.0 and speed < 0.0 and -speed < bend * length and 2.0 * gap * bend <= speed * speed):
            return math.inf, end, 0
        reach, solves = -speed / bend, 1
        there = step(m, contact, z, reach, cosine_at(m, k, s + reach))
        if (there[3] <= 0.0) == contact:
            return math.inf, end, 1
    elif gap <= 0.0 and speed <= 0.0:
        # begun on the surface and not moving away from it: no first instant of change but the start
        return length, end, 0
    low, high, theta, slope = 0.0, reach, reach, there[4]  # the speed: g′(θ) but for terms of second order
    for i in range(ITERATIONS):
        if (there[3] <= 0.0) == contact:
            low = theta
        else:
            high = theta
        better = theta - there[3] / slope if slope != 0.0 else low
        if min(abs(better - theta), high - low) <= PRECISION * reach:
            break
        if not low < better < high or i % 8 == 7:
            better = 0.5 * (low + high)
        before, passed = there[3], better - theta
        there = step(m, contact, z, better, cosine_at(m, k, s + better))
        theta, slope, solves = better, (there[3] - before) / passed, solves + 1
    return theta, (there[0], there[1], there[2], 0.0, there[4], there[5]), solves


@jit
def force_of(m, contact, z):
    """Contact force λ by its definition."""
    k, d = squeezing(m, contact)
    return -k * z[3] - 2.0 * d * z[4]


@jit
def open_contact(state, now, z, kept):
    """Remember that, and how, a contact begins at τ = ``now``; an impact is asked for in the kept periods alone."""
    state[BEGIN], state[SINCE], state[CLOSING] = now, 0.0, (-z[4] if kept else 0.0)
    state[POSITION], state[SPEED1], state[SPEED2], state[IMPULSE] = z[0], z[1], z[1] + z[4], 0.0


@jit
def close_contact(state, now, z, record):
    """Note the contact that ends at τ = ``now``, and its impact if it began with a closing speed."""
    row = record.contacts[record.used[1]]
    row[0], row[1] = state[BEGIN], now
    record.used[1] += 1
    if state[CLOSING] > 0.0:
        impact = record.impacts[record.used[0]]
        impact[0], impact[1] = row[0], state[POSITION]
        impact[2], impact[3], impact[4], impact[5] = state[SPEED1], state[SPEED2], z[1], z[1] + z[4]
        impact[6], impact[7] = state[IMPULSE], state[CLOSING]
        record.used[0] += 1


@jit
def write(row, z):
    """The motion in the order of a Response: ξ₁, ξ₁′, ξ₂, ξ₂′."""
    row[0], row[1], row[2], row[3] = z[0], z[1], z[0] + z[3], z[1] + z[4]


@jit
def arrive(m, i, k, z, contact, window, record):
    """Record the motion at step i, the k-th of its period, where it is asked for."""
    section, samples = record.section, record.samples
    if k == 0 and i > window[0] and section.shape[0] > 0:
        write(section[(i - window[0]) // m.steps - 1], z)
    if i >= window[1] and samples.shape[0] > 0 and k % window[2] == 0:
        j = (i - window[1]) // m.steps * record.phases.shape[0] + k // window[2]
        if j < samples.shape[0]:
            write(samples[j], z)
            samples[j, 4] = force_of(m, contact, z)


@jit
def change(m, state, z, contact, k, record):
    """Note a change to the side ``contact`` here, and give the motion on that side."""
    kept, now = record.contacts.shape[0] > 0, state[STEP] * m.h + state[OFFSET]
    if contact:
        open_contact(state, now, z, kept)
    elif kept:
        close_contact(state, now, z, record)
    return accelerations(m, contact, z, cosine_at(m, k, state[OFFSET]))


@jit
def motion_of(state):
    """The motion as it stands."""
    return state[X], state[V], state[A], state[G], state[U], state[B]


@jit
def piece(m, contact, since, left):
    """Into how many pieces what is ``left`` of a step is to be cut as things stand, and their length."""
    longest = min(m.h, max(m.first, m.growth * since)) if contact else m.h
    # a contact from a step of the grid on gives whole ratios, which rounding must not decide
    pieces = math.ceil(left / longest - 1e-6) if left > longest else 1
    return pieces, left / pieces


@jit
def march(m, cosines, state, stop, most, window, record):
    """Run to the end of step ``stop``.

    Parameters
    ----------
    m : Law
    cosines : (n + 1,) float64
        cos ητ at the steps of one period.
    state : (SLOTS,) float64
        Changed in place.
    stop : int
    most : int
        Solves after which to pause, so that a run can be withdrawn.
    window : (3,) int64
        The step at which the kept periods begin, the step at which sampling begins, and the steps from sample to
        sample, counted anew in each period.
    record : Record
        Without rows for sections and contacts outside the kept periods.

    Returns
    -------
    int
        DONE; PAUSED to be called again, after ``most`` solves or for want of room; DIVERGED; CROWDED if a step took
        more than SOLVES_PER_STEP solves.
    """
    z, contact, status = motion_of(state), state[CONTACT] > 0.0, DONE
    i, s, since, impulse = int(state[STEP]), state[OFFSET], state[SINCE], state[IMPULSE]
    solves, before = int(state[SOLVES]), int(state[BEFORE])
    pause, k = solves + most, i % m.steps
    if s == 0.0:
        arrive(m, i, k, z, contact, window, record)
    while i < stop and status == DONE:
        pieces, length = piece(m, contact, since, m.h - s)
        end = step(m, contact, z, length, cosines[k + 1] if pieces == 1 else cosine_at(m, k, s + length))
        theta, there, more = change_within(m, contact, z, end, length, k, s)
        changed = theta < math.inf
        if changed:
            length, end = theta, there
        if contact:
            since += length
            impulse += 0.5 * length * (force_of(m, contact, z) + force_of(m, contact, end))
        solves += 1 + more
        s += length
        z = end
        if changed:
            contact = not contact
            state[STEP], state[OFFSET], state[IMPULSE] = i, s, impulse
            z = change(m, state, z, contact, k, record)
            since, impulse = 0.0, 0.0
            if no_room(record):
                status = PAUSED
        elif pieces == 1:
            i, s, before = i + 1, 0.0, solves
            k = k + 1 if k + 1 < m.steps else 0
            if k == 0 or i >= window[1]:
                arrive(m, i, k, z, contact, window, record)
            if solves > pause and i < stop:
                status = PAUSED
        if not abs(z[3]) < LIMIT:
            status = DIVERGED
        elif solves - before > SOLVES_PER_STEP:
            status = CROWDED
    state[X], state[V], state[A], state[G], state[U], state[B] = z
    state[CONTACT], state[STEP], state[OFFSET], state[SOLVES] = (1.0 if contact else 0.0), i, s, solves
    state[BEFORE], state[SINCE], state[IMPULSE] = before, since, impulse
    return status
