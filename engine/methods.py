"""The solution methods, as frozen objects: their validated numbers, and what each of them is and can do.

Other modules ask a method for these, never for its class:

=====================  ==============================================================================================
``rigid``              the bodies do not penetrate each other: impacts by restitution, and a permanent contact
``has_step``           time is stepped through, with ``steps`` in an excitation period; 0 of the others
``located``            steps are cut where contact changes
``resolves_contacts``  … and contacts shorter than some steps are resolved by shorter ones
``plain``              steps are the paper's: average acceleration, contact from their start; the force may be cut
``skips_steps``        steps in which contact does not change are skipped: many take hardly longer than few
``grid_steps``         ``steps`` where the solution exists at those of the constant grid alone; else 0
``numbers``            what can be varied, by symbol: ``threshold``, or K, D and the steps where there are any
``is_newmarks``        :func:`Newmark` makes it
``has_choices``        integrator, contact status, law or steps without a solution are others than the paper's
``stages``             times that a step is solved for
``counts_solutions``   a step may have no solution, or two: its contact status is that of the end
``threshold``          parting speed below which a rigid contact lasts; 0 of the others
=====================  ==============================================================================================

All have the ``limit`` that they tend to with smaller steps.
Those that are not rigid have ``law``, ``stiffness``, ``damping``, the numbers of the law and ``spring_exponent``, those
with a step ``integrator`` and ``status``. Those with a step are one class: :func:`Newmark` makes the paper's.

Which numbers may vary: what the motions of a method and a system do not have is refused.
"""

from dataclasses import dataclass, field, fields, replace
from typing import ClassVar

from vibroscope.engine.arguments import flag, one_of, require, set_fields, shown, whole
from vibroscope.engine.integrators import Integrator, NewmarkBeta
from vibroscope.engine.law_table import (
    CONTACT_LAWS,
    HERTZ,
    LAW_NUMBERS,
    LAWS,
    LAWS_BY_RESTITUTION,
    NEWMARK_LAWS,
    laws_with,
    numbers_of,
    powers_of,
)
from vibroscope.engine.model import SECOND_STOP, System

JOINT_DAMPINGS = ("table", "derived")
THRESHOLD_RANGE = (0.0, 1e3)
STIFFNESS_RANGE = (1e-6, 1e12)
DAMPING_RANGE = (0.0, 1e12)
LARGEST_OF_POWER = 1e20  # K and D of a force that grows as a power of the depth, the units of which are other ones
STEPS_RANGE = (4, 10_000_000)
CONTACT_STATUSES = ("start", "end", "located")
EXPONENT_RANGE = (1.0, 10.0)
PENETRATION_RANGE = (0.0, 1e9)
STIFFENING_RANGE = (1.0, 1e6)
WITHOUT_SOLUTION = ("stop", "keep", "halve")
INITIAL_ACCELERATIONS = ("equation", "zero")
_FLAGS = "every_step", "resolves_contacts"


class _WithoutStep:
    has_step: ClassVar[bool] = False
    steps: ClassVar[int] = 0
    located: ClassVar[bool] = False
    plain: ClassVar[bool] = False
    is_newmarks: ClassVar[bool] = False
    skips_steps: ClassVar[bool] = False
    grid_steps: ClassVar[int] = 0
    counts_solutions: ClassVar[bool] = False
    stages: ClassVar[int] = 1
    has_choices: ClassVar[bool] = False

    @property
    def limit(self) -> "Reference | ExactPenalty":
        """Itself: there is no step that could tend to zero."""
        return self


