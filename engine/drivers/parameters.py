"""A system, an η and a method as the parameters from which compiled code sets up a solver."""

from collections.abc import Mapping

import numpy as np

from ..kernels.equations.contact_law import KELVIN_VOIGT, LAWS
from ..kernels.equations.motion import joined_generator, pressed_generator, separated_generator
from ..kernels.linear.tables import full_generator
from ..kernels.parameters import Parameters
from ..methods import Method, Reference
from ..model import System


def parameters_of(system: System, eta: float, method: Method) -> Parameters:
    """The parameters of one run; 0 for those that its method does not have."""
    rigid = isinstance(method, Reference)
    law = LAWS.index(getattr(method, "law", LAWS[KELVIN_VOIGT]))
    return Parameters(
        eta=float(eta),
        kappa=system.kappa,
        d1=system.d1,
        d2=system.d2,
        steps=float(getattr(method, "steps", 0)),
        kappa3=system.kappa3,
        d3=system.joint_damping(method.joint_damping) if rigid else 0.0,
        mu=system.mass_ratio,
        mass_share=system.mass_share,
        stiffness=0.0 if rigid else method.stiffness,
        damping=0.0 if rigid else method.damping,
        restitution=system.restitution,
        threshold=method.threshold if rigid else 0.0,
        law=float(law),
    )


def parameter_rows(rows: np.ndarray, columns: Mapping[str, np.ndarray]) -> np.ndarray:
    """Rows of parameters, (n, len(Parameters)), with the columns of these names replaced, in place."""
    for name, values in columns.items():
        rows[:, Parameters._fields.index(name)] = values
    return rows


def generators(system: System, eta: float, method: Method) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """A of z′ = A z, (6, 6), in flight, in contact, and of the common motion without the measured joint damping."""
    p = parameters_of(system, eta, method)
    joined = joined_generator(eta, system.kappa3, system.derived_joint_damping)
    contact = joined_generator(eta, p.kappa3, p.d3) if isinstance(method, Reference) else pressed_generator(p)
    return tuple(full_generator(rows, eta) for rows in (separated_generator(p), contact, joined))
