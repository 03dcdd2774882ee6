"""Tables of one linear phase of the motion: where a state leads, and how a watched quantity varies on the way.

In flight, joined, or pressed together by a penalty contact, the state

    z = (ξ₁ − ξ₁*, ξ₁′, g − g*, g′, C, S),    C = cos ητ,  S = sin ητ,

relative to the static equilibrium ξ₁*, g* of the phase obeys z′ = A z with a constant A (:mod:`..equations.motion`).
Where the load is linear in time instead, C is its value and S its slope: then η = 0 stands for C′ = S, S′ = 0.
So z(s) = E(s) z(0) with the state-transition matrix E(s) = exp(As), and every quantity f = f* + w·z, such as the gap or
the contact force, is one row of numbers times z(0), and its value f* at the equilibrium. This holds for all dampings
and at resonance; modes and steady amplitudes, which cancel where an oscillator is hardly damped and its excitation
resonant, are never formed. (In the paper's system all equilibria are zero.)

A constant force on a body without a spring has no equilibrium in flight, nor in contact if the other body has none,
either: z′ = A z + p. Then z(s) = E(s) z(0) + b(s), b = ∫E p, and f has the share w·b(s) of its own. Both depend on the
time alone: they are a last row of the tables, and a table of offsets, which differences of two motions leave out
(:func:`unpulled`).

A block of a phase is POINTS intervals of length h. Its tables hold the rows w·E(jh) and the transitions E(jh) at the
POINTS instants s = jh, and for the interval between two instants the coefficients of f, ξ₁ and g as polynomials in
u = s/h. With |ν|h ≤ REACH for every eigenvalue ν of A, TERMS terms of the series are exact to rounding, derivatives
included. Tables and functions give ξ₁ and g relative to the equilibrium, unless they say otherwise.

Between two instants f″ is bounded: |f″| ≤ Σᵢ sup|(w A² E)ᵢ| |zᵢ| + Σᵢ sup|(w A E)ᵢ| |pᵢ|. The suprema are taken over
the instants and extended to the points between them by the matrix exp(|A|h/2), which has no negative element and
majorises exp(Aδ) for |δ| ≤ h/2.
"""

import math
from typing import NamedTuple

import numpy as np
from vibroscope.engine.kernels.compile.options import jit, jit_inlined, jit_no_alloc, variant
from vibroscope.engine.kernels.compile.packing import Layout
from vibroscope.engine.kernels.linear import double_double
from vibroscope.engine.kernels.linear.matrices import (
    image,
    multiply,
    raise_to_images,
    raise_within,
    row_times,
    rows_times,
    unit,
)

POINTS = 64
TERMS = 12
REACH = 0.15  # REACH¹²/12! and, for derivatives, REACH¹¹/11! are below rounding
_SERIES = 16  # terms of exp(Ah): what is left out is far below rounding
_EXACT = 4  # terms to twice the digits where the others are in double precision: REACH⁴/4! is 2e-5

# columns of the rows of a phase, and of a state times these rows
VALUES = 0  # f at jh, j = 1 … POINTS
BERNSTEIN = VALUES + POINTS  # f over (0, h) as a polynomial in u = s/h: its Bernstein coefficients …
POWERS = BERNSTEIN + TERMS  # … and its powers
POSITION = POWERS + TERMS  # ξ₁ in powers of u
GAP = POSITION + TERMS  # g in powers of u
CURVATURE = GAP + TERMS  # sup|(w A² E)| h²/8
INTEGRAL = CURVATURE + 1  # ∫f dτ = row·Δz, where it is asked for
WORK = INTEGRAL + 1  # (of the products only) room for a polynomial
WIDTH = WORK + TERMS
DEEPEST = 48  # bisections of an interval
LOW, SPAN = TERMS, TERMS + 1  # columns of the stack: where an interval begins, and its width


class Phase(NamedTuple):
    """Tables of one phase."""

    spacing: float  # h
    position: float  # ξ₁*, g* and f*: what is counted from here
    gap: float
    watched: float
    pulled: float  # 1 where a constant acceleration acts that no equilibrium holds, −1 seen from another stop, else 0
    rows: np.ndarray  # (7, INTEGRAL + 1), the last of them what the pull adds
    transitions: np.ndarray  # (POINTS, 6, 6) E(jh)
    offsets: np.ndarray  # (POINTS, 4) what the pull adds to ξ₁, ξ₁′, g and g′


