"""A step of a one-step method as a matrix for each contact status, from its textbook form.

The matrices map x = (y, cos ητ₀, sin ητ₀, 1), with y = (ξ₁, ξ₂, ξ₁′, ξ₂′, ξ₁″, ξ₂″, λ) at the beginning τ₀ of a step
and displacements counted from the static equilibrium of the separated bodies, to y and the gap, where the contact law
takes both; λ is the force of spring and damper, whether it acts or not. All quantities are written as rows of factors
of x and of the unknown accelerations, so that Eqs. (14) and (15) of :mod:`..integrators` stand here as they are.
"""

import math
from functools import cache
from typing import NamedTuple

import numpy as np
from vibroscope.engine.integrators import Integrator, Stage
from vibroscope.engine.kernels.compile.options import uncompiled
from vibroscope.engine.kernels.equations.contact_law import force
from vibroscope.engine.kernels.equations.motion import coefficients, load_rate
from vibroscope.engine.kernels.parameters import Parameters
from vibroscope.engine.kernels.time_stepping.linear_step import BEFORE, CLOSING, COLUMNS, FORCE, OWN, STATE_ROWS

BETWEEN = np.array([-1.0, 1.0])  # the gap is that of the equilibrium and this times the displacements
AMPLIFYING = 1 + 1e-5  # spectral radius beyond which steps amplify; rounding gives up to 4e-6 with huge ωΔτ


class Bodies(NamedTuple):
    """Matrices, (2, 2), of the bodies, their loads as factors of cos ητ and sin ητ, and the contact."""

    mass: np.ndarray
    damping: np.ndarray
    stiffness: np.ndarray
    loads: np.ndarray
    reaction: np.ndarray  # what a unit of λ does to each body, (2,)
    pull: np.ndarray  # constant forces that no equilibrium holds, (2,)
    contact: tuple[float, float]  # K and D
    gap: float  # at the equilibrium
    eta: float  # frequency of the load; 0: it is linear between steps


class Kinematics(NamedTuple):
    """Displacements, velocities and accelerations, (2, …) each, as rows of factors."""

    q: np.ndarray
    v: np.ndarray
    a: np.ndarray


def bodies_of(p: Parameters) -> Bodies:
    """The matrices of Eqs. (1) and (2), the second times μ."""
    c = uncompiled(coefficients)(p)
    scale = np.array([1.0, c.mu])
    loads = np.array([c.load1, np.add(c.load1, c.push)]) * scale[:, None]
    reaction, contact = np.array([-c.react1, 1.0]), (p.stiffness, p.damping)
    diagonals = (np.diag(scale * pair) for pair in ([1.0, 1.0], [c.c1, c.c2], [c.k1, c.k2]))
    mass, damping, stiffness = diagonals
    stiffness[1, 0] = -c.mu * c.coupling
    pull = scale * [c.pull1, c.pull2]
    return Bodies(mass, damping, stiffness, loads, reaction, pull, contact, p.free_gap, uncompiled(load_rate)(p))


def stage_end(
    b: Bodies,
    integrator: Integrator,
    stage: Stage,
    points: list[Kinematics],
    begun: np.ndarray,
    status: int,
    h: float,
    given: np.ndarray | None = None,
) -> tuple[Kinematics, np.ndarray, np.ndarray, np.ndarray]:
    """The end of a stage with a status, 0 or 1, λ, the gap there and its rate.

    Parameters
    ----------
    points : list of Kinematics
        The beginning of the step, and the ends of the stages before.
    begun : (n + 2,) ndarray
        λ that acted at the beginning; n: COLUMNS, or more with forces that are given.
    given : (n + 2,) ndarray, optional
        λ that acts instead of that of spring and damper.
    """
    n = len(begun) - 2
    cosine, sine, one = COLUMNS - 3, COLUMNS - 2, COLUMNS - 1
    unit = np.eye(n + 2)
    first, acceleration = points[0], unit[n:]

    def sum_of(weights, name):
        return sum(weight * getattr(point, name) for weight, point in zip(weights, points, strict=True))

    half = first.v + h * sum_of(stage.rates, "a")
    v = half + h * stage.gamma * acceleration  # Eq. (14)
    q = first.q + h * sum_of(stage.velocities, "v")
    q = q + h * h * (sum_of(stage.accelerations, "a") + stage.beta * acceleration)

    def between(end, beginning, share=stage.alpha_f):
        return (1.0 - share) * end + share * beginning

    def load(share):
        if b.eta == 0.0:
            return b.loads @ np.array([unit[cosine] + share * h * unit[sine], unit[sine]])
        angle = b.eta * share * h
        c, s = math.cos(angle), math.sin(angle)
        return b.loads @ np.array([c * unit[cosine] - s * unit[sine], s * unit[cosine] + c * unit[sine]])

    damped = half if stage.leaves_out else v
    felt_q, felt_v = between(q, first.q), between(damped, first.v, stage.velocity_share)
    if integrator.averaged:
        gap, rate, loads = b.gap * unit[one] + BETWEEN @ q, BETWEEN @ v, between(load(stage.end), load(0.0))
    else:
        gap, rate = b.gap * unit[one] + BETWEEN @ felt_q, BETWEEN @ felt_v
        loads = load(stage.end * (1.0 - stage.alpha_f))
    loads = loads + np.outer(b.pull, unit[one])
    spring = uncompiled(force)(*b.contact, gap, rate)  # Eq. (5)
    now = status * spring if given is None else given
    acting = between(now, begun) if integrator.averaged else now
    inertia = b.mass @ ((1.0 - stage.alpha_m) * acceleration + stage.alpha_m * first.a)
    balance = loads + np.outer(b.reaction, acting) - inertia - b.damping @ felt_v - b.stiffness @ felt_q  # Eq. (15)
    found = np.linalg.solve(-balance[:, n:], balance[:, :n])

    def known(rows):
        filled = np.zeros_like(rows)
        filled[..., :n] = rows[..., :n] + rows[..., n:] @ found
        return filled

    return Kinematics(known(q), known(v), known(acceleration)), known(spring), known(gap), known(rate)


