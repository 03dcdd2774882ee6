"""Output of steps that are skipped: motion, contact force and impulse, read off tables (:mod:`.step_map`).

Every step is one entry of each level away from where the skip begins, so no step is taken.
"""

from vibroscope.engine.kernels.accelerated.certificate import steps_of
from vibroscope.engine.kernels.accelerated.step_map import ENTRIES, PRESSED
from vibroscope.engine.kernels.compile.options import jit_inlined, jit_no_alloc
from vibroscope.engine.kernels.linear.cos_sin import cos_sin
from vibroscope.engine.kernels.linear.tables import apply_transition, dot
from vibroscope.engine.kernels.time_stepping.newmark import displaced, force_at, write_sample


@jit_inlined
def state_after_strides(t, pressed, z, coarse, middle):
    """z after so many entries of the two levels above single steps, all with the same contact state."""
    return apply_transition(t.matrices[pressed, 1], apply_transition(t.matrices[pressed, 2], z, coarse), middle)


@jit_inlined
def split(steps, stride):
    """Whole strides in so many steps, at most as many as the table has, and the steps that are left."""
    strides = min(steps // stride, ENTRIES) if stride > 0 else 0
    return strides, steps - strides * stride


@jit_inlined
def entries_of(p, pressed, steps):
    """Entries of each level, from the coarsest on, that so many steps of a skip are."""
    strides = p.tables.strides
    coarse, rest = split(steps, int(strides[pressed, 2]))
    middle, fine = split(rest, int(strides[pressed, 1]))
    return coarse, middle, fine


@jit_inlined
def motion_at(p, pressed, z, fine, k):
    """(ξ₁, ξ₁′, ξ₂, ξ₂′) at the end of the step that follows ``fine`` single steps after z, k steps into a period."""
    h = p.scheme.h
    c, s = cos_sin(k / p.steps)
    z = (*apply_transition(p.tables.matrices[pressed, 0], z, fine)[:4], c, s)  # before the step
    rows = p.tables.accelerations[pressed]
    a1, a2 = dot(rows[0], z), dot(rows[1], z)
    x, gap = p.tables.origins[pressed, 0], p.tables.origins[pressed, 1]
    p1, q1, p2, q2 = z[0], z[1], z[0] + z[2], z[1] + z[3]
    return displaced(
        p.scheme,
        p1 + 0.25 * a1 + x,
        (q1 + 0.5 * a1) / h,
        p2 + 0.25 * a2 + (x + gap),
        (q2 + 0.5 * a2) / h,
    )


@jit_no_alloc
def motion_after(p, pressed, z, i, t):
    """(ξ₁, ξ₁′, ξ₂, ξ₂′) at the end of step t, from z after step i < t."""
    coarse, middle, fine = entries_of(p, pressed, t - 1 - i)
    return motion_at(p, pressed, state_after_strides(p.tables, pressed, z, coarse, middle), fine, (t - 1) % p.steps)


@jit_inlined
def next_entries(p, pressed, entries, steps):
    """The result of :func:`entries_of` so many steps later, without a division: one takes as long as a motion."""
    middle_stride, coarse_stride = int(p.tables.strides[pressed, 1]), int(p.tables.strides[pressed, 2])
    coarse, middle, fine = entries
    fine += steps
    while 0 < middle_stride <= fine and middle < ENTRIES:
        fine, middle = fine - middle_stride, middle + 1
        # a coarse stride is a whole number of the middle ones
        if middle * middle_stride == coarse_stride and coarse < ENTRIES:
            middle, coarse = 0, coarse + 1
    return coarse, middle, fine


@jit_inlined
def impulse_of(t, z, skip):
    """Δτ Σλ over the steps of a skip in contact."""
    total = t.origins[PRESSED, 2] * steps_of(t, PRESSED, skip)
    total += dot(t.impulses[2, skip.coarse - 1], z) if skip.coarse > 0 else 0.0
    z = apply_transition(t.matrices[PRESSED, 2], z, skip.coarse)
    total += dot(t.impulses[1, skip.middle - 1], z) if skip.middle > 0 else 0.0
    z = apply_transition(t.matrices[PRESSED, 1], z, skip.middle)
    return total + (dot(t.impulses[0, skip.fine - 1], z) if skip.fine > 0 else 0.0)


@jit_no_alloc
def write_skipped(p, pressed, z, i, end, change, window, buffers):
    """Write the section rows and samples of the steps i + 1 … end; ``change``: the step that changes contact, or −1."""
    n = p.steps
    kept_from, sampled_from, stride = window
    t = (max(i, kept_from) // n + 1) * n
    while t <= end:
        row = buffers.section[(t - kept_from) // n - 1]
        row[0], row[1], row[2], row[3] = motion_after(p, pressed, z, i, t)
        t += n
    if buffers.samples.shape[0] == 0:
        return
    t = max(i + 1, sampled_from)
    late = (t % n) % stride
    if late > 0:
        t += min(stride - late, n - t % n)
    k, j = t % n, (t - sampled_from) // n * buffers.phases.shape[0] + (t % n) // stride
    entries = entries_of(p, pressed, t - 1 - i)
    coarse, middle = entries[0], entries[1]
    before = state_after_strides(p.tables, pressed, z, coarse, middle)
    while t <= end and j < buffers.samples.shape[0]:  # from sample to sample without a division
        if entries[0] != coarse or entries[1] != middle:  # most samples lie within the stride of the one before
            coarse, middle = entries[0], entries[1]
            before = state_after_strides(p.tables, pressed, z, coarse, middle)
        now = motion_at(p, pressed, before, entries[2], k - 1 if k > 0 else n - 1)
        write_sample(buffers.samples[j], now, force_at(p.scheme, now, (pressed == PRESSED) != (t == change)))
        ahead = min(stride, n - k)
        t, k, j = t + ahead, k + ahead if k + ahead < n else 0, j + 1
        entries = next_entries(p, pressed, entries, ahead)