class Scratch(NamedTuple):
    """Work space, so that no kernel allocates."""

    products: np.ndarray  # (WIDTH,) a state times the rows of a phase, as far as needed
    stack: np.ndarray  # (DEEPEST, TERMS + 2) right halves still to search


PHASE = Layout(Phase, rows=(7, INTEGRAL + 1), transitions=(POINTS, 6, 6), offsets=(POINTS, 4))
SCRATCH = Layout(Scratch, products=(WIDTH,), stack=(DEEPEST, TERMS + 2))


# Σ powers[k] uᵏ has the coefficients powers @ TO_BERNSTEIN in Bernstein's basis on (0, 1)
_N = TERMS - 1
TO_BERNSTEIN = np.array([[math.comb(j, k) / math.comb(_N, k) for j in range(TERMS)] for k in range(TERMS)])


@jit
def full_generator(generator, eta):
    """A, (6, 6): a generator's four rows, and those of the excitation's phase."""
    a = np.zeros((6, 6))
    for i in range(4):
        for j in range(6):
            a[i, j] = generator[i, j]
    if eta == 0.0:
        a[4, 5] = 1.0
    else:
        a[4, 5], a[5, 4] = -eta, eta
    return a


@jit_no_alloc
def fill_polynomial(out, begin, row, a, pull, h):
    """Write w·z(s) as a polynomial in s/h: column begin + k of ``out`` becomes w Aᵏ hᵏ/k!, and w Aᵏ⁻¹p hᵏ/k!."""
    w0, w1, w2, w3, w4, w5, w6 = row[0], row[1], row[2], row[3], row[4], row[5], 0.0
    for k in range(TERMS):
        to, share = begin + k, h / (k + 1)
        out[0, to], out[1, to], out[2, to], out[3, to], out[4, to], out[5, to] = w0, w1, w2, w3, w4, w5
        out[6, to], w6 = w6, (w1 * pull[0] + w3 * pull[1]) * share
        w0, w1, w2, w3, w4, w5 = image((w0, w1, w2, w3, w4, w5), a)
        w0, w1, w2, w3, w4, w5 = w0 * share, w1 * share, w2 * share, w3 * share, w4 * share, w5 * share


@jit
def pull_of(generator):
    """The constant accelerations p of ξ₁ and g, of z′ = A z + p."""
    return generator[1, 6], generator[3, 6]


@jit
def fill_polynomials(rows, row, a, pull, h):
    """Write f, ξ₁ and g as polynomials."""
    fill_polynomial(rows, POWERS, row, a, pull, h)
    fill_polynomial(rows, POSITION, unit(0), a, pull, h)
    fill_polynomial(rows, GAP, unit(2), a, pull, h)


@jit
def pulled_over(rows, h):
    """What the pull adds to ξ₁, ξ₁′, g and g′ over one interval."""
    x, v = polynomial_at(rows[6, POSITION:GAP], 1.0)
    g, rate = polynomial_at(rows[6, GAP:CURVATURE], 1.0)
    return x, v / h, g, rate / h


@jit
def moved(transition, offset, more):
    """What a pull has added, carried over a further time in which it adds more."""
    m = transition
    x, v, g, rate = offset
    return (
        m[0, 0] * x + m[0, 1] * v + m[0, 2] * g + m[0, 3] * rate + more[0],
        m[1, 0] * x + m[1, 1] * v + m[1, 2] * g + m[1, 3] * rate + more[1],
        m[2, 0] * x + m[2, 1] * v + m[2, 2] * g + m[2, 3] * rate + more[2],
        m[3, 0] * x + m[3, 1] * v + m[3, 2] * g + m[3, 3] * rate + more[3],
    )


@jit_inlined
def pulled_by(phase, column):
    """What the pull adds to a column of a state times the rows."""
    return phase.pulled * phase.rows[6, column]


@jit_inlined
def unpulled(phase):
    """The phase of a difference of two motions."""
    return Phase(
        phase.spacing, phase.position, phase.gap, phase.watched, 0.0, phase.rows, phase.transitions, phase.offsets
    )


@jit
def write_load(transition, s, eta):
    """Write how C and S of the load go on over a time s."""
    if eta == 0.0:
        transition[4, 4] = transition[5, 5] = 1.0
        transition[4, 5] = s
        return
    turn = s * eta
    cosine, sine = math.cos(turn), math.sin(turn)
    transition[4, 4] = transition[5, 5] = cosine
    transition[5, 4], transition[4, 5] = sine, -sine


