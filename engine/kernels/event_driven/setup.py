"""From the numbers of a run to the tables of its motion in closed form.

Tables are made anew only where a number that they depend on has changed since the run before: cells that differ in K
and D alone share those of the flight. A reused table is bit-identical to a new one.

Separation of the fast motion of a stiff or strongly damped contact from the slow one.

Pressed together, the bodies have modes of very different speed: that of the contact spring and damper, and those of
their own springs. The fast modes decay, and then the solver need not follow them at their pace: what is left of the
state lies in the invariant subspace of the slow eigenvalues and obeys z′ = A P_s z, P_s the spectral projector on it,

    P_s = 1/(2πi) ∮ (ν − A)⁻¹ dν                                                                 (44)

around a circle between the two groups. The trapezoidal rule on the circle converges as the q-th power of the ratio of a
radius and an eigenvalue, q the number of its nodes, whether or not eigenvalues within a group coincide. With the
bodies' B and the excitation's R, A = [B C; 0 R], the upper rows of (ν − A)⁻¹ are (ν − B)⁻¹ [1  C (ν − R)⁻¹].

Plain twin: integration without the separation, which gives the same motion and takes longer
(tests/engine/kernels/test_slow_subspace.py).
"""

import cmath
import math

import numpy as np
from vibroscope.engine.kernels.compile.options import jit
from vibroscope.engine.kernels.equations.contact_law import force, joint_force, joint_force_constant
from vibroscope.engine.kernels.equations.motion import (
    coefficients,
    free_equilibrium,
    free_rate,
    holding,
    joined_equilibrium,
    joined_generator,
    joint_pull,
    joint_share,
    load_rate,
    pressed_equilibrium,
    pressed_generator,
    pressed_rate,
    separated_generator,
)
from vibroscope.engine.kernels.event_driven.state import SYSTEM, unpack_system
from vibroscope.engine.kernels.linear.matrices import unit
from vibroscope.engine.kernels.linear.tables import REACH, full_generator, tabulate, tabulate_flow
from vibroscope.engine.kernels.parameters import FOR_CONTACT, FOR_FLIGHT, renew_key, unpack_parameters

SEPARATION = 30.0  # least ratio of the two groups that is worth a table of its own
NODES = 32  # SEPARATION to the power −NODES/2 is far below rounding
_HALF = NODES // 2  # the nodes below the real axis give the complex conjugate


@jit
def eliminate(m):
    """Turn (4, 10) complex [M X] into [1 M⁻¹X], by Gauss-Jordan elimination with column pivots."""
    for k in range(4):
        pivot = k
        for i in range(k + 1, 4):
            if abs(m[i, k]) > abs(m[pivot, k]):
                pivot = i
        for j in range(k, 10):
            m[k, j], m[pivot, j] = m[pivot, j], m[k, j]
        scale = 1.0 / m[k, k]
        for j in range(k, 10):
            m[k, j] *= scale
        for i in range(4):
            if i != k:
                factor = m[i, k]
                for j in range(k, 10):
                    m[i, j] -= factor * m[k, j]


@jit
def fast_projector(generator, eta, radius):
    """Upper rows of P_f = 1 − P_s, (4, 6), which give the fast part of a state; the other rows are zero.

    Parameters
    ----------
    generator : (4, 6) float64
        Upper rows of A.
    eta : float
    radius : float
        Of a circle that encloses the slow eigenvalues and none of the fast ones.
    """
    fast, m = np.zeros((4, 6)), np.zeros((4, 10), dtype=np.complex128)
    for k in range(_HALF):
        node = radius * cmath.exp(1j * math.pi * (k + 0.5) / _HALF)
        turning = 1.0 / (node * node + eta * eta)
        for i in range(4):
            for j in range(4):
                m[i, j] = -generator[i, j]
                m[i, 4 + j] = 0.0
            m[i, i] += node
            m[i, 4 + i] = 1.0
            c, s = generator[i, 4], generator[i, 5]
            m[i, 8] = (c * node + s * eta) * turning
            m[i, 9] = (s * node - c * eta) * turning
        eliminate(m)
        for i in range(4):
            for j in range(6):
                fast[i, j] -= (node * m[i, 4 + j]).real / _HALF
    for i in range(4):
        fast[i, i] += 1.0
    return fast


_write_flight, _write_contact, _write_slow = (SYSTEM.writer(name) for name in ("flight", "contact", "slow_contact"))
_write_fast, _write_numbers = SYSTEM.writer("fast"), SYSTEM.writer("period", "rigid", "stiff", "wall")
_write_laws = SYSTEM.writer("force_position", "force_velocity", "force_gap", "force_rate")
_write_other_force = SYSTEM.writer("force_cosine", "force_sine", "force_constant")
_write_impact = SYSTEM.writer("clearance", "mass_share", "restitution", "threshold", "completion", "play", "sign")


@jit
def force_factors(p, rigid):
    """Factors of ξ₁, ξ₁′, g and g′ in the contact force λ."""
    if rigid:
        position, velocity = joint_force(p)
        return position, velocity, 0.0, 0.0
    return 0.0, 0.0, force(p.stiffness, p.damping, 1.0, 0.0), force(p.stiffness, p.damping, 0.0, 1.0)  # Eq. (5)


@jit
def other_force_factors(p, rigid):
    """Factors of cos ητ and sin ητ in the contact force of the joined bodies, and its constant, Eq. (8)."""
    if rigid:
        push = coefficients(p).push
        return -p.mass_share * push[0], -p.mass_share * push[1], joint_force_constant(p)
    return 0.0, 0.0, 0.0


@jit
def watched_in_contact(p, rigid):
    """What is watched in contact, as a row: the contact force (reference) or the penetration −g (penalty)."""
    row = np.zeros(6)
    if rigid:
        row[0], row[1] = joint_force(p)
        row[4], row[5], _ = other_force_factors(p, rigid)
    else:
        row[2] = -1.0
    return row


