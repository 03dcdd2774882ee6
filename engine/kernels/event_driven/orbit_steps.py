"""Steps of Newton's method to an orbit, the tangent of a curve of orbits, and the Jacobian of its Poincaré map.

The equations of an orbit and their Jacobian are those of :mod:`.orbit`; what follows from them is
the same for both.

Newton's method to the orbit at given parameters, in one call: most orbits of a branch are found so.
"""

import numpy as np
from vibroscope.engine.kernels.compile.options import jit
from vibroscope.engine.kernels.event_driven.orbit import FACTS, FORCE, IMPACT, PARTING, SECOND, evaluate_orbit
from vibroscope.engine.kernels.linear.matrices import null_vector, relative_determinant, solve

# what margins are made of, beside the facts of an event: for sticking, and a phase's length
BEGINS, ENDS, LENGTH = range(FACTS, FACTS + 3)

NEWTON_STEPS = 10  # to an orbit at given parameters
CONVERGED = 1e-10  # scaled step of Newton's method, after which the next would be rounding
STALLED = 1e-7  # the same, where rounding prevents any smaller
ASTRAY = 1e3  # scaled step of Newton's method, after which there is no orbit nearby
GO_ON, FOUND, LOST = range(3)  # what a step of Newton's method says


@jit
def scales_of(unknowns, width):
    """Units in which distances count, (n + 1,): of states their largest, of instants the period, of α₁ ``width``."""
    n, size = unknowns.shape[0], 1e-9
    scales = np.ones(n + 1)
    for j in range(4):
        size = max(size, abs(unknowns[j]))
    scales[:4] = size
    scales[n] = width
    return scales


@jit
def step_at_value(residual, jacobian, scales, unknowns):
    """Take a step of Newton's method in the unknowns, in place; returns its largest scaled component.

    Parameters
    ----------
    residual : (n,) float64
    jacobian : (n, n) float64
    scales : (n + 1,) float64
        Units of the unknowns, and of α₁.
    unknowns : (n,) float64
    """
    n = residual.shape[0]
    matrix, step = np.empty((n, n)), np.empty((n, 1))
    for i in range(n):
        step[i, 0] = -residual[i]
        for j in range(n):
            matrix[i, j] = jacobian[i, j] * scales[j]
    return take_step(matrix, step, scales, unknowns)


@jit
def outcome_of_step(length, before):
    """GO_ON, FOUND or LOST after a step of Newton's method and the one before it, by their largest scaled components.

    The next step would be about as long as the ratio of these two, squared, is a share of the last; ``before`` is
    infinite at the first one.
    """
    if not length < ASTRAY or (length >= before and length > STALLED):
        return LOST
    following = length * (length / before) ** 2 if before < np.inf else np.inf
    return FOUND if length < CONVERGED or length >= before or following < CONVERGED else GO_ON


@jit
def step_in_plane(found, scales, plane, x, slope, step):
    """Take a step of Newton's method in X = (unknowns, α₁), in place, in the plane row·X = target.

    Parameters
    ----------
    found : tuple
        Residual (n,) and Jacobian (n, n).
    scales : (n + 1,) float64
    plane : tuple
        ``row`` (n + 1,) and ``target``.
    x : (n + 1,) float64
    slope : (n,) float64
        ∂F/∂α₁ nearby; it is corrected by what the step before missed (Broyden 1965).
    step : (n + 1, 1) float64
        The scaled step before, zero at the first one; becomes this one.

    Returns
    -------
    float
        The largest scaled component of the step; not finite if there is none.
    """
    residual, jacobian = found
    row, target = plane
    n, square = residual.shape[0], 0.0
    for j in range(n + 1):
        square += step[j, 0] * step[j, 0]
    missed = step[n, 0] / scales[n] / square if square > 0.0 else 0.0
    matrix = np.empty((n + 1, n + 1))
    off = target
    for j in range(n + 1):
        off -= row[j] * x[j]
        matrix[n, j] = row[j] * scales[j]
    for i in range(n):
        slope[i] += residual[i] * missed
        step[i, 0] = -residual[i]
        matrix[i, n] = slope[i] * scales[n]
        for j in range(n):
            matrix[i, j] = jacobian[i, j] * scales[j]
    step[n, 0] = off
    return take_step(matrix, step, scales, x)


@jit
def take_step(matrix, step, scales, x):
    """Solve for a step and add it to x, in place; returns its largest scaled component, nan if it is not finite."""
    solve(matrix, step)
    length = 0.0
    for j in range(x.shape[0]):
        if not np.isfinite(step[j, 0]):
            return np.nan
        length = max(length, abs(step[j, 0]))
    for j in range(x.shape[0]):
        x[j] += step[j, 0] * scales[j]
    return length


@jit
def tangent_of(jacobian, slope, scales):
    """The scaled vector of length one, (n + 1,), along which F does not change; nan if there is none."""
    n = slope.shape[0]
    matrix = np.empty((n, n + 1))
    for i in range(n):
        for j in range(n):
            matrix[i, j] = jacobian[i, j] * scales[j]
        matrix[i, n] = slope[i] * scales[n]
    return null_vector(matrix)