@jit
def tabulate_flow(old, generator, eta, row, h, equilibrium, exact):
    """Those tables of :func:`tabulate` that motions with given events need, in a fraction of the time.

    Of the transitions those over 1, 2, 4 … POINTS intervals; the values of f to fewer digits; no bounds. They are
    written in the place of those of an ``old`` phase. Transitions that are not ``exact`` lack the last two digits.
    """
    a, rows, transitions, offsets = full_generator(generator, eta), old.rows, old.transitions, old.offsets
    pull = pull_of(generator)
    fill_polynomials(rows, row, a, pull, h)
    first = pulled_over(rows, h)
    offset = first
    step = double_double.quick_exponential(a, h, TERMS, _EXACT if exact else 0)
    square = np.zeros((2, 6, 6))
    j = 1
    while j <= POINTS:
        write_load(transitions[j - 1], j * h, eta)
        for i in range(4):
            for k in range(6):
                transitions[j - 1, i, k] = step[0, i, k]
            offsets[j - 1, i] = offset[i]
        offset = moved(transitions[j - 1], offset, offset)
        if exact:
            double_double.multiply(square, step, step, 1.0)
        else:
            multiply(square[0], step[0], step[0])
        step, square, j = square, step, 2 * j
    later, pulled = (row[0], row[1], row[2], row[3], row[4], row[5]), 0.0
    for j in range(POINTS):
        pulled += later[0] * first[0] + later[1] * first[1] + later[2] * first[2] + later[3] * first[3]
        later = image(later, transitions[0])
        for i in range(6):
            rows[i, VALUES + j] = later[i]
        rows[6, VALUES + j] = pulled
    acts = 1.0 if pull[0] != 0.0 or pull[1] != 0.0 else 0.0
    return Phase(h, equilibrium[0], equilibrium[1], equilibrium[2], acts, rows, transitions, offsets)


@jit
def tabulate(generator, eta, row, h, equilibrium):
    """Tables of the phase z′ = A z in which f = f* + ``row``·z is watched.

    Parameters
    ----------
    generator : (4, 7) float64
        Upper rows of A, and the constant accelerations.
    eta : float
        Frequency of the load; 0 where it is linear in time.
    row : (6,) float64
    h : float
        At most REACH over the largest |eigenvalue|.
    equilibrium : (3,) tuple of float64
        ξ₁*, g* and f*.

    Returns
    -------
    Phase
    """
    a = full_generator(generator, eta)
    transitions = double_double.powers(double_double.exponential(a, h, _SERIES), POINTS)
    for j in range(1, POINTS + 1):
        write_load(transitions[j - 1], j * h, eta)
    rows, offsets, pull = np.zeros((7, INTEGRAL + 1)), np.zeros((POINTS, 4)), pull_of(generator)
    fill_polynomials(rows, row, a, pull, h)
    for i in range(7):
        for j in range(TERMS):
            for k in range(j + 1):
                rows[i, BERNSTEIN + j] += rows[i, POWERS + k] * TO_BERNSTEIN[k, j]
    curvature = row_times(row_times(row, a), a)
    bound = np.zeros(6)
    raise_to_images(bound, curvature, transitions)
    values = np.empty((POINTS, 6))
    rows_times(values, row, transitions)
    for j in range(POINTS):
        for i in range(6):
            rows[i, VALUES + j] = values[j, i]
    raise_within(bound, a, h / 2)
    for i in range(6):
        rows[i, CURVATURE] = bound[i] * (h * h / 8)
    acts = 0.0
    if pull[0] != 0.0 or pull[1] != 0.0:
        acts, first = 1.0, pulled_over(rows, h)
        offset = first
        for j in range(POINTS):
            for i in range(4):
                offsets[j, i] = offset[i]
                rows[6, VALUES + j] += row[i] * offset[i]
            offset = moved(transitions[0], offset, first)
        slope = row_times(row, a)
        bound = np.zeros(6)
        raise_to_images(bound, slope, transitions)
        raise_within(bound, a, h / 2)
        rows[6, CURVATURE] = (bound[1] * abs(pull[0]) + bound[3] * abs(pull[1])) * (h * h / 8)
    return Phase(h, equilibrium[0], equilibrium[1], equilibrium[2], acts, rows, transitions, offsets)


