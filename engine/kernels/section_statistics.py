"""What the Poincaré section and the events of some periods say of a motion: periods, rates, scatter.

A *period log* has a row for each period: the section at its end, and what its events add up to. A motion that repeats
itself after a cycle repeats its rows, so the log of one cycle gives the log of any number of periods.

Instants are counted in periods, as *shares*: a share of 7.25 lies a quarter through the eighth period. An event on the
section belongs to the period that ends there.
"""

import math

from vibroscope.engine.kernels.compile.options import jit_no_alloc

# Columns of a log: ξ₁, ξ₁′, ξ₂, ξ₂′ at the end of the period; impacts and contacts that begin in it; its share in
# contact; the longest contact in it, as long as it has lasted by its end; its first impact, nan if there is none
SECTION, IMPACTS, CONTACTS_BEGUN, CONTACT_SHARE, LONGEST_CONTACT, FIRST_IMPACT, COLUMNS = 0, 4, 5, 6, 7, 8, 9
# what a description holds
(
    PERIOD,
    NEAR_PERIOD,
    IMPACTS_PER_PERIOD,
    CONTACTS_PER_PERIOD,
    SHARE_IN_CONTACT,
    SPREAD,
    SCATTER,
    LONGEST,
    IMPACT_PHASE,
    NUMBERS,
) = range(10)

TOLERANCE = 1e-5  # of the section's size: points that differ by less count as the same
# A constant step mislocates every contact change, so a penalty section is rarely a point: what recurs within this
# share of its size (root mean square) nearly repeats. Only short cycles are worth the name.
NEAR_TOLERANCE = 0.03
LONGEST_NEAR_PERIOD = 4
# Units of length, each the base amplitude, or else what the forces displace, or else the clearance: a smaller section,
# of a motion that has died out or of bodies that move as one, counts as one of this size. Points that differ by less
# than 1e-10 of a unit are the same: what rounding leaves after thousands of periods.
LEAST_SECTION = 1e-5
MOST_STILL = 10.0  # units of length: bodies that stand still at the section are taken to move by so much at most


@jit_no_alloc
def clear(log, rows):
    """Empty the first rows of a log."""
    for j in range(rows):
        for k in range(COLUMNS):
            log[j, k] = 0.0
        log[j, FIRST_IMPACT] = math.nan


@jit_no_alloc
def share_of(time, period, steps):
    """An instant τ in periods; with steps, at one of them."""
    share = time / period
    return math.floor(share * steps + 0.5) / steps if steps > 0.0 else share


@jit_no_alloc
def add_events(log, rows, grid, impacts, contacts):
    """Add events to a log.

    Parameters
    ----------
    log : (rows, COLUMNS) float64
    grid : (int, float, float)
        Periods before the first row; T; steps per period to which instants are rounded, 0 for none.
    impacts : (n,) float64
        Their instants.
    contacts : (m, 2) float64
        Their beginnings and ends.
    """
    origin, period, steps = grid
    for i in range(impacts.shape[0]):
        share = share_of(impacts[i], period, steps)
        j = min(max(math.ceil(share) - 1 - origin, 0), rows - 1)
        log[j, IMPACTS] += 1.0
        if not log[j, FIRST_IMPACT] <= share - math.floor(share):
            log[j, FIRST_IMPACT] = share - math.floor(share)
    for i in range(contacts.shape[0]):
        begin, end = share_of(contacts[i, 0], period, steps), share_of(contacts[i, 1], period, steps)
        if not end > begin:
            continue
        if begin > origin:
            log[min(math.ceil(begin) - 1 - origin, rows - 1), CONTACTS_BEGUN] += 1.0
        for j in range(max(int(begin) - origin, 0), min(math.ceil(end) - origin, rows)):
            until = min(end, origin + j + 1.0)
            log[j, CONTACT_SHARE] += until - max(begin, origin + j + 0.0)
            log[j, LONGEST_CONTACT] = max(log[j, LONGEST_CONTACT], until - begin)


@jit_no_alloc
def repeat_cycle(log, rows, first, cycle, length, origin):
    """Fill a log that begins with period ``first`` from that of one cycle, which begins with period ``origin``.

    A contact that lasts all through the cycle never ends, so that it grows from row to row.
    """
    whole = True
    for k in range(length):
        whole &= cycle[k, CONTACTS_BEGUN] == 0.0 and cycle[k, CONTACT_SHARE] == 1.0
    for j in range(rows):
        k = (first + j - origin) % length
        for c in range(COLUMNS):
            log[j, c] = cycle[k, c]
        if whole:
            log[j, LONGEST_CONTACT] += first + j - (origin + k)


@jit_no_alloc
def write_section(log, rows, section):
    """Write the rows of a section into a log."""
    for j in range(rows):
        for c in range(4):
            log[j, SECTION + c] = section[j, c]


# -- what a section says by itself; of a log or of a section, (n, 4) or wider ------------------------------------------


@jit_no_alloc
def size_of(section, rows):
    """Largest coordinate of the section, at least `LEAST_SECTION`.

    Where a constant force displaces the bodies by more than `MOST_STILL`, the largest speed or deviation of a
    displacement from its mean counts, if it is more: in shares of such a displacement every motion repeats itself.
    """
    whole, moving = LEAST_SECTION, MOST_STILL
    for c in range(4):
        mean = 0.0
        if c % 2 == 0:
            for j in range(rows):
                mean += section[j, c] / rows
        for j in range(rows):
            whole = max(whole, abs(section[j, c]))
            moving = max(moving, abs(section[j, c] - mean))
    return min(whole, moving)


