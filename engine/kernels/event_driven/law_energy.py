"""Energies along a motion with any contact law: integrals of the powers, piece by piece and step by step.

In flight and in the pieces of a law, Gauss's rule with six nodes over every few intervals of the tables, in which
it is exact to rounding; in other contacts over parts of each step. Nodes are instants of the solution itself, so
that the sums check it.
"""

import numpy as np
from vibroscope.engine.kernels.compile.options import jit_no_alloc
from vibroscope.engine.kernels.equations.contact_law import law_force
from vibroscope.engine.kernels.event_driven.law_contact import set_start
from vibroscope.engine.kernels.event_driven.law_integrate import SMOOTH, follow, law_motion, piece_of, resolve_law
from vibroscope.engine.kernels.event_driven.state import FLIGHT, load_at, time_to_load_change, unpack_state, write_state
from vibroscope.engine.kernels.linear.tables import TERMS
from vibroscope.engine.kernels.status import OK, UNRESOLVED

INTERVALS = 4.0  # of the tables, over which one rule is taken
PARTS = 4.0  # of a step
NODES, WEIGHTS = (array.copy() for array in np.polynomial.legendre.leggauss(TERMS // 2))
WORK, DAMPERS, CONTACT = range(3)


@jit_no_alloc
def add_powers(p, a, z, gain, t, weight, sums):
    """Add the powers t after a hybrid state, times a weight: of the excitation, of the dampers and of λ on δ."""
    _, v1, gap, rate = law_motion(p, a, z, t)
    c, s = load_at(p, a.tau + t, (a.tau + t) / p.period)
    g, v2, mu = p.generator, v1 + rate, 1.0 / (p.inverse_mass - p.react1)
    load = g[1, 4] * c + g[1, 5] * s
    push = g[3, 4] * c + g[3, 5] * s
    sums[WORK] += weight * (load * v1 + mu * (load + push) * v2)
    sums[DAMPERS] -= weight * (g[1, 1] * v1 * v1 + mu * g[3, 3] * v2 * v2)
    if a.mode != FLIGHT:
        sums[CONTACT] -= weight * law_force(p.law, gain, -gap, -rate) * rate


@jit_no_alloc
def integrate_powers(p, state, stop, sums):
    """Integrate to the end of period ``stop`` as :func:`.law_integrate.integrate_law` does; OK or UNRESOLVED.

    ``sums``, (2, 3): the work of the excitation, what the dampers take, and the work of λ on the contact, up to the
    state and up to ``stop``; changed in place.
    """
    a = unpack_state(state)
    while True:
        a = resolve_law(p, a)
        horizon = (stop - a.period) * p.period - a.tau
        z, s, after, _, _ = follow(p, a)
        if s < 0.0:
            return UNRESOLVED
        parts = PARTS if a.mode == SMOOTH else np.ceil(s / (INTERVALS * p.spacing[piece_of(a)]))
        span, gain = min(s, horizon), set_start(p, a)
        half, total = 0.5 * span / parts, sums[1]
        for j in range(3):
            total[j] = sums[0, j]
        for k in range(int(parts)):
            for j in range(NODES.shape[0]):
                add_powers(p, a, z, gain, half * (2.0 * k + 1.0 + NODES[j]), half * WEIGHTS[j], total)
        if s >= horizon and time_to_load_change(p, a.tau) >= horizon:
            write_state(state, a)
            return OK
        a = after
        for j in range(3):
            sums[0, j] = total[j]
