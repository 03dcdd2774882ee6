"""From the numbers of a cell to the tables of its solver, in compiled code.

Tables are made anew only where a number that they hang on has changed since the cell before: cells that differ in K and
D alone share those of the flight. A table that is kept has the bits of one that is made.
"""

import math
from typing import NamedTuple

import numpy as np

from . import newmark, pendulums
from .jit import bare, exact, jit
from .leaps import GAP as GAP_SLOT
from .leaps import SLOTS, tables_in, write_scheme
from .matrices import unit
from .newmark import A1, A2, CONTACT, P1, P2, Q1, Q2
from .phase import PHASE_SHAPES, REACH, SCRATCH_SHAPES, full, tabulate
from .slow import APART, fast_part
from .steps import fill_tables


class Cell(NamedTuple):
    """The numbers of one cell, in the order in which tables need them: flight, contact, laws."""

    eta: float
    kappa: float
    d1: float
    d2: float
    steps: float  # n; 0 for the solvers in closed form
    kappa3: float
    d3: float
    mu: float
    mass_share: float  # μ/(1 + μ)
    stiffness: float
    damping: float
    restitution: float
    threshold: float


FOR_FLIGHT = Cell._fields.index("steps") + 1  # numbers on which the tables of flight hang …
FOR_CONTACT = Cell._fields.index("damping") + 1  # … and those of contact
PHASE_SIZE = sum(math.prod(shape) for shape in PHASE_SHAPES)
SCRATCH_SIZE = sum(math.prod(shape) for shape in SCRATCH_SHAPES)
CLOSED_SIZE = 2 + 3 * PHASE_SIZE + 1 + 24 + 8 + SCRATCH_SIZE


@bare
def cell_of(row):
    """The cell that a row of numbers holds."""
    r = row
    return Cell(r[0], r[1], r[2], r[3], r[4], r[5], r[6], r[7], r[8], r[9], r[10], r[11], r[12])


def no_keys() -> np.ndarray:
    """The keys of tables that have not been made: no number equals them."""
    return np.full((2, len(Cell._fields)), np.nan)


@bare
def renew(key, row, count):
    """Whether one of the first numbers has changed; the key then holds the new ones."""
    changed = False
    for k in range(count):
        changed |= key[k] != row[k]
        key[k] = row[k]
    return changed


@exact
def free_pole(cell):
    """Largest |λ| of the separated pendulums and the excitation."""
    return max(1.0, cell.kappa, cell.eta)


@exact
def pressed_pole(cell):
    """A bound of the largest |λ| with the pendulums pressed together.

    The relative motion on the contact spring has λ² + 2D(1 + 1/μ)λ + K(1 + 1/μ) = 0; the pendulums' own springs and the
    coupling of the two motions add no more than the free poles.
    """
    share = 1.0 / cell.mass_share
    half, square = cell.damping * share, cell.stiffness * share
    contact = half + math.sqrt(half * half - square) if half * half > square else math.sqrt(square)
    return free_pole(cell) + contact


@exact
def force_of(cell, rigid):
    """The contact force λ as factors of ξ₁, ξ₁′, g and g′ (MODEL.md, "Motion")."""
    if rigid:
        position = (cell.kappa3 - 1.0) * (cell.kappa3 + 1.0)
        return position, cell.mass_share * 2.0 * (cell.d2 * cell.kappa - cell.d1), 0.0, 0.0
    return 0.0, 0.0, -cell.stiffness, -2.0 * cell.damping


@jit
def flight_phase(cell):
    """Tables of the separated pendulums, in which the gap is watched."""
    generator = pendulums.separated(cell.eta, cell.kappa, cell.d1, cell.d2)
    return tabulate(generator, cell.eta, unit(2), REACH / free_pole(cell))


@jit
def watched(cell, rigid):
    """What is watched in contact, as a row: the contact force (reference) or the penetration −g (penalty)."""
    row = np.zeros(6)
    if rigid:
        row[0], row[1], _, _ = force_of(cell, rigid)
    else:
        row[2] = -1.0
    return row


@jit
def pressed_generator(cell):
    """Upper rows (4, 6) of the generator in penalty contact."""
    c = cell
    return pendulums.pressed(c.eta, c.kappa, c.d1, c.d2, c.mu, c.stiffness, c.damping)


@jit
def touching_phase(cell, rigid):
    """Tables of the pendulums in contact."""
    if rigid:
        generator, fastest = pendulums.joined(cell.eta, cell.kappa3, cell.d3), max(cell.kappa3, cell.eta)
    else:
        generator, fastest = pressed_generator(cell), pressed_pole(cell)
    return tabulate(generator, cell.eta, watched(cell, rigid), REACH / fastest)


@jit
def calm_phase(cell, fast, slow_pole):
    """Tables of the pendulums in penalty contact once what is fast has died away: z′ = A (1 − F) z."""
    generator = pressed_generator(cell)
    rest = generator.copy()
    for i in range(4):
        for j in range(6):
            for k in range(4):  # the lower rows of F are zero
                rest[i, j] -= generator[i, k] * fast[k, j]
    return tabulate(rest, cell.eta, watched(cell, False), REACH / max(slow_pole, free_pole(cell)))