@jit_no_alloc
def repeats(section, rows, p, allowed):
    """Whether the section repeats itself after p periods."""
    for i in range(rows - p):
        for c in range(4):
            if not abs(section[i + p, c] - section[i, c]) <= allowed:
                return False
    return True


@jit_no_alloc
def period_of(section, rows, tolerance):
    """Smallest p, at most half the rows, after which the section repeats itself; 0 if there is none."""
    allowed = tolerance * size_of(section, rows)
    for p in range(1, rows // 2 + 1):
        if repeats(section, rows, p, allowed):
            return p
    return 0


@jit_no_alloc
def fades(section, rows, p, dying):
    """Whether the largest difference between points p periods apart falls below a share from one half to the next."""
    half, first, second = (rows - p) // 2, 0.0, 0.0
    for i in range(rows - p):
        for c in range(4):
            apart = abs(section[i + p, c] - section[i, c])
            if i < half:
                first = max(first, apart)
            else:
                second = max(second, apart)
    return second < dying * first


@jit_no_alloc
def settled_period(section, rows, tolerance, dying):
    """The period of a section without those of its parts after which the difference between its points fades."""
    period = period_of(section, rows, tolerance)
    for p in range(1, period // 2 + 1):
        if period % p == 0 and fades(section, rows, p, dying):
            return p
    return period


@jit_no_alloc
def near_period_of(section, rows):
    """Smallest p ≤ LONGEST_NEAR_PERIOD after which the section repeats itself but for scatter; 0 if there is none."""
    allowed = NEAR_TOLERANCE * size_of(section, rows)
    for p in range(1, min(LONGEST_NEAR_PERIOD, rows // 2) + 1):
        total = 0.0
        for i in range(rows - p):
            for c in range(4):
                total += (section[i + p, c] - section[i, c]) ** 2
        if math.sqrt(total / (4 * (rows - p))) <= allowed:
            return p
    return 0


@jit_no_alloc
def variance(section, begin, rows, stride, column):
    """Variance of one coordinate over every stride-th row from ``begin`` on."""
    count, mean, total = 0, 0.0, 0.0
    for j in range(begin, rows, stride):
        count += 1
        mean += section[j, column]
    mean /= count
    for j in range(begin, rows, stride):
        total += (section[j, column] - mean) ** 2
    return total / count


@jit_no_alloc
def describe(log, rows, period, body, out):
    """Write the description of the rows of a log to ``out``, (NUMBERS,); ``period``: if it is known, else −1.

    Rates are those of whole cycles, the last ones. The longest contact is in periods. Scatters are those of ξᵢ of the
    ``body`` i, 1 or 2.
    """
    if period < 0:
        period = period_of(log, rows, TOLERANCE)
    near = period if period > 0 else near_period_of(log, rows)
    stride = max(near, 1)
    cycles = rows // stride * stride
    impacts, begun, contact, longest = 0.0, 0.0, 0.0, 0.0
    for j in range(rows):
        longest = max(longest, log[j, LONGEST_CONTACT])
        if j >= rows - cycles:
            impacts += log[j, IMPACTS]
            begun += log[j, CONTACTS_BEGUN]
            contact += log[j, CONTACT_SHARE]
    scattered, column = 0.0, SECTION + 2 * (body - 1)
    for j in range(stride):
        scattered += variance(log, rows - cycles + j, rows, stride, column) / stride
    j = rows - stride
    while j < rows - 1 and math.isnan(log[j, FIRST_IMPACT]):
        j += 1
    out[PERIOD], out[NEAR_PERIOD] = period, near
    out[IMPACTS_PER_PERIOD], out[CONTACTS_PER_PERIOD] = impacts / cycles, begun / cycles
    out[SHARE_IN_CONTACT] = contact / cycles
    out[SPREAD], out[SCATTER] = math.sqrt(variance(log, 0, rows, 1, column)), math.sqrt(scattered)
    out[LONGEST], out[IMPACT_PHASE] = longest, log[j, FIRST_IMPACT]


@jit_no_alloc
def write_settled_periods(sections, tolerance, dying, out):
    """Write :func:`settled_period` of each of many sections, (n, rows, 4), to ``out``, (n,)."""
    for k in range(sections.shape[0]):
        out[k] = settled_period(sections[k], sections.shape[1], tolerance, dying)


@jit_no_alloc
def write_sizes(sections, out):
    """Write :func:`size_of` of each of many sections, (n, rows, 4), to ``out``, (n,)."""
    for k in range(sections.shape[0]):
        out[k] = size_of(sections[k], sections.shape[1])


@jit_no_alloc
def describe_run(section, impacts, contacts, grid, known_period, body, log, out):
    """Describe a run from its section, (n, 4), and its events, as :func:`add_events` takes them.

    ``known_period``, ``body``: see :func:`describe`; ``log``, (n, COLUMNS): work space.
    """
    rows = section.shape[0]
    clear(log, rows)
    add_events(log, rows, grid, impacts, contacts)
    write_section(log, rows, section)
    describe(log, rows, known_period, body, out)
