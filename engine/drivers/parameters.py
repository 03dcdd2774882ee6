"""A system, an η and a method as the parameters from which compiled code sets up a solver."""

from ..kernels.equations.contact_law import KELVIN_VOIGT, LAWS
from ..kernels.parameters import Parameters
from ..methods import Method, Newmark, Reference
from ..model import System


def parameters_of(system: System, eta: float, method: Method) -> Parameters:
    """The parameters of one run; 0 for those that its method does not have."""
    rigid = isinstance(method, Reference)
    law = LAWS.index(method.law) if isinstance(method, Newmark) else KELVIN_VOIGT
    return Parameters(
        eta=float(eta),
        kappa=system.kappa,
        d1=system.d1,
        d2=system.d2,
        steps=float(method.steps) if isinstance(method, Newmark) else 0.0,
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