def _product(begin, end):
    # begin and end are constants of each function, so the loop compiles to a handful of vector instructions
    @jit_inlined
    @variant(begin, end)
    def product(phase, z, scratch):
        z0, z1, z2, z3, z4, z5 = z
        t0, t1, t2, t3, t4, t5 = (
            phase.rows[0, begin:end],
            phase.rows[1, begin:end],
            phase.rows[2, begin:end],
            phase.rows[3, begin:end],
            phase.rows[4, begin:end],
            phase.rows[5, begin:end],
        )
        out = scratch.products[begin:end]
        for k in range(end - begin):
            out[k] = t0[k] * z0 + t1[k] * z1 + t2[k] * z2 + t3[k] * z3 + t4[k] * z4 + t5[k] * z5
        if phase.pulled != 0.0:
            for k in range(end - begin):
                out[k] += phase.pulled * phase.rows[6, begin + k]

    return product


find_values = _product(VALUES, BERNSTEIN)
find_watched = _product(BERNSTEIN, POSITION)
find_powers = _product(POWERS, POSITION)
find_position = _product(POSITION, GAP)
find_gap = _product(GAP, CURVATURE)


@jit_inlined
def curvature_bound(phase, z):
    """h²/8 times a bound of |f″| over the block that begins at z."""
    level = phase.rows[6, CURVATURE]
    for i in range(6):
        level += phase.rows[i, CURVATURE] * abs(z[i])
    return level


@jit_inlined
def dot(row, z):
    """A row times z."""
    return row[0] * z[0] + row[1] * z[1] + row[2] * z[2] + row[3] * z[3] + row[4] * z[4] + row[5] * z[5]


@jit_inlined
def apply_transition(transitions, z, j):
    """z times matrix j of a table, counted from 1; z itself for j = 0."""
    if j == 0:
        return z
    m = transitions[j - 1]
    z0, z1, z2, z3, z4, z5 = z
    return (
        m[0, 0] * z0 + m[0, 1] * z1 + m[0, 2] * z2 + m[0, 3] * z3 + m[0, 4] * z4 + m[0, 5] * z5,
        m[1, 0] * z0 + m[1, 1] * z1 + m[1, 2] * z2 + m[1, 3] * z3 + m[1, 4] * z4 + m[1, 5] * z5,
        m[2, 0] * z0 + m[2, 1] * z1 + m[2, 2] * z2 + m[2, 3] * z3 + m[2, 4] * z4 + m[2, 5] * z5,
        m[3, 0] * z0 + m[3, 1] * z1 + m[3, 2] * z2 + m[3, 3] * z3 + m[3, 4] * z4 + m[3, 5] * z5,
        m[4, 4] * z4 + m[4, 5] * z5,
        m[5, 4] * z4 + m[5, 5] * z5,
    )


@jit_inlined
def state_after(phase, z, j):
    """z after j intervals."""
    after = apply_transition(phase.transitions, z, j)
    if phase.pulled == 0.0 or j == 0:
        return after
    z0, z1, z2, z3, z4, z5 = after
    b, pulled = phase.offsets[j - 1], phase.pulled
    return z0 + pulled * b[0], z1 + pulled * b[1], z2 + pulled * b[2], z3 + pulled * b[3], z4, z5


@jit_inlined
def polynomial_at(terms, u):
    """Σ terms[k] uᵏ and its derivative.

    Even and odd powers apart: two short chains of dependent sums instead of a long one.
    """
    w = u * u
    even, odd, even1, odd1 = terms[_N - 1], terms[_N], 0.0, 0.0
    for k in range(_N - 3, -1, -2):
        even1, odd1 = even1 * w + even, odd1 * w + odd
        even, odd = even * w + terms[k], odd * w + terms[k + 1]
    return even + u * odd, 2.0 * u * even1 + odd + 2.0 * w * odd1


@jit_inlined
def position_at(phase, z, u, scratch):
    """ξ₁ and ξ₁′ at s = uh."""
    find_position(phase, z, scratch)
    x, v = polynomial_at(scratch.products[POSITION:GAP], u)
    return x, v / phase.spacing


@jit_inlined
def gap_at(phase, z, u, scratch):
    """The gap and its rate at s = uh."""
    find_gap(phase, z, scratch)
    g, rate = polynomial_at(scratch.products[GAP:CURVATURE], u)
    return g, rate / phase.spacing
