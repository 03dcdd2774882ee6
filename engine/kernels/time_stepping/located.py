"""Newmark's method with its step cut at each contact change, which :mod:`.contact_location` locates within the step.

At the change displacement and speed go on, the acceleration starts anew from the equations of the other side, and what
is left of the grid's step comes next. So states lie on the grid, whatever happens between.

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

from ..compile.options import jit
from ..compile.record import no_room
from .contact_location import accelerations, change_within, cosine_at, force_of, step

# slots of the state: the motion, the side, where in time (steps done, offset within the next), solves, solves when that
# step began; then the contact that is open, from the time since it began
X, V, A, G, U, B, CONTACT, STEP, OFFSET, SOLVES, BEFORE, SINCE = range(12)
BEGIN, CLOSING, POSITION, SPEED1, SPEED2, IMPULSE, SLOTS = range(12, 19)
# how a march ends
DONE, PAUSED, DIVERGED, CROWDED = range(4)
LIMIT = 1e9  # a gap of 1e9 base amplitudes is no motion; short of overflow, so that no NaN is ever made
SOLVES_PER_STEP = 10_000_000  # some tenths of a second within one step: contacts too short for this excitation period


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
