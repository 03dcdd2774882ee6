"""The solution methods, as frozen objects that hold their validated numbers and nothing else."""

from dataclasses import dataclass, field
from typing import ClassVar

from .arguments import shown
from .integrators import Integrator, NewmarkBeta
from .kernels.equations.contact_law import LAWS as CONTACT_LAWS
from .model import flag, one_of, require, whole

JOINT_DAMPINGS = ("table", "derived")
THRESHOLD_RANGE = (0.0, 1e3)
STIFFNESS_RANGE = (1e-6, 1e12)
DAMPING_RANGE = (0.0, 1e9)
STEPS_RANGE = (4, 10_000_000)
CONTACT_STATUSES = ("start", "end")
WITHOUT_SOLUTION = ("stop", "keep", "halve")
INITIAL_ACCELERATIONS = ("equation", "zero")


@dataclass(frozen=True)
class Reference:
    """Semi-analytical reference: closed form between events, Newton's impact law (paper, section 2).

    Attributes
    ----------
    joint_damping : {"table", "derived"}
        Damping of the joined pendulums: measured (Table 1), or what the two dampers add up to, which a penalty model
        tends to as K → ∞.
    threshold : float
        ε: an impact that leaves a parting speed of at most ε under compression begins a permanent contact. It is
        counted as all speeds are, in the unit of length times ω₁, and so scales with the system. 0 is the limit ε → 0:
        a chatter has infinitely many impacts, which are summed in closed form.

    Raises
    ------
    ValueError
        If a value is out of range.
    """

    joint_damping: str = "table"
    threshold: float = 0.002
    name: ClassVar[str] = "reference"

    def __post_init__(self):
        one_of("joint_damping", self.joint_damping, JOINT_DAMPINGS)
        advice = "give a parting speed, or 0 for its limit; the paper uses 0.002"
        object.__setattr__(self, "threshold", require("threshold", self.threshold, *THRESHOLD_RANGE, advice))


@dataclass(frozen=True)
class ExactPenalty:
    """Penalty contact without a time step: closed form in flight and in contact.

    Newmark's solution tends to it as Δτ → 0.

    Attributes
    ----------
    stiffness : float
        K of the contact spring, in units of pendulum 1's own stiffness.
    damping : float
        D of the contact damper; the force is K(ξ₁ − ξ₂) + 2D(ξ₁′ − ξ₂′).

    Raises
    ------
    ValueError
        If a value is out of range.
    """

    stiffness: float
    damping: float
    name: ClassVar[str] = "exact"

    def __post_init__(self):
        _check_contact(self)


@dataclass(frozen=True)
class Newmark:
    """Penalty contact integrated by Newmark's method, α = ½, β = ¼, constant step T/n (paper, section 4).

    Attributes
    ----------
    stiffness : float
        K of the contact spring, in units of pendulum 1's own stiffness.
    damping : float
        D of the contact damper; the force is K(ξ₁ − ξ₂) + 2D(ξ₁′ − ξ₂′).
    steps : int
        n, steps per excitation period: Δτ = T/n.
    every_step : bool
        Take every step, as an FE code must, instead of skipping those in which contact does not change. The solution is
        the same but for rounding, the cost is not. Rounding shows where it is amplified: in chaotic motion after some
        hundred periods, and in the scatter that a coarse step causes.
    located : bool
        Cut a step at each contact change, located within it, instead of finding contact only at the start of steps;
        contacts shorter than some steps are resolved by shorter ones. All steps are taken; the cost counts each solve.
    law : {"kelvin-voigt", "cut"}
        Contact law: a spring and a damper, as in the paper, which may pull near the end of a contact; or the same cut
        at zero. With "cut" all steps are taken, none is located, and there is no `limit` yet to compare with.

    Raises
    ------
    ValueError
        If a value is out of range.
    """

    stiffness: float
    damping: float
    steps: int
    every_step: bool = False
    located: bool = False
    law: str = CONTACT_LAWS[0]
    name: ClassVar[str] = "newmark"

    def __post_init__(self):
        _check_contact(self)
        one_of("law", self.law, CONTACT_LAWS)
        for name in ("every_step", "located"):
            object.__setattr__(self, name, flag(name, getattr(self, name)))
        if self.located and self.law != CONTACT_LAWS[0]:
            raise ValueError(f"law = {self.law!r} has no located steps: leave located at False")
        _check_steps(self)

    @property
    def limit(self) -> ExactPenalty:
        """The solution that this one tends to as Δτ → 0; raises ValueError for a law that has none."""
        return _limit(self)