def start_of_step(columns: int = COLUMNS) -> Kinematics:
    """The beginning of a step, as rows of so many factors and of the unknown accelerations."""
    unit = np.eye(columns + 2)
    return Kinematics(unit[0:2], unit[2:4], unit[4:6])


def step_maps(b: Bodies, integrator: Integrator, h: float) -> np.ndarray:
    """All stages of a step of size ``h`` with each status.

    Returns
    -------
    (2 or 6, STATE_ROWS + 1, COLUMNS) ndarray
        The first stage without and with contact; then the second stage likewise, after the first without contact, and
        after it with contact. The last row is the gap.
    """
    begun, start = np.eye(COLUMNS + 2)[FORCE], start_of_step()
    first, *later = integrator.stages
    ends = [stage_end(b, integrator, first, [start], begun, status, h) for status in (0, 1)]
    if later:
        firsts = [point for point, *_ in ends]
        ends += [stage_end(b, integrator, later[0], [start, one], begun, s, h) for one in firsts for s in (0, 1)]
    rows = [np.vstack([*point, spring, gap]) for point, spring, gap, _ in ends]
    return np.array(rows)[:, :, :COLUMNS]


def law_maps(b: Bodies, integrator: Integrator, h: float) -> np.ndarray:
    """All stages of a step of size ``h`` without contact, and what forces of a unit add.

    Returns
    -------
    (1 or 2, STATE_ROWS + 2, CLOSING) ndarray
        The last rows are the gap and its rate; the columns OWN and BEFORE belong to λ of the stage, and of that before.
    """
    unit = np.eye(CLOSING + 2)
    points, maps = [start_of_step(CLOSING)], []
    forces = [unit[OWN]] if len(integrator.stages) == 1 else [unit[BEFORE], unit[OWN]]
    for stage, given in zip(integrator.stages, forces, strict=True):
        point, _, gap, rate = stage_end(b, integrator, stage, points, unit[FORCE], 0, h, given)
        points.append(point)
        maps.append(np.vstack([*point, np.zeros(CLOSING + 2), gap, rate])[:, :CLOSING])
    if len(maps) > 1:
        maps[0][:, [OWN, BEFORE]] = maps[0][:, [BEFORE, OWN]]
    return np.array(maps)


def spectral_radius(maps: np.ndarray, status: int) -> float:
    """Largest |eigenvalue| of a step whose stages all have this status."""
    whole = maps[status if len(maps) == 2 else 2 + 3 * status]
    matrix = whole[:STATE_ROWS, :STATE_ROWS].copy()
    matrix[FORCE] *= status
    return float(np.abs(np.linalg.eigvals(matrix)).max())


def damps(integrator: Integrator) -> bool:
    """Whether an undamped oscillator loses energy in a step of one radian: numerical damping."""
    none, unit = np.zeros((2, 2)), np.eye(2)
    oscillator = Bodies(unit, none, unit, none, np.zeros(2), np.zeros(2), (0.0, 0.0), 0.0, 1.0)
    return spectral_radius(step_maps(oscillator, integrator, 1.0), 0) < 1 / AMPLIFYING


@cache
def felt_late(integrator: Integrator) -> float:
    """The share of λ at the end of a step, times Δτ, that a free body feels in the steps after it, without contact."""
    none, unit = np.zeros((2, 2)), np.eye(2)
    body = Bodies(unit, none, none, none, np.array([0.0, 1.0]), np.zeros(2), (0.0, 0.0), 0.0, 1.0)
    maps = step_maps(body, integrator, 1.0)
    v, a = maps[0 if len(maps) == 2 else 2][[3, 5]]
    return float(v[5] / (1.0 - a[5]) * (1.0 + a[FORCE]) + v[FORCE])  # v + … stays what it is from step to step


def is_stable(b: Bodies, integrator: Integrator, h: float, status: int) -> bool:
    """Whether a step of this size, repeated with this status, amplifies no motion, be there dampers or not."""
    undamped = b._replace(damping=0.0 * b.damping, contact=(b.contact[0], 0.0))
    radii = [spectral_radius(step_maps(one, integrator, h), status) for one in (b, undamped)]
    return max(radii) <= AMPLIFYING
