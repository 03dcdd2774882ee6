"""A system, an η and a method as the parameters from which compiled code sets up a solver."""

import math
from collections.abc import Mapping
from dataclasses import replace

import numpy as np
from vibroscope.engine.kernels.equations.contact_law import KELVIN_VOIGT
from vibroscope.engine.kernels.equations.motion import (
    free_equilibrium,
    joined_equilibrium,
    joined_generator,
    load_rate,
    pressed_equilibrium,
    pressed_generator,
    separated_generator,
)
from vibroscope.engine.kernels.linear.tables import full_generator
from vibroscope.engine.kernels.parameters import Parameters
from vibroscope.engine.law_table import CONTACT_LAWS, damper_of
from vibroscope.engine.methods import Method
from vibroscope.engine.model import System


def parameters_of(system: System, eta: float, method: Method) -> Parameters:
    """The parameters of one run; 0 for those that its method does not have.

    Raises
    ------
    ValueError
        If there is a second stop.
    """
    if system.two_stops:
        raise ValueError(
            f"clearance2 = {system.clearance2:g}: the parameters of one stop are asked for, and there are two: take "
            "those of both, or of System.with_first_stop"
        )
    return parameters_of_stops(system, eta, method)[0]


def parameters_of_stops(system: System, eta: float, method: Method) -> tuple[Parameters, ...]:
    """The parameters as seen from each stop: one or two."""
    first, *others = (_as_seen(seen, eta, own) for seen, own in seen_from_stops(system, method))
    others = [other._replace(sign=-1.0) for other in others]
    if system.excitation.load is not None:  # the same load, with the other sign
        others = [at_start(other, -1.0) for other in others]
    return first, *others


def seen_from_stops(system: System, method: Method) -> list[tuple[System, Method]]:
    """The system and the method as seen from each stop: one or two."""
    found = [(system, method)]
    if system.two_stops:
        if not method.rigid:
            damping = None if method.damping is None else system.damping_factor2 * method.damping
            method = replace(method, stiffness=system.stiffness_factor2 * method.stiffness, damping=damping)
        found.append((system.mirrored, method))
    return found


def _as_seen(system: System, eta: float, method: Method) -> Parameters:
    rigid, wall = method.rigid, system.wall
    law = KELVIN_VOIGT if rigid else CONTACT_LAWS.index(method.law)
    base, force1, force2 = (system.excitation.harmonic(name, eta) for name in ("base", "force1", "force2"))
    load, pulse = system.excitation.load, -1.0
    if load is not None:
        load.check_period(2 * math.pi / eta)
        pulse = 0.0 if method.has_step else load.frequency
    mu = 1.0 if wall else system.mass_ratio
    gain, relative = (0.0, False) if rigid else damper_of(system, method)
    position, gap, pull = 0.0 if wall else system.separate_rest[0], system.static_gap, system.free_pull
    if system.has_free_body:  # it may rest anywhere: where it touches
        position, gap = position + (0.0 if system.spring1 else gap), 0.0
    if system.rests_afar:
        position, gap, pull = -1.0, 0.0, system.spring1 * system.clearance - system.excitation.constant1
    return Parameters(
        eta=float(eta),
        kappa=math.sqrt(system.spring1) if wall else system.kappa,
        d1=system.d1,
        spring1=1.0 if wall else system.spring1,
        damper2=system.d1 if wall else system.damper2,
        steps=float(method.steps),
        wall=float(wall),
        pulse=pulse,
        base_cosine=base[0],
        base_sine=base[1],
        force1_cosine=force1[0],
        force1_sine=force1[1],
        push_cosine=force2[0] / mu - force1[0],
        push_sine=force2[1] / mu - force1[1],
        free_position=position,
        free_gap=gap,
        pull=pull,
        pull1=system.free_pulls[0],
        clearance=system.clearance,
        kappa3=1.0 if wall else system.kappa3,
        damper3=system.joint_damper(method.joint_damping) if rigid else 0.0,
        mu=mu,
        mass_share=system.mass_share,
        stiffness_share=0.0 if system.has_free_body else system.stiffness_share,
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
        play=system.play,
        sign=1.0,
    )


def at_start(p: Parameters, load: float) -> Parameters:
    """The parameters with which a load that is one at τ = 0, as a cosine, is another number."""
    factors = ("base_cosine", "force1_cosine", "push_cosine")
    return p if load == 1.0 else p._replace(**{name: load * getattr(p, name) for name in factors})


def loads(system: System, eta: float) -> tuple[np.ndarray, np.ndarray]:
    """The load of each body, per unit of its mass, as factors of cos ητ and sin ητ, (2,) each; zeros for a wall."""
    base, force1, force2 = (np.array(system.excitation.harmonic(name, eta)) for name in ("base", "force1", "force2"))
    first = eta * eta * base + force1
    return first, np.zeros(2) if system.wall else eta * eta * base + force2 / system.mass_ratio


def parameter_rows(rows: np.ndarray, columns: Mapping[str, np.ndarray]) -> np.ndarray:
    """Rows of parameters, (…, len(Parameters)), with the columns of these names replaced, in place."""
    for name, values in columns.items():
        rows[..., Parameters._fields.index(name)] = values
    return rows


def at_eta(rows: np.ndarray, eta: np.ndarray, power: np.ndarray) -> np.ndarray:
    """Rows of parameters at η = 1, where all amplitudes of the base are the same, at other η, in place.

    ``power``: the p of the amplitude base/ηᵖ (:class:`..excitation.Excitation`); as η, for each row.
    """
    columns = [Parameters._fields.index(name) for name in ("base_cosine", "base_sine")]
    rows[..., columns] /= (eta**power)[..., None]
    return parameter_rows(rows, {"eta": eta})


def generators(system: System, eta: float, method: Method) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """A of z′ = A z, (7, 7), in flight, in contact, and of the common motion without the measured joint damping.

    z is relative to the equilibrium of each (:func:`equilibria`); its last number is 1, for a force that has none.
    """
    p = parameters_of(system, eta, method)
    joined = joined_generator(p._replace(damper3=system.joint_damper("derived")))
    contact = joined_generator(p) if method.rigid else pressed_generator(p)
    rate = load_rate(p)
    found = np.zeros((3, 7, 7))
    for a, rows in zip(found, (separated_generator(p), contact, joined), strict=True):
        a[:6, :6], a[:4, 6] = full_generator(rows, rate), rows[:, 6]
    return tuple(found)


def equilibria(system: System, eta: float, method: Method) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """z at the equilibrium of each of these motions, (7,), relative to that of the flight, and so with 0 at its end."""
    p = parameters_of(system, eta, method)
    free, joined = np.array(free_equilibrium(p)), np.array(joined_equilibrium(p))
    contact = joined if method.rigid else np.array(pressed_equilibrium(p))
    found = np.zeros((3, 7))
    found[:, [0, 2]] = np.array([free, contact, joined]) - free
    return tuple(found)