@dataclass(frozen=True)
class TimeStepping:
    """Penalty contact integrated by a one-step method of FE and physics codes, every step of T/n taken.

    Attributes
    ----------
    stiffness, damping, steps
        As those of :class:`Newmark`; with a method of two stages, both are within one step.
    integrator : Integrator
        One of :data:`engine.integrators.INTEGRATORS`; by default Newmark's method, α = ½, β = ¼.
    status : {"start", "end"}
        Whether a step is with contact is taken from the gap at its start, or iterated until it agrees with the gap at
        its end (where the integrator takes the contact force). Explicit integrators know the gap before the force and
        have nothing to iterate: they take "start" only.
    without_solution : {"stop", "keep", "halve"}
        With status "end", what a step does in which neither status agrees with its own end: end the run with the status
        ``without-solution``; keep the former status; or be cut into 2, 4, … 1024 parts until all of them have a
        solution.
    law : {"kelvin-voigt", "cut"}
    initial_acceleration : {"equation", "zero"}
        ξᵢ″ at τ = 0 from the equations of motion, or zero, as OpenSees has it unless it is given.

    Raises
    ------
    ValueError
        If a value is out of range.
    """

    stiffness: float
    damping: float
    steps: int
    integrator: Integrator = field(default_factory=NewmarkBeta)
    status: str = CONTACT_STATUSES[0]
    without_solution: str = WITHOUT_SOLUTION[0]
    law: str = CONTACT_LAWS[0]
    initial_acceleration: str = INITIAL_ACCELERATIONS[0]
    name: ClassVar[str] = "time-stepping"

    def __post_init__(self):
        _check_contact(self)
        _check_steps(self)
        if not isinstance(self.integrator, Integrator):
            raise ValueError(f"integrator = {shown(self.integrator)} is not an Integrator, such as NewmarkBeta()")
        one_of("status", self.status, CONTACT_STATUSES)
        one_of("without_solution", self.without_solution, WITHOUT_SOLUTION)
        one_of("law", self.law, CONTACT_LAWS)
        one_of("initial_acceleration", self.initial_acceleration, INITIAL_ACCELERATIONS)
        if self.integrator.explicit and self.status != CONTACT_STATUSES[0]:
            name = self.integrator.name
            raise ValueError(f"{name} is explicit and knows the gap before the force: it has status = 'start' alone")

    @property
    def limit(self) -> ExactPenalty:
        """The solution that this one tends to as Δτ → 0; raises ValueError for a law that has none."""
        return _limit(self)


def _limit(method: Newmark | TimeStepping) -> ExactPenalty:
    known = CONTACT_LAWS[0]
    if method.law != known:
        raise ValueError(f"law = {method.law!r} is not solved in closed form, to compare with: use {known!r}")
    return ExactPenalty(method.stiffness, method.damping)


def _check_steps(method: Newmark | TimeStepping) -> None:
    n = whole("steps", method.steps, *STEPS_RANGE, "give steps per excitation period; the paper uses 2000 to 8000")
    object.__setattr__(method, "steps", n)


def _check_contact(method: ExactPenalty | Newmark | TimeStepping) -> None:
    k = require("K", method.stiffness, *STIFFNESS_RANGE, "give a contact stiffness; the paper uses 100 to 12000")
    d = require("D", method.damping, *DAMPING_RANGE, "give a contact damping; the paper uses 8 to 50")
    object.__setattr__(method, "stiffness", k)
    object.__setattr__(method, "damping", d)


Method = Reference | ExactPenalty | Newmark | TimeStepping
STEPPING = Newmark, TimeStepping  # methods with a time step


def is_located(method: Method) -> bool:
    """Whether a method cuts its steps where contact changes."""
    return getattr(method, "located", False) or getattr(method, "status", "") == "located"


def integrator_name(method: Newmark | TimeStepping) -> str:
    """The name of the integrator of a method with a time step."""
    return method.integrator.name if isinstance(method, TimeStepping) else NewmarkBeta.name


def status_of(method: Newmark | TimeStepping) -> str:
    """Where a method with a time step takes the contact status of its steps: "start", "end" or "located"."""
    return "located" if is_located(method) else getattr(method, "status", CONTACT_STATUSES[0])


def grid_steps(method: Method) -> int:
    """n of a method whose solution exists at the steps of its constant grid alone; 0 of the others."""
    return method.steps if isinstance(method, STEPPING) and not is_located(method) else 0


def refuse_time_stepping(method: Method, what: str) -> None:
    """Raise ValueError if ``what`` is asked of :class:`TimeStepping`, for which it does not exist yet."""
    if isinstance(method, TimeStepping):
        name = method.integrator.name
        raise ValueError(f"{what} is not available with {name}, contact at the {method.status} of steps: use Newmark")