class _Penalty:
    rigid: ClassVar[bool] = False
    threshold: ClassVar[float] = 0.0

    @property
    def numbers(self) -> dict[str, float | int | None]:
        """What can be varied, by the symbols of METHOD_NUMBERS: no steps if the method has none."""
        symbols = {symbol: name for symbol, name in METHOD_NUMBERS.items() if self.has_step or symbol != "steps"}
        return {symbol: getattr(self, name) for symbol, name in symbols.items()}

    @property
    def linear(self) -> bool:
        """Whether a contact is a spring and a damper as long as the bodies overlap."""
        return LAWS[self.law].linear

    @property
    def law_numbers(self) -> dict[str, float | None]:
        """Exponent, penetration and stiffening, as a method with the same law takes them."""
        return {name: getattr(self, name) for name in LAW_NUMBERS}

    @property
    def spring_exponent(self) -> float:
        """The power n of the force Kδⁿ of the contact spring: the method's own where its law takes one."""
        return powers_of(self.law, self.exponent)[0]


@dataclass(frozen=True)
class Reference(_WithoutStep):
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

    Examples
    --------
    >>> from vibroscope.engine import Reference, System, simulate
    >>> run = simulate(System(), 1.08, Reference(), periods=300, keep=12)
    >>> len(run.impacts.time) / 12  # in a period
    10.0
    """

    joint_damping: str = "table"
    threshold: float = 0.002
    name: ClassVar[str] = "reference"
    rigid: ClassVar[bool] = True

    def __post_init__(self):
        one_of("joint_damping", self.joint_damping, JOINT_DAMPINGS)
        advice = "give a parting speed, or 0 for its limit; the paper uses 0.002"
        set_fields(self, threshold=require("threshold", self.threshold, *THRESHOLD_RANGE, advice))

    @property
    def numbers(self) -> dict[str, float]:
        """The threshold, which alone can be varied."""
        return {"threshold": self.threshold}


@dataclass(frozen=True)
class ExactPenalty(_WithoutStep, _Penalty):
    """Penalty contact without a time step: closed form in flight, and in contact where the law is piecewise linear.

    Newmark's solution tends to it as Δτ → 0. In contact, a law that is not linear is integrated to 1e-12 by a method of
    high order, and the end of the contact is located.

    Attributes
    ----------
    stiffness : float
        K of the contact spring, in units of pendulum 1's own stiffness; the force is Kδⁿ for a penetration δ.
    damping : float or None
        D of the contact damper; the force of the first law is K(ξ₁ − ξ₂) + 2D(ξ₁′ − ξ₂′). All laws:
        :mod:`engine.kernels.equations.contact_law`, with c = 2D, or h = 2D/K. With None the law takes its damper from
        the restitution of the system and the closing speed of each touch, by the formula of its authors
        (:mod:`engine.law_table`).
    law : str
        One of :data:`engine.CONTACT_LAWS`.
    exponent : float
        n ≥ 1 of a law that takes it; that of "jankowski" is 1.5, that of a linear law 1.
    penetration : float or None
        Of "impact": the penetration from which on the damper acts in full; of "bilinear": the knee, at which the
        stiffness of the spring changes.
    stiffening : float or None
        Of "bilinear": r > 1, the stiffness of the spring beyond the knee over K.

    Raises
    ------
    ValueError
        If a value is out of range, or no number of the law.

    Examples
    --------
    >>> from vibroscope.engine import ExactPenalty
    >>> ExactPenalty(12000, 18)
    ExactPenalty(stiffness=12000.0, damping=18.0)
    >>> ExactPenalty(12000, None, law="flores").damping is None  # it follows from the restitution of the system
    True
    """

    stiffness: float
    damping: float | None
    law: str = CONTACT_LAWS[0]
    exponent: float = HERTZ
    penetration: float | None = None
    stiffening: float | None = None
    name: ClassVar[str] = "exact"

    def __post_init__(self):
        _check_contact(self)

    def __repr__(self) -> str:
        return _shown_numbers(self, "law", *LAW_NUMBERS)


@dataclass(frozen=True)
class TimeStepping(_Penalty):
    """Penalty contact integrated by a one-step method of FE and physics codes, constant step T/n.

    Attributes
    ----------
    stiffness : float
        K of the contact spring, in units of pendulum 1's own stiffness.
    damping : float or None
        D of the contact damper; the force of the first law is K(ξ₁ − ξ₂) + 2D(ξ₁′ − ξ₂′). None as that of
        :class:`ExactPenalty`.
    steps : int
        n, steps per excitation period: Δτ = T/n; with a method of two stages, both are within one step.
    integrator : Integrator
        One of :data:`engine.integrators.INTEGRATORS`; by default Newmark's method, α = ½, β = ¼.
    status : {"start", "end", "located"}
        Whether a step is with contact is taken from the gap at its start, or iterated until it agrees with the gap at
        its end (where the integrator takes the contact force). Explicit integrators know the gap before the force and
        have nothing to iterate: they do not take "end". "located" cuts a step at each contact change and
        each kink of the law, where the acceleration starts anew.
    without_solution : {"stop", "keep", "halve"}
        With status "end", what a step does in which neither status agrees with its own end: end the run with the status
        ``without-solution``; keep the former status; or be cut into 2, 4, … 1024 parts until all of them have a
        solution.
    law, exponent, penetration, stiffening
        As those of :class:`ExactPenalty`. The force of a law that is not linear is solved for within each step.
    initial_acceleration : {"equation", "zero"}
        ξᵢ″ at τ = 0 from the equations of motion, or zero, as OpenSees has it unless it is given.
    every_step : bool
        Take every step, as an FE code must, instead of skipping those in which contact does not change. The solution is
        the same but for rounding, the cost is not. Rounding shows where it is amplified: in chaotic motion after some
        hundred periods, and in the scatter that a coarse step causes. Located steps are all taken.
    resolves_contacts : bool
        With located steps of Newmark's method: contacts shorter than some steps are resolved by shorter ones, which an
        FE code does not do. The cost counts each solve.

    Raises
    ------
    ValueError
        If a value is out of range, or no number of the law, or choices do not go together.

    Examples
    --------
    >>> from vibroscope.engine import HHT, System, TimeStepping, simulate
    >>> method = TimeStepping(2500, 8, 500, integrator=HHT(alpha=-0.1), status="end")
    >>> run = simulate(System(), 2.76, method, periods=300)
    >>> print(run.status, run.message.partition(":")[0])
    without-solution step 2336 (period 5) has no solution
    """

    stiffness: float
    damping: float | None
    steps: int
    integrator: Integrator = field(default_factory=NewmarkBeta)
    status: str = CONTACT_STATUSES[0]
    without_solution: str = WITHOUT_SOLUTION[0]
    law: str = CONTACT_LAWS[0]
    initial_acceleration: str = INITIAL_ACCELERATIONS[0]
    exponent: float = HERTZ
    penetration: float | None = None
    every_step: bool = False
    resolves_contacts: bool = False
    stiffening: float | None = None
    has_step: ClassVar[bool] = True

    def __post_init__(self):
        _check_contact(self)
        n = whole("steps", self.steps, *STEPS_RANGE, "give steps per excitation period; the paper uses 2000 to 8000")
        if not isinstance(self.integrator, Integrator):
            raise ValueError(f"integrator = {shown(self.integrator)} is not an Integrator, such as NewmarkBeta()")
        one_of("status", self.status, CONTACT_STATUSES)
        one_of("without_solution", self.without_solution, WITHOUT_SOLUTION)
        one_of("initial_acceleration", self.initial_acceleration, INITIAL_ACCELERATIONS)
        set_fields(self, steps=n, **{name: flag(name, getattr(self, name)) for name in _FLAGS})
        if self.integrator.explicit and self.status == "end":
            name = self.integrator.name
            raise ValueError(f"{name} knows the gap before the force: it has no status = 'end'")
        if self.resolves_contacts and not (self.located and self._averages):
            raise ValueError(
                "resolves_contacts = True goes with status = 'located', Newmark's method with β = ¼ and γ = ½ and the "
                f"laws {' and '.join(NEWMARK_LAWS)}: leave it out"
            )

    @property
    def limit(self) -> ExactPenalty:
        """The solution that this one tends to as Δτ → 0."""
        return ExactPenalty(self.stiffness, self.damping, self.law, **self.law_numbers)

    @property
    def located(self) -> bool:
        """Whether steps are cut at contact changes."""
        return self.status == "located"

    @property
    def _averages(self) -> bool:
        """Whether a step has the mean acceleration of its ends, and a contact force that is linear, or that and cut."""
        own = self.integrator, self.initial_acceleration
        return own == (NewmarkBeta(), INITIAL_ACCELERATIONS[0]) and self.law in NEWMARK_LAWS

    @property
    def plain(self) -> bool:
        """Whether steps are the paper's: average acceleration, contact from their start; the force may be cut."""
        return self.status == CONTACT_STATUSES[0] and self._averages

    @property
    def is_newmarks(self) -> bool:
        """Whether :func:`Newmark` makes it: nothing that it leaves as it is has been chosen."""
        return (self.plain or self.resolves_contacts) and self.without_solution == WITHOUT_SOLUTION[0]

    @property
    def has_choices(self) -> bool:
        """Whether more is chosen than by :func:`Newmark` with the law of the paper."""
        return not (self.is_newmarks and self.linear)

    @property
    def name(self) -> str:
        """Of Newmark's method in the paper, or of time stepping."""
        return "newmark" if self.is_newmarks else "time-stepping"

    @property
    def skips_steps(self) -> bool:
        """Whether steps in which contact does not change are skipped, so that many steps take hardly longer."""
        return LAWS[self.law].closed_form and not self.located and not self.every_step

    @property
    def grid_steps(self) -> int:
        """The steps, where the solution exists at those of the constant grid alone; else 0."""
        return 0 if self.located else self.steps

    @property
    def stages(self) -> int:
        """Of a step, each of which is solved for."""
        return len(self.integrator.stages)

    @property
    def counts_solutions(self) -> bool:
        """Whether a step may have no solution, or two: its contact status is that of the end."""
        return self.status == "end"

    def __repr__(self) -> str:
        if not self.is_newmarks:
            return _shown_numbers(self, *LAW_NUMBERS, "resolves_contacts")
        numbers = f"stiffness={self.stiffness!r}, damping={self.damping!r}, steps={self.steps}"
        return f"Newmark({numbers}, every_step={self.every_step}, located={self.located}, law={self.law!r})"


