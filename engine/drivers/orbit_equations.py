"""Which equations the orbits of a method solve."""

from ..methods import ExactPenalty, Newmark, Reference
from ..model import System
from .law_driven import needs_law
from .law_orbit import LawOrbitEquations
from .located_orbit import LocatedOrbitEquations
from .orbit import OrbitEquations

Equations = OrbitEquations | LawOrbitEquations | LocatedOrbitEquations
Followed = Reference | ExactPenalty | Newmark  # methods whose orbits have equations


def equations_of(system: System, eta: float, method: Followed, like: Equations | None = None) -> Equations:
    """The equations of the orbits of a system, η and method; ``like``: others of the same family."""
    if type(like) is OrbitEquations:
        return OrbitEquations(system, eta, method, like)
    if isinstance(method, Newmark):
        return LocatedOrbitEquations(system, eta, method)
    kind = LawOrbitEquations if needs_law(method) else OrbitEquations
    return kind(system, eta, method, like)
