"""The stages of a one-step method as matrices (:mod:`..kernels.time_stepping.linear_step`), and what follows from them.

A *whole* step is linear, too, while no force acts, or that of one linear piece of the law in all of its stages.
"""

from collections.abc import Iterator, Sequence
from functools import cache
from typing import NamedTuple

import numpy as np
from vibroscope.engine.drivers.law_pieces import Piece
from vibroscope.engine.integrators import Integrator
from vibroscope.engine.kernels.compile.options import uncompiled
from vibroscope.engine.kernels.equations.motion import coefficients, load_rate
from vibroscope.engine.kernels.parameters import Parameters
from vibroscope.engine.kernels.time_stepping.law_step import linear_root
from vibroscope.engine.kernels.time_stepping.linear_step import (
    BEFORE,
    COLUMNS,
    FORCE,
    GAIN,
    GAP,
    OWN,
    RATE,
    ROWS,
    STATE_ROWS,
    fill_maps,
)
from vibroscope.engine.kernels.time_stepping.stage import STAGE_NUMBERS, Side, Stages, without_contact

AMPLIFYING = 1 + 1e-5  # spectral radius beyond which steps amplify; rounding gives up to 4e-6 with huge ωΔτ


class Bodies(NamedTuple):
    """The motion of the bodies without contact, Eq. (12), and their contact."""

    side: Side
    forcing: tuple  # f₁ and f as factors of cos ητ and sin ητ, and constants: (2, 3)
    reaction: tuple[float, float]  # what a unit of λ does to ξ₁″ and to g″
    contact: Piece  # spring and damper
    load_rate: float  # frequency of the load; 0: it is linear between steps


def bodies_of(p: Parameters) -> Bodies:
    """The motion without contact of a run."""
    c = uncompiled(coefficients)(p)
    reaction = -float(c.react1), float(c.inverse_mass)
    return Bodies(*without_contact(p), reaction, Piece(p.stiffness, p.damping), float(uncompiled(load_rate)(p)))


def stages_of(integrator: Integrator, reaction: tuple[float, float]) -> Stages:
    """The stages of an integrator for compiled code, at most two."""
    numbers = []
    for stage in integrator.stages:
        d, e, f = ((*row, 0.0)[:2] for row in (stage.velocities, stage.accelerations, stage.rates))
        damped = 0.0 if stage.leaves_out else stage.gamma
        shares = stage.alpha_m, stage.alpha_f, stage.velocity_share
        numbers.append((stage.end, *d, *e, stage.beta, *f, stage.gamma, *shares, damped))
    rows = (*numbers, (0.0,) * STAGE_NUMBERS)[:2]
    return Stages(len(numbers), integrator.averaged, reaction, tuple(tuple(map(float, row)) for row in rows))


def stage_maps(b: Bodies, integrator: Integrator, h: float) -> np.ndarray:
    """The columns of all stages of a step of size ``h``.

    Returns
    -------
    (1 or 2, GAIN, ROWS) ndarray
        As in :class:`..kernels.time_stepping.linear_step.LinearScheme`.
    """
    stages = stages_of(integrator, b.reaction)
    maps = np.zeros((stages.count, GAIN, ROWS))
    fill_maps(maps, b.side, b.forcing, stages, b.load_rate, h)
    return maps


class StageEnd(NamedTuple):
    """The end of a stage as rows of factors of x at the beginning of the step."""

    free: np.ndarray  # (ROWS, COLUMNS) without its contact force
    own: np.ndarray  # (ROWS,) what a unit of that adds
    push: np.ndarray  # (COLUMNS,) λ
    end: np.ndarray  # (ROWS, COLUMNS) with it


def stage_ends(maps: np.ndarray, forces: Sequence[Piece | None]) -> Iterator[StageEnd]:
    """The ends of all stages, each with the force of a piece of the law, or without."""
    push = np.zeros(COLUMNS)
    for columns, force in zip(maps, forces, strict=True):
        free, own = columns[:COLUMNS].T + np.outer(columns[BEFORE], push), columns[OWN]
        free[FORCE], push = 0.0, np.zeros(COLUMNS)
        if force:
            push = root_of_piece(force, free, own)
        yield StageEnd(free, own, push, free + np.outer(own, push))


def root_of_piece(piece: Piece, free: np.ndarray, own: np.ndarray) -> np.ndarray:
    """λ of a piece at the end of a stage, as a row of factors of x."""
    constant = piece.push * np.eye(COLUMNS)[-1]
    root = uncompiled(linear_root)
    return root(piece.stiffness, 2.0 * piece.damping, constant, free[GAP], free[RATE], own[GAP], own[RATE])


def spectral_radius(maps: np.ndarray, force: Piece | None = None) -> float:
    """Largest |eigenvalue| of a step with the force of one piece of the law, or without."""
    *_, last = stage_ends(maps, [force] * len(maps))
    return float(np.abs(np.linalg.eigvals(last.end[:STATE_ROWS, :STATE_ROWS])).max())


def damps(integrator: Integrator) -> bool:
    """Whether an undamped oscillator loses energy in a step of one radian: numerical damping."""
    oscillators = _free_bodies()._replace(side=Side(ax=-1.0, av=0.0, ag=0.0, au=0.0, bx=0.0, bv=0.0, bg=-1.0, bu=0.0))
    return spectral_radius(stage_maps(oscillators, integrator, 1.0)) < 1 / AMPLIFYING


def _free_bodies() -> Bodies:
    """Two bodies on which nothing acts but the force of their contact, on the second."""
    none = 0.0, 0.0, 0.0
    return Bodies(Side(*(0.0,) * len(Side._fields)), (none, none), (0.0, 1.0), Piece(0.0, 0.0), 1.0)


@cache
def felt_late(integrator: Integrator) -> float:
    """The share of λ at the end of a step, times Δτ, that a free body feels in the steps after it, without contact."""
    maps = stage_maps(_free_bodies(), integrator, 1.0)
    *_, last = stage_ends(maps, [None] * len(maps))
    v, a = last.end[[3, 5]]
    return float(v[5] / (1.0 - a[5]) * (1.0 + a[FORCE]) + v[FORCE])  # v + … stays what it is from step to step


def is_stable(b: Bodies, integrator: Integrator, h: float, status: int) -> bool:
    """Whether a step of this size, repeated with this status, amplifies no motion, be there dampers or not."""
    side, contact = b.side._replace(av=0.0, au=0.0, bv=0.0, bu=0.0), b.contact._replace(damping=0.0)
    both = b, b._replace(side=side, contact=contact)
    radii = [spectral_radius(stage_maps(one, integrator, h), one.contact if status else None) for one in both]
    return max(radii) <= AMPLIFYING