@jit
def flight(p):
    """The separated bodies, of which the gap is watched: generator, watched row, spacing of tables, equilibrium."""
    position, gap = free_equilibrium(p)
    return separated_generator(p), unit(2), REACH / free_rate(p), (position, gap, gap)


@jit
def contact_generator(p, rigid):
    """The generator of the bodies in contact, and its largest |eigenvalue| or a bound of that."""
    if rigid:
        return joined_generator(p), max(p.kappa3, load_rate(p), 2.0 * p.damper3)
    return pressed_generator(p), pressed_rate(p)


@jit
def contact(p, rigid):
    """The same of the bodies in contact."""
    generator, fastest = contact_generator(p, rigid)
    return generator, watched_in_contact(p, rigid), REACH / fastest, contact_equilibrium(p, rigid)


@jit
def contact_equilibrium(p, rigid):
    """ξ₁, gap and the watched quantity of the bodies at rest in contact."""
    if rigid:
        position, gap = joined_equilibrium(p)
        return position, gap, -p.stiffness_share * p.free_gap - holding(p)
    position, gap = pressed_equilibrium(p)
    return position, gap, -gap


@jit
def slow_contact_phase(p, fast, slow_rate):
    """Tables of penalty contact once its fast part has decayed: z′ = A (1 − P_f) z, P_f the fast projector."""
    generator = pressed_generator(p)
    rest = generator.copy()
    for i in range(4):
        for j in range(6):
            for k in range(4):  # the lower rows of P_f are zero
                rest[i, j] -= generator[i, k] * fast[k, j]
    row, equilibrium, h = (
        watched_in_contact(p, False),
        contact_equilibrium(p, False),
        REACH / max(slow_rate, free_rate(p)),
    )
    return tabulate(rest, load_rate(p), row, h, equilibrium)


@jit
def are_stiff(rows):
    """Which rows of parameters belong to runs that may have a slow phase, (n,) of bool.

    Dampers that differ let a pull on both bodies excite the fast modes all the time.
    """
    stiff = np.zeros(len(rows), dtype=np.bool_)
    for i in range(len(rows)):
        p = unpack_parameters(rows[i])
        settles = joint_pull(p) == 0.0 or p.d1 == p.damper2
        stiff[i] = settles and pressed_rate(p) >= SEPARATION * free_rate(p)
    return stiff


@jit
def full_pressed_generators(rows):
    """A in penalty contact of many runs, (n, 6, 6)."""
    out = np.zeros((len(rows), 6, 6))
    for i in range(len(rows)):
        p = unpack_parameters(rows[i])
        generator = full_generator(pressed_generator(p), load_rate(p))
        for j in range(6):
            for k in range(6):
                out[i, j, k] = generator[j, k]
    return out


@jit
def write_laws(packed, p, rigid, stiff, completion):
    """Write the numbers of a :class:`.state.HybridSystem` that are no tables."""
    _write_numbers(packed, 2 * math.pi / p.eta, rigid, stiff, p.wall)
    position, velocity, gap, rate = force_factors(p, rigid)
    _write_laws(packed, position, velocity, gap, rate)
    cosine, sine, constant = other_force_factors(p, rigid)
    _write_other_force(packed, cosine, sine, constant)
    _write_impact(packed, p.clearance, joint_share(p), p.restitution, p.threshold, completion, p.play, p.sign)


@jit
def set_up_events(packed, keys, row, rigid, circle, completion):
    """Write the :class:`.state.HybridSystem` of a run into its packed array.

    Parameters
    ----------
    packed : (SYSTEM.size,) float64
    keys : (2, len(Parameters)) float64
        The parameters for which the tables in ``packed`` were made; changed in place.
    row : (len(Parameters),) float64
    rigid : bool
        Whether the contact is the reference's.
    circle : (2,) float64
        Radius that separates slow from fast eigenvalues in contact, 0 for none; largest |slow eigenvalue|.
    completion : float
        How far a chatter must have come to be summed up.
    """
    p = unpack_parameters(row)
    write_laws(packed, p, rigid, circle[0] > 0.0, completion)
    if renew_key(keys[0], row, FOR_FLIGHT):
        generator, watched, h, equilibrium = flight(p)
        _write_flight(packed, tabulate(generator, load_rate(p), watched, h, equilibrium))
    if renew_key(keys[1], row, FOR_CONTACT):
        generator, watched, h, equilibrium = contact(p, rigid)
        _write_contact(packed, tabulate(generator, load_rate(p), watched, h, equilibrium))
        if circle[0] > 0.0:
            fast = fast_projector(pressed_generator(p), load_rate(p), circle[0])
            _write_slow(packed, slow_contact_phase(p, fast, circle[1]))
            _write_fast(packed, fast)


@jit
def set_up_flow(packed, keys, row, rigid, touching, completion, exact):
    """The same for motions whose events are given; tables of contact only if the bodies are ``touching`` at some time.

    The tables are those of :func:`..linear.tables.tabulate_flow`, ``exact`` or not.
    """
    p = unpack_parameters(row)
    old = unpack_system(packed)
    write_laws(packed, p, rigid, False, completion)
    if renew_key(keys[0], row, FOR_FLIGHT):
        generator, watched, h, equilibrium = flight(p)
        _write_flight(packed, tabulate_flow(old.flight, generator, p.eta, watched, h, equilibrium, exact))
    if touching and renew_key(keys[1], row, FOR_CONTACT):
        generator, watched, h, equilibrium = contact(p, rigid)
        _write_contact(packed, tabulate_flow(old.contact, generator, p.eta, watched, h, equilibrium, exact))
