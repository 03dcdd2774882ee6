"""From the numbers of a cell to the tables of its motion in closed form, in compiled code.

Tables are made anew only where a number that they hang on has changed since the cell before: cells that differ in K and
D alone share those of the flight. A table that is kept has the bits of one that is made.
"""

import math
from typing import NamedTuple

import numpy as np

from ..compile.options import bare, exact, jit
from ..equations import motion as pendulums
from ..linear.matrices import unit
from ..linear.slow_subspace import APART, fast_part
from ..linear.tables import PHASE_SHAPES, REACH, SCRATCH_SHAPES, full, tabulate


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
    """Write an array into a folded one (see :mod:`..compile.packing`) and return the place after it."""
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
    """Write the contact of a cell into ``folded``, as :class:`.state.Contact` is laid out.

    ``circle``: as :func:`engine.drivers.slow_subspace.circles` gives it.
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
