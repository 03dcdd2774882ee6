"""A system, an η and a method as the parameters from which compiled code sets up a solver."""

import math
from collections.abc import Mapping

import numpy as np

from ..kernels.equations.contact_law import KELVIN_VOIGT, LAWS
from ..kernels.equations.motion import (
    free_equilibrium,
    joined_equilibrium,
    joined_generator,
    pressed_equilibrium,
    pressed_generator,
    separated_generator,
)
from ..kernels.linear.tables import full_generator
from ..kernels.parameters import Parameters
from ..law_table import damper_of
from ..methods import Method
from ..model import System


def parameters_of(system: System, eta: float, method: Method) -> Parameters:
    """The parameters of one run; 0 for those that its method does not have."""
    rigid, wall = method.rigid, system.wall
    law = LAWS.index(LAWS[KELVIN_VOIGT] if rigid else method.law)
    base, force1, force2 = (system.excitation.harmonic(name, eta) for name in ("base", "force1", "force2"))
    mu = 1.0 if wall else system.mass_ratio
    gain, relative = (0.0, False) if rigid else damper_of(system, method)
    position, gap, pull = 0.0 if wall else system.separate_rest[0], system.static_gap, 0.0
    if system.rests_afar:
        position, gap, pull = -1.0, 0.0, system.spring1 * system.clearance - system.excitation.constant1
    return Parameters(
        eta=float(eta),
        kappa=math.sqrt(system.spring1) if wall else system.kappa,
        d1=system.d1,
        damper2=system.d1 if wall else system.d2 * system.kappa,
        steps=float(method.steps),
        wall=float(wall),
        base_cosine=base[0],
        base_sine=base[1],
        force1_cosine=force1[0],
        force1_sine=force1[1],
        push_cosine=force2[0] / mu - force1[0],
        push_sine=force2[1] / mu - force1[1],
        free_position=position,
        free_gap=gap,
        pull=pull,
        clearance=system.clearance,
        kappa3=1.0 if wall else system.kappa3,
        d3=system.joint_damping(method.joint_damping) if rigid else 0.0,
        mu=mu,
        mass_share=system.mass_share,
        stiffness_share=system.stiffness_share,
        stiffness=0.0 if rigid else method.stiffness,
        damping=0.0 if rigid else method.damping or 0.0,
        restitution=system.restitution,
        threshold=method.threshold if rigid else 0.0,
        law=float(law),
        exponent=0.0 if rigid else method.spring_exponent,
        penetration=(0.0 if rigid else method.penetration) or 0.0,
        stiffening=(0.0 if rigid else method.stiffening) or 0.0,
        gain=gain,
        relative=float(relative),
    )


def loads(system: System, eta: float) -> tuple[np.ndarray, np.ndarray]:
    """The load of each body, per unit of its mass, as factors of cos ητ and sin ητ, (2,) each; zeros for a wall."""
    base, force1, force2 = (np.array(system.excitation.harmonic(name, eta)) for name in ("base", "force1", "force2"))
    first = eta * eta * base + force1
    return first, np.zeros(2) if system.wall else eta * eta * base + force2 / system.mass_ratio


def parameter_rows(rows: np.ndarray, columns: Mapping[str, np.ndarray]) -> np.ndarray:
    """Rows of parameters, (n, len(Parameters)), with the columns of these names replaced, in place."""
    for name, values in columns.items():
        rows[:, Parameters._fields.index(name)] = values
    return rows


def at_eta(rows: np.ndarray, eta: np.ndarray, power: int | np.ndarray) -> np.ndarray:
    """Rows of parameters at η = 1, where all amplitudes of the base are the same, at other η, (n,), in place.

    ``power``: the p of the amplitude base/ηᵖ (:class:`..excitation.Excitation`), or one for each row.
    """
    columns = [Parameters._fields.index(name) for name in ("base_cosine", "base_sine")]
    rows[:, columns] /= (eta**power)[:, None]
    return parameter_rows(rows, {"eta": eta})


def generators(system: System, eta: float, method: Method) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """A of z′ = A z, (6, 6), in flight, in contact, and of the common motion without the measured joint damping.

    z is relative to the equilibrium of each (:func:`equilibria`).
    """
    p = parameters_of(system, eta, method)
    joined = joined_generator(p._replace(d3=system.derived_joint_damping))
    contact = joined_generator(p) if method.rigid else pressed_generator(p)
    return tuple(full_generator(rows, eta) for rows in (separated_generator(p), contact, joined))


def equilibria(system: System, eta: float, method: Method) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """z at the equilibrium of each of these motions, (6,), relative to that of the flight."""
    p = parameters_of(system, eta, method)
    free, joined = np.array(free_equilibrium(p)), np.array(joined_equilibrium(p))
    contact = joined if method.rigid else np.array(pressed_equilibrium(p))
    found = np.zeros((3, 6))
    found[:, [0, 2]] = np.array([free, contact, joined]) - free
    return tuple(found)
