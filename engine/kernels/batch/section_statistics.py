"""What each period leaves behind of a run, and what the periods of a sample make together.

A log has a row for each period: where the section is at its end, and what its events add up to. A motion that repeats
itself after a cycle repeats its rows, so that a cycle tells what the log of the whole sample would be.

Instants are counted in periods, their *share*: a share of 7.25 lies a quarter through the eighth period. An event on
the section belongs to the period that ends there.
"""

import math

from ..compile.options import bare

# columns of a log: ξ₁, ξ₁′, ξ₂, ξ₂′ at the end of the period; impacts and contacts that begin in it; its share in
# contact; the longest contact in it, as long as it has lasted by its end; its first impact, if there is one
SECTION, IMPACTS, BEGUN, CONTACT, LONGEST, FIRST, COLUMNS = 0, 4, 5, 6, 7, 8, 9
# what a description holds
PERIOD, NEAR, RATE, CONTACTS, SHARE, SPREAD, SCATTER, LASTING, PHASE, NUMBERS = range(10)


@bare
def clear(log, rows):
    """Empty the first rows of a log."""
    for j in range(rows):
        for k in range(COLUMNS):
            log[j, k] = 0.0
        log[j, FIRST] = math.nan


@bare
def shared(time, period, steps):
    """An instant τ in periods; with steps, one of them."""
    share = time / period
    return math.floor(share * steps + 0.5) / steps if steps > 0.0 else share


@bare
def note_events(log, rows, origin, period, steps, record):
    """Add the impacts and contacts of a record to a log whose first row is period ``origin``, and empty the record."""
    for i in range(record.used[0]):
        share = shared(record.impacts[i, 0], period, steps)
        j = min(max(math.ceil(share) - 1 - origin, 0), rows - 1)
        log[j, IMPACTS] += 1.0
        if not log[j, FIRST] <= share - math.floor(share):
            log[j, FIRST] = share - math.floor(share)
    for i in range(record.used[1]):
        begin, end = shared(record.contacts[i, 0], period, steps), shared(record.contacts[i, 1], period, steps)
        if not end > begin:
            continue
        if begin > origin:
            log[min(math.ceil(begin) - 1 - origin, rows - 1), BEGUN] += 1.0
        for j in range(max(int(begin) - origin, 0), min(math.ceil(end) - origin, rows)):
            until = min(end, origin + j + 1.0)
            log[j, CONTACT] += until - max(begin, origin + j + 0.0)
            log[j, LONGEST] = max(log[j, LONGEST], until - begin)
    record.used[0] = record.used[1] = 0


@bare
def repeat(log, rows, first, cycle, length, origin):
    """Fill a log that begins with period ``first`` from that of one cycle, which begins with period ``origin``.

    No contact outlasts every cycle: pendulums that never part would swing about zero, and with them the force.
    """
    for j in range(rows):
        k = (first + j - origin) % length
        for c in range(COLUMNS):
            log[j, c] = cycle[k, c]


@bare
def apart(log, i, j):
    """Largest difference of the sections of two rows."""
    most = 0.0
    for c in range(4):
        most = max(most, abs(log[i, c] - log[j, c]))
    return most


@bare
def size_of(log, rows):
    """Largest coordinate of the section."""
    most = 0.0
    for j in range(rows):
        for c in range(4):
            most = max(most, abs(log[j, c]))
    return most


@bare
def repeats_after(log, rows, allowed):
    """As :func:`...motions.section.repeats_after`."""
    for p in range(1, rows // 2 + 1):
        i = 0
        while i + p < rows and apart(log, i, i + p) <= allowed:
            i += 1
        if i + p == rows:
            return p
    return 0


@bare
def nearly_repeats_after(log, rows, allowed, most):
    """As :func:`...motions.section.nearly_repeats_after`."""
    for p in range(1, min(most, rows // 2) + 1):
        total = 0.0
        for i in range(rows - p):
            for c in range(4):
                total += (log[i + p, c] - log[i, c]) ** 2
        if math.sqrt(total / (4 * (rows - p))) <= allowed:
            return p
    return 0


@bare
def variance(log, begin, rows, stride):
    """Variance of ξ₂ over every stride-th row from ``begin`` on."""
    count, mean, total = 0, 0.0, 0.0
    for j in range(begin, rows, stride):
        count += 1
        mean += log[j, SECTION + 2]
    mean /= count
    for j in range(begin, rows, stride):
        total += (log[j, SECTION + 2] - mean) ** 2
    return total / count


@bare
def describe(log, rows, tolerance, scatter, most_nearly, out):
    """Write what the rows of a log tell to ``out``, (NUMBERS,), as :func:`...motions.description.describe` has it.

    Rates are those of whole cycles, the last ones. The longest contact is in periods.
    """
    size = size_of(log, rows)
    period = repeats_after(log, rows, tolerance * max(size, 1e-12))
    near = period if period > 0 else nearly_repeats_after(log, rows, scatter * size, most_nearly)
    stride = max(near, 1)
    cycles = rows // stride * stride
    impacts, begun, contact, lasting = 0.0, 0.0, 0.0, 0.0
    for j in range(rows):
        lasting = max(lasting, log[j, LONGEST])
        if j >= rows - cycles:
            impacts += log[j, IMPACTS]
            begun += log[j, BEGUN]
            contact += log[j, CONTACT]
    scattered = 0.0
    for j in range(stride):
        scattered += variance(log, rows - cycles + j, rows, stride) / stride
    j = rows - stride
    while j < rows - 1 and math.isnan(log[j, FIRST]):
        j += 1
    out[PERIOD], out[NEAR] = period, near
    out[RATE], out[CONTACTS], out[SHARE] = impacts / cycles, begun / cycles, contact / cycles
    out[SPREAD], out[SCATTER] = math.sqrt(variance(log, 0, rows, 1)), math.sqrt(scattered)
    out[LASTING], out[PHASE] = lasting, log[j, FIRST]


@bare
def copy_rows(log, rows, section):
    """Copy the sections that a kernel has written into a log."""
    for j in range(rows):
        for c in range(4):
            log[j, SECTION + c] = section[j, c]
