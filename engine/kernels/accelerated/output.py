"""What a record asks of the steps within a leap: motion and contact force there, from tables.

Every step is an entry of each level away from where the leap begins, so none of them is walked through.
"""

from ..compile.options import bare, inlined
from ..linear.cos_sin import circle
from ..linear.tables import carried, dot
from ..time_stepping.newmark import sample
from .step_map import HELD, PRESSED


@inlined
def later(t, contact, z, coarse, middle, fine):
    """z after so many entries of each level, all of them with the same contact state."""
    z = carried(t.moves[contact, 1], carried(t.moves[contact, 2], z, coarse), middle)
    return carried(t.moves[contact, 0], z, fine)


@inlined
def split(steps, stride):
    """Whole strides in so many steps, as far as their table goes, and the steps that are left."""
    strides = min(steps // stride, HELD) if stride > 0 else 0
    return strides, steps - strides * stride


@bare
def motion_after(p, contact, z, i, t):
    """(ξ₁, ξ₁′, ξ₂, ξ₂′) at the end of step t, from z after step i < t: rows times the z before step t."""
    h, strides = p.scheme.h, p.tables.strides
    c, s = circle((t - 1) % p.steps / p.steps)
    coarse, rest = split(t - 1 - i, int(strides[contact, 2]))
    middle, fine = split(rest, int(strides[contact, 1]))
    z = (*later(p.tables, contact, z, coarse, middle, fine)[:4], c, s)
    rows = p.tables.accelerations[contact]
    a1, a2 = dot(rows[0], z), dot(rows[1], z)
    p1, q1, p2, q2 = z[0], z[1], z[0] + z[2], z[1] + z[3]
    return p1 + 0.25 * a1, (q1 + 0.5 * a1) / h, p2 + 0.25 * a2, (q2 + 0.5 * a2) / h


@inlined
def impulse_of(t, z, ahead):
    """Δτ Σλ over the steps of a leap in contact."""
    total = dot(t.sums[2, ahead.coarse - 1], z) if ahead.coarse > 0 else 0.0
    z = carried(t.moves[PRESSED, 2], z, ahead.coarse)
    total += dot(t.sums[1, ahead.middle - 1], z) if ahead.middle > 0 else 0.0
    z = carried(t.moves[PRESSED, 1], z, ahead.middle)
    return total + (dot(t.sums[0, ahead.fine - 1], z) if ahead.fine > 0 else 0.0)


@bare
def emit(p, contact, z, i, end, flip, window, record):
    """Write the section rows and samples of the steps i + 1 … end; ``flip``: the step with which contact changes."""
    n = p.steps
    t = (max(i, window[0]) // n + 1) * n
    while t <= end:
        record.section[(t - window[0]) // n - 1] = motion_after(p, contact, z, i, t)
        t += n
    t, stride = max(i + 1, window[1]), window[2]
    while t <= end and record.samples.shape[0] > 0:
        late = (t % n) % stride
        if late > 0:
            t += min(stride - late, n - t % n)
            continue
        j = (t - window[1]) // n * record.phases.shape[0] + (t % n) // stride
        if j < record.samples.shape[0]:
            sample(p.scheme, record.samples[j], motion_after(p, contact, z, i, t), contact != (t == flip))
        t += 1