def Newmark(
    stiffness: float,
    damping: float,
    steps: int,
    every_step: bool = False,
    located: bool = False,
    law: str = CONTACT_LAWS[0],
) -> TimeStepping:
    """Penalty contact integrated by Newmark's method, α = ½, β = ¼, constant step T/n (paper, section 4).

    Parameters
    ----------
    stiffness, damping, steps, every_step
        As those of :class:`TimeStepping`; the damping is a number.
    located : bool
        Cut a step at each contact change, located within it, instead of finding contact only at the start of steps;
        contacts shorter than some steps are resolved by shorter ones.
    law : {"kelvin-voigt", "cut"}
        Contact law: a spring and a damper, as in the paper, which may pull near the end of a contact; or the same cut
        at zero. :class:`TimeStepping` has more laws.

    Raises
    ------
    ValueError
        If a value is out of range.

    Examples
    --------
    >>> from vibroscope.engine import Newmark
    >>> Newmark(12000, 18, 2000).limit  # as the step tends to zero
    ExactPenalty(stiffness=12000.0, damping=18.0)
    >>> Newmark(12000, -1, 2000)
    Traceback (most recent call last):
        ...
    ValueError: D = -1 is outside [0, 1e+12]: give a contact damping; the paper uses 8 to 50
    """
    if law in CONTACT_LAWS and law not in NEWMARK_LAWS:
        raise ValueError(f"law = {law!r} is stepped by TimeStepping(…, law={law!r}), not by Newmark")
    method = TimeStepping(stiffness, damping, steps, law=law, every_step=every_step)
    return replace(method, status="located", resolves_contacts=True) if flag("located", located) else method


