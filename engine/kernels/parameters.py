"""The numbers that define one run: what Python hands to compiled code, and what every table is set up from."""

from typing import NamedTuple

import numpy as np
from vibroscope.engine.kernels.compile.options import jit_no_alloc
from vibroscope.engine.kernels.compile.packing import Layout, aligned_zeros


class Parameters(NamedTuple):
    """The numbers of one run, in the order in which tables depend on them: flight, contact, laws.

    **A wall.** The kernels see one body and a wall as two bodies of which the first never moves: the wall takes the
    place of body 1, at rest, and the body, seen from the wall, that of body 2. κ = √k₁, κ₃ = μ = 1 and d₂κ = d₁ belong
    to this view. Neither a load nor the contact force acts on body 1, nor is it coupled to body 2: the coefficients
    that would move it are zero (:mod:`.equations.motion`). So the first two numbers of the state (ξ₁, ξ₁′, g, g′) stay
    zero to the last digit, and no kernel asks whether there is a wall.

    **Two bodies of which one or both have no spring.** k₁ = ``spring1`` = 0, or κ = 0. Without a constant force such a
    body may rest anywhere; motions are counted from where it touches the other one, ``free_gap`` = 0. So are they with
    a constant force on it: ``pull`` is the acceleration that this gives the gap, and ``pull1`` what it gives body 1.
    The flight adds what it does to the motion, which depends on the time alone (:mod:`.linear.tables`); in contact the
    spring of the other body bears it, or both accelerate alike if that has none, either.

    **No rest, or one far away.** Motions are counted from the static equilibrium. A body without a spring has none; a
    weak spring and a weight have one so far away that the motion near the wall would lose digits. Beside a wall such a
    motion is counted from touch instead, ``free_gap`` = 0, and the constant force becomes the acceleration ``pull`` of
    the gap. For that the place of the wall, ξ₁ = 0, is counted from ``free_position`` = −1: the first number of z stays
    one to the last digit, and pull is its factor in g″.

    **Two stops.** The motion between them is linear, so −z obeys the same equations with the loads reversed. Each stop
    has parameters of its own, those of the system as seen from there: for the second one the system is mirrored
    (``sign`` = −1), and the gap counted from it is ``play`` less that of the first. So every loop knows one surface,
    and how far the other one lies: where a flight meets that, the loop ends as CROSSED and another one goes on.
    """

    eta: float
    kappa: float
    spring1: float  # 1, or 0 of two bodies of which the first has no spring
    d1: float
    damper2: float  # d₂κ, d₂ where body 2 has no spring
    steps: float  # n; 0 for the solvers in closed form
    wall: float  # 1 or 0
    pulse: float  # −1: the load is cos ητ; else the frequency of a pulse, 0 of a load that is linear in time
    base_cosine: float  # factors of cos ητ and sin ητ in the motion of the base
    base_sine: float
    force1_cosine: float  # … in the force on body 1
    force1_sine: float
    push_cosine: float  # … in force 2 over μ less force 1, which drives the gap
    push_sine: float
    free_position: float  # static equilibrium of the separated bodies: ξ₁ and gap
    free_gap: float
    pull: float  # constant acceleration of the gap, where motions are counted from touch; else 0
    pull1: float  # … and of body 1, if it has no spring, of two
    clearance: float
    kappa3: float
    damper3: float  # d₃κ₃
    mu: float
    mass_share: float  # reduced mass in units of m₁: μ/(1 + μ), 1 at a wall
    stiffness_share: float  # both springs in series, in units of k₁: μκ²/(1 + μκ²), 1 at a wall, 0 with a free body
    stiffness: float
    damping: float
    restitution: float
    threshold: float
    law: float  # of equations.contact_law.LAWS
    exponent: float
    penetration: float
    stiffening: float
    gain: float  # c of the law's damper or h of Eq. (18); times the closing speed where ``relative``
    relative: float  # 1 or 0
    play: float  # distance between two stops, inf of one
    sign: float  # 1; −1 as seen from the second stop


ETA = Parameters._fields.index("eta")
FOR_FLIGHT = Parameters._fields.index("clearance") + 1  # numbers that the tables of flight depend on …
FOR_CONTACT = Parameters._fields.index("damping") + 1  # … and those of contact

unpack_parameters = Layout(Parameters).unpack


def no_keys() -> np.ndarray:
    """The keys of tables that have not been set up: no number equals them."""
    return np.full((2, len(Parameters._fields)), np.nan)


def no_tables(layout: Layout, stops: int, more: int = 0) -> tuple[np.ndarray, np.ndarray]:
    """Room for the tables of each stop, (stops, n), and their keys, (stops, 2, len(Parameters)).

    ``more``: numbers behind the tables.
    """
    packed = aligned_zeros(stops * (layout.size + more)).reshape(stops, -1)
    return packed, np.array([no_keys() for _ in range(stops)])


@jit_no_alloc
def renew_key(key, row, count):
    """Whether one of the first ``count`` numbers has changed; the key then holds the new ones."""
    changed = False
    for k in range(count):
        changed |= key[k] != row[k]
        key[k] = row[k]
    return changed