@jit
def are_stiff(numbers):
    """Which rows of numbers are cells that may have a slow phase, (n,) of bool."""
    stiff = np.zeros(len(numbers), dtype=np.bool_)
    for i in range(len(numbers)):
        cell = cell_of(numbers[i])
        stiff[i] = pressed_pole(cell) >= APART * free_pole(cell)
    return stiff


@jit
def pressed_generators(numbers):
    """The generators in penalty contact of many cells, (n, 6, 6)."""
    out = np.zeros((len(numbers), 6, 6))
    for i in range(len(numbers)):
        cell = cell_of(numbers[i])
        out[i] = full(pressed_generator(cell), cell.eta)
    return out


@jit
def put(folded, at, values):
    """Write an array into a folded one (see :mod:`.folded`) and return the place after it."""
    flat = values.ravel()
    for k in range(flat.size):
        folded[at + k] = flat[k]
    return at + flat.size


@jit
def put_phase(folded, at, phase):
    """Write the tables of a phase."""
    folded[at] = phase.spacing
    return put(folded, put(folded, at + 1, phase.rows), phase.moves)


@jit
def set_up_closed(folded, keys, row, rigid, circle, completion):
    """Write the contact of a cell into ``folded``, as :class:`.anchor.Contact` is laid out.

    ``circle``: as :func:`engine.drivers.slow.circles` gives it.
    """
    cell = cell_of(row)
    folded[0], folded[1] = 2 * math.pi / cell.eta, (1.0 if rigid else 0.0)
    at = 2 + PHASE_SIZE
    if renew(keys[0], row, FOR_FLIGHT):
        put_phase(folded, 2, flight_phase(cell))
    laws = at + 2 * PHASE_SIZE
    if renew(keys[1], row, FOR_CONTACT):
        put_phase(folded, at, touching_phase(cell, rigid))
        folded[laws] = 0.0
        if circle[0] > 0.0:
            fast = fast_part(pressed_generator(cell), cell.eta, circle[0])
            put_phase(folded, at + PHASE_SIZE, calm_phase(cell, fast, circle[1]))
            folded[laws] = 1.0
            put(folded, laws + 1, fast)
    at = laws + 1 + 24
    folded[at], folded[at + 1], folded[at + 2], folded[at + 3] = force_of(cell, rigid)
    folded[at + 4], folded[at + 5], folded[at + 6] = cell.mass_share, cell.restitution, cell.threshold
    folded[at + 7] = completion


@exact
def scheme_of(cell):
    """Coefficients of one step of Newmark's method (derived in :mod:`.newmark`)."""
    h = 2 * math.pi / cell.eta / cell.steps
    eta, mu, k, d = cell.eta, cell.mu, cell.stiffness, cell.damping
    c1, c2 = 2 * cell.d1, 2 * cell.d2 * cell.kappa
    k1, k2 = 1.0, cell.kappa * cell.kappa
    m1 = 1 + c1 * h / 2 + k1 * h * h / 4
    m2 = 1 + c2 * h / 2 + k2 * h * h / 4
    sigma = k * h * h / 4 + d * h
    shared = 1 + sigma * (1 / m1 + 1 / (mu * m2))
    return newmark.Scheme(
        h,
        c1 * h / m1,
        k1 * h * h / m1,
        eta * eta * h * h / m1,
        h * h / m1,
        c2 * h / m2,
        k2 * h * h / m2,
        eta * eta * h * h / m2,
        h * h / (mu * m2),
        k,
        d,
        k / shared,
        2 * d / h / shared,
        sigma / (h * h) / shared,
    )


@jit
def set_up_leaps(folded, keys, row):
    """Write the leaps of a cell into ``folded``, as :class:`.leaps.Leaps` is laid out."""
    cell = cell_of(row)
    m, tables, poles = scheme_of(cell), tables_in(folded), (free_pole(cell), pressed_pole(cell))
    counts = FOR_FLIGHT, FOR_CONTACT
    write_scheme(folded, cell.steps, m)
    for state in range(2):  # a constant in its place would be compiled apart
        if renew(keys[state], row, counts[state]):
            fill_tables(tables, m, cell.eta, state, poles[state])


@exact
def begin_steps(state, m, cell, start):
    """The state of Newmark's method at τ = 0, its accelerations from the equations of motion (MODEL.md, "Motion")."""
    x1, v1, x2, v2 = start[0], start[1], start[2], start[3]
    h, eta = m.h, cell.eta
    contact = x2 <= x1
    force = cell.stiffness * (x1 - x2) + 2 * cell.damping * (v1 - v2) if contact else 0.0
    a1 = h * h * (eta * eta - 2 * cell.d1 * v1 - x1 - force)
    a2 = h * h * (eta * eta - 2 * cell.d2 * cell.kappa * v2 - cell.kappa * cell.kappa * x2 + force / cell.mu)
    for k in range(SLOTS):
        state[k] = 0.0
    state[A1], state[A2] = a1, a2
    state[Q1], state[Q2] = h * v1 + 0.5 * a1, h * v2 + 0.5 * a2
    state[P1], state[P2] = x1 + h * v1 + 0.25 * a1, x2 + h * v2 + 0.25 * a2
    state[CONTACT], state[GAP_SLOT] = (1.0 if contact else 0.0), x2 - x1
