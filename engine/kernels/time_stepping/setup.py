"""From the numbers of a cell to Newmark's step and its leaps."""

import math

from ..accelerated.skip import GAP, SLOTS, tables_in, write_scheme
from ..accelerated.step_map import fill_tables
from ..compile.options import exact, jit
from ..event_driven.setup import FOR_CONTACT, FOR_FLIGHT, cell_of, free_pole, pressed_pole, renew
from .newmark import A1, A2, CONTACT, P1, P2, Q1, Q2, Scheme


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
    return Scheme(
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
    """Write the leaps of a cell into ``folded``, as :class:`..accelerated.skip.Leaps` is laid out."""
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
    state[CONTACT], state[GAP] = (1.0 if contact else 0.0), x2 - x1