@jit
def interpolated(nodes, values, along, coordinate, s):
    """The point of a curve at s: the polynomial through known points, with their tangents (Newton, Hermite).

    Parameters
    ----------
    nodes : (k,) float64
        s of the known points, all different.
    values, along : (k, n) float64
        The points, and a vector along the tangent of each; nan where that is not known.
    coordinate : (n,) float64
        The row that gives s: a vector along the curve is scaled so that s grows by one.
    s : float
    """
    k, n = values.shape
    places, owner, table = np.empty(2 * k), np.empty(2 * k, dtype=np.int64), np.empty((2 * k, n))
    rates, known = np.empty((k, n)), 0
    for i in range(k):
        growth = 0.0
        for j in range(n):
            growth += coordinate[j] * along[i, j]
        for j in range(n):
            rates[i, j] = along[i, j] / growth
        for _ in range(2 if np.isfinite(growth) and growth != 0.0 else 1):
            places[known], owner[known] = nodes[i], i
            table[known] = values[i]
            known += 1
    for order in range(1, known):
        for i in range(known - 1, order - 1, -1):
            length = places[i] - places[i - order]
            for j in range(n):
                table[i, j] = (table[i, j] - table[i - 1, j]) / length if length != 0.0 else rates[owner[i], j]
    found = table[known - 1].copy()
    for i in range(known - 2, -1, -1):
        for j in range(n):
            found[j] = table[i, j] + (s - places[i]) * found[j]
    return found


@jit
def monodromy_of(jacobian):
    """Jacobian of the Poincaré map over the cycle, (4, 4); not finite at a grazing impact, where there is none."""
    m = jacobian.shape[0] - 4
    found = jacobian[:4, :4].copy()
    for i in range(4):
        found[i, i] += 1.0
    if m == 0:
        return found
    moved = jacobian[4:, :4].copy()
    solve(jacobian[4:, 4:].copy(), moved)
    for i in range(4):
        for j in range(4):
            for k in range(m):
                found[i, j] -= jacobian[i, 4 + k] * moved[k, j]
    return found


@jit
def doubling_indicator(jacobian):
    """The relative determinant of the Jacobian with M + 1 in place of M − 1."""
    doubled = jacobian.copy()
    for i in range(4):
        doubled[i, i] += 2.0
    return relative_determinant(doubled)


@jit
def branch_point_indicator(jacobian, slope, tangent):
    """The relative determinant of the Jacobian with its column of α₁, bordered by the tangent."""
    n = slope.shape[0]
    matrix = np.empty((n + 1, n + 1))
    matrix[:n, :n] = jacobian
    matrix[:n, n] = slope
    matrix[n] = tangent
    return relative_determinant(matrix)


@jit
def neimark_sacker_indicator(jacobian):
    """The product of 1 − mᵢmⱼ over all pairs of multipliers, scaled, with the sign of the events' determinant."""
    monodromy = monodromy_of(jacobian)
    pairs = np.empty((6, 6))
    row = 0
    for i in range(4):
        for j in range(i):
            column = 0
            for k in range(4):
                for n in range(k):
                    minor = monodromy[i, k] * monodromy[j, n] - monodromy[i, n] * monodromy[j, k]
                    pairs[row, column] = (1.0 if row == column else 0.0) - minor
                    column += 1
            row += 1
    events = 1.0
    if jacobian.shape[0] > 4:
        events = np.sign(relative_determinant(jacobian[4:, 4:].copy()))
    return events * relative_determinant(pairs)


@jit
def margin_values(facts, instants, threshold, conditions):
    """The values of margins, (n,).

    Parameters
    ----------
    facts : (m + 1, c) float64
        Of each event of an orbit, and of the end of its cycle.
    instants : (m,) float64
    threshold : float
        ε, above which an impact does not stick.
    conditions : (2, n) int64
        Of each margin the event and the column of the facts, or BEGINS, ENDS or LENGTH.
    """
    found = np.empty(conditions.shape[1])
    for i in range(found.shape[0]):
        k, column = conditions[0, i], conditions[1, i]
        if column == LENGTH:
            found[i] = instants[k] - instants[k - 1]
        elif column in (BEGINS, ENDS):
            begins = max(facts[k, PARTING] - threshold, -facts[k, FORCE])
            found[i] = begins if column == BEGINS else -begins
        else:
            found[i] = facts[k, column]
    return found


@jit
def impact_that_may_stick(kinds, before, after, threshold, begin):
    """The first impact, from event ``begin`` on, that does not stick at either of two orbits for one reason each.

    The reasons are its parting speed, above ε, and a force that does not press the bodies together; in between there
    may be neither. −1 if there is no such impact. ``before``, ``after``: facts, (m + 1, c).
    """
    for k in range(begin, kinds.shape[0]):
        if kinds[k] % SECOND != IMPACT:
            continue
        fast = before[k, PARTING] > threshold and after[k, PARTING] > threshold
        pulled = before[k, FORCE] < 0.0 and after[k, FORCE] < 0.0
        if not fast and not pulled:
            return k
    return -1


@jit
def solve_orbit(tables, problem, sequence, unknowns, width, out):
    """Move the unknowns by Newton's method, in place, to the orbit near them; False if there is none.

    ``width``: the unit of α₁; the other arguments are those of :func:`evaluate_orbit`, filled at the orbit.

    Plain twin: a step a call (tests/engine/kernels/test_orbit_newton.py).
    """
    residual, jacobian, facts, after, section = out
    scales = scales_of(unknowns, width)
    bare, before, found = (residual, jacobian, facts[:0], after, section[:0]), np.inf, GO_ON
    for _ in range(NEWTON_STEPS):
        evaluate_orbit(tables, problem, sequence, unknowns, bare)
        length = step_at_value(residual, jacobian, scales, unknowns)
        found = outcome_of_step(length, before)
        if found != GO_ON:
            break
        before = length
    if found == LOST or (found == GO_ON and not before < STALLED):
        return False
    evaluate_orbit(tables, problem, sequence, unknowns, out)
    return True