def with_located_steps(method: TimeStepping) -> TimeStepping:
    """Return a method with the same numbers whose steps are cut where contact changes.

    Contacts are resolved by shorter steps where the method's own are the paper's.

    Examples
    --------
    >>> from vibroscope.engine import Newmark, with_located_steps
    >>> with_located_steps(Newmark(2500, 8, 500)).located
    True
    """
    resolved = method.plain or method.resolves_contacts
    return replace(method, status="located", resolves_contacts=resolved, every_step=False)


def _shown_numbers(method: ExactPenalty | TimeStepping, *left_out: str) -> str:
    """The method as Python writes it, numbers of these names left out where they are the default."""
    named = {each.name: getattr(method, each.name) for each in fields(method)}
    known = {each.name: each.default for each in fields(method) if each.name in left_out}
    parts = (f"{name}={value!r}" for name, value in named.items() if known.get(name, ...) != value)
    return f"{type(method).__name__}({', '.join(parts)})"


def contact_ranges(law: str) -> tuple[tuple[float, float], tuple[float, float]]:
    """The ranges of K and of D of a contact law."""
    if LAWS[law].exponent == 1.0:
        return STIFFNESS_RANGE, DAMPING_RANGE
    return (STIFFNESS_RANGE[0], LARGEST_OF_POWER), (DAMPING_RANGE[0], LARGEST_OF_POWER)


