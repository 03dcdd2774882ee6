"""Powers as quadratic forms of the state, and their integrals over a phase.

Between two events the state z = (ξ₁ − ξ₁*, ξ₁′, g − g*, g′, cos ητ, sin ητ) relative to the equilibrium of the phase
obeys z′ = A z (:mod:`..kernels.linear.tables`). The powers depend on velocities and excitation alone, so that the
equilibrium does not matter to them. Every power is a quadratic form zᵀVz, with the integral over a duration s

    ∫₀ˢ zᵀVz dτ = z(0)ᵀ G(s) z(0),    G(s) = ∫₀ˢ E(τ)ᵀ V E(τ) dτ,    G(2s) = G(s) + E(s)ᵀ G(s) E(s)     (50)

with E(τ) = exp(Aτ). G and E follow for short durations from their Taylor series, and for longer ones by doubling,
where E(2s) = E(s)².
"""

from typing import NamedTuple

import numpy as np
from vibroscope.engine.drivers.parameters import equilibria, generators, parameters_of
from vibroscope.engine.methods import Method
from vibroscope.engine.model import System
from vibroscope.engine.result import Response

_TERMS = 16  # of the series in A s with |A| s ≤ 1/4
_STATE = np.eye(6)
_X1, _V1, _GAP, _RATE, _COSINE, _SINE = _STATE


class EnergyForms(NamedTuple):
    """Generators of the phases of a motion, and its powers and energy as quadratic forms of z.

    The phases are flight, contact, and the last part of a chatter, in which the pendulums move as one while infinitely
    many impacts dissipate their relative motion.
    """

    generators: tuple[np.ndarray, ...]  # (6, 6) of each phase
    powers: tuple[np.ndarray, ...]  # (3, 6, 6) of each phase: excitation, dampers, contact damper
    equilibria: tuple[np.ndarray, ...]  # (6,) of each phase, relative to that of the flight
    stored: np.ndarray  # (6, 6) E without the contact spring, of z relative to the equilibrium of the flight
    free_position: float  # ξ₁ and gap there
    free_gap: float
    stiffness: float  # of the contact spring
    mass_share: float
    ends: tuple[
        np.ndarray, ...
    ]  # (6,) rows of the quantities that vanish where flight and contact end, of the same z …
    levels: tuple[float, ...]  # … less these numbers
    rigid: bool


def energy_forms(response: Response) -> EnergyForms:
    """Return the quadratic forms of a response of a closed-form solver, or with located steps."""
    return forms_of(response.system, response.eta, response.method)


def forms_of(system: System, eta: float, method: Method) -> EnergyForms:
    """The quadratic forms of a system with one stop, or with its first one alone."""
    c = system.with_first_stop
    p = parameters_of(c, eta, method)  # in which a wall is body 1 that never moves
    mu, x2, v2 = p.mu, _X1 + _GAP, _V1 + _RATE
    phases = generators(c, eta, method)
    load1, push = (row[4] * _COSINE + row[5] * _SINE for row in (phases[0][1], phases[0][3]))
    work = _product(load1, _V1) + mu * _product(load1 + push, v2)
    dampers = 2 * p.d1 * _product(_V1) + 2 * mu * p.damper2 * _product(v2)
    if c.rests_afar:
        springs = 0.5 * p.kappa**2 * _product(_GAP) - p.pull * _product(_X1, _GAP)
    else:
        springs = 0.5 * (p.spring1 * _product(_X1) + mu * p.kappa**2 * _product(x2))
    zero = np.zeros((6, 6))
    rigid = method.rigid
    if rigid:
        dissipated = np.array([2 * (1 + mu) * p.damper3 * _product(_V1), zero])
        # the contact force is proportional to g″ of the motion without contact
        ends, levels = (_GAP, phases[0][3]), (p.free_gap, 0.0)
    else:
        dissipated = np.array([dampers, 2 * (method.damping or 0.0) * _product(_RATE)])
        ends, levels = (_GAP, _GAP), (p.free_gap, p.free_gap)
    return EnergyForms(
        generators=phases,
        powers=(np.array([work, dampers, zero]), np.array([work, *dissipated]), np.array([work, dampers, zero])),
        equilibria=equilibria(c, eta, method),
        stored=0.5 * (_product(_V1) + mu * _product(v2)) + springs,
        free_position=p.free_position,
        free_gap=p.free_gap,
        stiffness=0.0 if rigid else method.stiffness,
        mass_share=c.mass_share,
        ends=ends,
        levels=levels,
        rigid=rigid,
    )


def _product(row: np.ndarray, other: np.ndarray | None = None) -> np.ndarray:
    """Return the symmetric V with zᵀVz = (row·z)(other·z), (6, 6); by default the square of row·z."""
    other = row if other is None else other
    return 0.5 * (np.outer(row, other) + np.outer(other, row))


def phase_integrals(generator: np.ndarray, powers: np.ndarray, durations: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return E(s) − 1, (n, 6, 6), and G(s) of each power, (n, 3, 6, 6), for n durations s.

    E − 1 is doubled rather than E, so that a slow motion keeps its digits beside a stiff contact.
    """
    # scaled by its own frequency, the gap of a stiff contact has the size of its rate
    frequency = np.sqrt(max(1.0, np.abs(generator[3, 2])))
    scale = np.array([1.0, 1.0, 1.0 / frequency, 1.0, 1.0, 1.0])
    a = generator * (scale[None, :] / scale[:, None])
    forms = powers * (scale[:, None] * scale[None, :])
    longest = np.abs(a).sum(axis=1).max() * durations.max(initial=0.0)
    doublings = max(0, int(np.ceil(np.log2(max(longest, 1e-300) * 4))))
    h = (durations / 2.0**doublings)[:, None, None]
    change, power = np.zeros((len(durations), 6, 6)), np.eye(6)
    integral, form = np.zeros((len(durations), 3, 6, 6)), forms.copy()
    for k in range(1, _TERMS):
        integral += form * h[:, None] ** k
        form = (a.T @ form + form @ a) / (k + 1)
        power = power @ a / k
        change += power * h**k
    for _ in range(doublings):
        move = change[:, None] + np.eye(6)
        integral += np.swapaxes(move, 2, 3) @ integral @ move
        change = 2 * change + change @ change
    return change * (scale[:, None] / scale[None, :]), integral / (scale[:, None] * scale[None, :])