def _check_contact(method: ExactPenalty | TimeStepping) -> None:
    law = one_of("law", method.law, CONTACT_LAWS)
    of_stiffness, of_damping = contact_ranges(law)
    k = require("K", method.stiffness, *of_stiffness, "give a contact stiffness; the paper uses 100 to 12000")
    d = method.damping
    if d is not None or law not in LAWS_BY_RESTITUTION:
        d = require("D", d, *of_damping, "give a contact damping; the paper uses 8 to 50")
    n = require("exponent", method.exponent, *EXPONENT_RANGE, "give the power of the penetration, 1.5 for Hertz")
    set_fields(method, stiffness=k, damping=d, exponent=n)
    own = numbers_of(law)
    if n != HERTZ and "exponent" not in own:
        raise ValueError(f"exponent = {n:g} is no number of the law {law!r}: leave it at {HERTZ}")
    advice = f"give the penetration beyond which {LAWS[law].penetration} of the law {law!r}"
    _check_number(method, law, "penetration", PENETRATION_RANGE, advice)
    _check_number(method, law, "stiffening", STIFFENING_RANGE, f"give the r of the spring of the law {law!r}")


def _check_number(method: ExactPenalty | TimeStepping, law: str, name: str, span: tuple, advice: str) -> None:
    """Check a number of a law that is needed where the law takes it."""
    given = getattr(method, name)
    if name in numbers_of(law):
        if given is None:
            raise ValueError(f"{name} is missing: {advice}")
        set_fields(method, **{name: require(name, given, *span, advice, open_low=True)})
    elif given is not None:
        others = ", ".join(map(repr, laws_with(name)))
        raise ValueError(f"{name} = {shown(given)} is no number of the law {law!r}, but of {others}: leave it out")


Method = Reference | ExactPenalty | TimeStepping
METHOD_NUMBERS = {"K": "stiffness", "D": "damping", "steps": "steps"}  # by their symbols: attributes of a method


def check_has(method: Method, name: str, system: System) -> None:
    """Refuse a number that is to vary and has no effect, by its symbol or as of :class:`System`.

    Raises
    ------
    ValueError
        If the method does not have it, or there is no second stop to have it.
    """
    if name in (*METHOD_NUMBERS, "threshold") and name not in method.numbers:
        raise ValueError(f"the {method.name} method has no {name}: give another number or solver")
    if name in ("restitution", "restitution2") and not method.rigid:
        raise ValueError(f"the {method.name} method has no impact law and so no {name}: give D in its place")
    if name in SECOND_STOP[1:] and method.rigid:
        raise ValueError(f"the {method.name} method has no K and D, and so no {name}: give another solver")
    if name in SECOND_STOP and not system.two_stops:
        raise ValueError(f"{name}: there is no second stop; give its clearance, too")
