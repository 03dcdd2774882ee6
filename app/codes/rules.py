"""Rules of thumb for K, D and the time step: what each gives for a system, what motion follows, and whether it holds.

The rules are rows of ``assets/codes.toml``; their `kind` names one of the functions here. With the reduced mass
μ̂ = μ/(1 + μ), the contact frequency ω_c = √(K/μ̂), the damping ratio ζ = D/√(Kμ̂) and the stiffness k = EA/h of the
elements in contact, which is no number of the system and must be given:

====================  ===========================================================================
``steps_per_mode``    n of so many steps per cycle of the highest of 1, κ, κ₃ and η
``steps_per_contact`` n of so many steps per cycle of ω_c
``nodal_step``        n of Δτ = √(2/(K + 1)) for the lighter body: m = 1 or μ, and its own spring
``times_elements``    K, so many times k
``penetration``       K that the largest driving force presses in by this part of the unit of length
``damping_ratio``     D of this ζ
``restitution``       D with which an impact keeps e of its speed
``lighter_damping``   D of so many times the critical damping 2mω_c of LS-DYNA, m of the lighter body
``follows_step``      K = so many times m/Δτ², m of the lighter body
``time_constant``     K and D of ζ = 1 and 1/ω_c = so many steps
====================  ===========================================================================

What a rule does not give stays as it is set. Whether it holds is measured: by the part of the difference from the
reference that its numbers cause, which must not exceed what `engine.verdict` calls close. Where the difference has no
parts, as that of a motion which its step blurs, K and D are judged by what is left without a time step, and the step by
what it adds to that. ``nodal_step`` claims no more than a stable step of an explicit code: it holds where a run with
central differences stays bounded.
"""

import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field, replace
from functools import cache
from types import MappingProxyType

from vibroscope.app.codes.catalogue import lighter_critical_damping, table
from vibroscope.engine import (
    METHOD_NUMBERS,
    CentralDifference,
    Comparison,
    ComparisonQuestion,
    Motion,
    Reference,
    Response,
    Status,
    System,
    TimeStepping,
    compare,
    difference_in_kind,
    finite_or_none,
    free_length,
    motion,
    percent,
    repetition,
    simulate,
    stiffness_of_step,
    touching,
)
from vibroscope.engine.arguments import Poll, require
from vibroscope.engine.contact import contact_frequency, damping_for, equal_restitution_damping
from vibroscope.engine.divergence.encounters import mean_closing_speed
from vibroscope.engine.divergence.remaining import Remaining
from vibroscope.engine.divergence.tolerances import CLOSE_CURVE
from vibroscope.engine.facts import Choice, Statement, message_of, sentence, stated
from vibroscope.engine.model import check_eta
from vibroscope.engine.motions.words import of_section
from vibroscope.engine.one_impact.of_system import ContactAlone, alone_as_dict, contact_alone

Numbers = dict[str, float]  # some of stiffness, damping and steps
ENDED = "ended early"  # what stands for the motion of a run without a result


@dataclass(frozen=True)
class RuleQuestion:
    """The input of a rule: a system, its excitation frequency η, and the method that is set.

    ``element_stiffness``: EA/h of the elements in contact, in units of k₁; None where it is not known.

    Raises
    ------
    ValueError
        If η is out of range.
    """

    system: System
    eta: float
    method: TimeStepping
    element_stiffness: float | None = None

    def __post_init__(self) -> None:
        check_eta(self.eta)
        if self.element_stiffness is not None:
            require("element_stiffness", self.element_stiffness, 0, math.inf, "give EA/h", open_low=True)

    @property
    def step(self) -> float:
        """Δτ."""
        return 2.0 * math.pi / (self.eta * self.method.steps)

    def steps_of(self, step: float) -> int:
        """The fewest steps per period that are not longer than ``step``."""
        return math.ceil(2.0 * math.pi / (self.eta * step) * (1.0 - 1e-12))


def _steps_per_mode(asked: RuleQuestion, number: float) -> Numbers:
    highest = max(asked.eta, *asked.system.frequencies, 0.0 if asked.system.wall else asked.system.kappa3)
    return {"steps": asked.steps_of(2.0 * math.pi / (number * highest))}


def _steps_per_contact(asked: RuleQuestion, number: float) -> Numbers:
    frequency = contact_frequency(asked.system, asked.method.stiffness)
    return {"steps": asked.steps_of(2.0 * math.pi / (number * frequency))}


def _nodal_step(asked: RuleQuestion, number: float) -> Numbers:
    bodies = [(1.0, 1.0)]  # mass and spring
    if not asked.system.wall:
        bodies.append((asked.system.mass_ratio, asked.system.mass_ratio * asked.system.kappa**2))
    shortest = min(math.sqrt(2.0 * mass / (asked.method.stiffness + spring)) for mass, spring in bodies)
    return {"steps": asked.steps_of(number * shortest)}


def _times_elements(asked: RuleQuestion, number: float) -> Numbers:
    if asked.element_stiffness is None:
        raise ValueError(
            "the rule is about the stiffness EA/h of the elements in contact, with their modulus E, area A and height "
            "h: give it to have the rule judged"
        )
    return {"stiffness": number * asked.element_stiffness}


def _penetration(asked: RuleQuestion, number: float) -> Numbers:
    e, mu = asked.system.excitation, 0.0 if asked.system.wall else asked.system.mass_ratio
    inertia = abs(e.base_amplitude(asked.eta)) * asked.eta**2
    force = max(inertia + abs(e.force1) + abs(e.constant1), mu * inertia + abs(e.force2) + abs(e.constant2))
    if not force:
        raise ValueError("nothing drives the bodies, so that no force presses them together")
    return {"stiffness": force / number}


def _damping_ratio(asked: RuleQuestion, number: float) -> Numbers:
    return {"damping": damping_for(asked.system, asked.method.stiffness, number)}


def _lighter_damping(asked: RuleQuestion, number: float) -> Numbers:
    return {"damping": number * lighter_critical_damping(asked.system, asked.method.stiffness)}


def _restitution(asked: RuleQuestion, number: float) -> Numbers:
    return {"damping": number * float(equal_restitution_damping(asked.system, asked.method.stiffness))}


def _follows_step(asked: RuleQuestion, number: float) -> Numbers:
    return {"stiffness": stiffness_of_step(asked.system, asked.eta, asked.method.steps, number)}


def _time_constant(asked: RuleQuestion, number: float) -> Numbers:
    stiffness = asked.system.mass_share / (number * asked.step) ** 2
    return {"stiffness": stiffness, "damping": damping_for(asked.system, stiffness, 1.0)}


def _as_set(asked: RuleQuestion, number: float) -> Numbers:
    return {}


_KINDS: Mapping[str, tuple[tuple[str, ...], Callable[[RuleQuestion, float], Numbers]]] = {
    "steps_per_mode": (("steps",), _steps_per_mode),
    "steps_per_contact": (("steps",), _steps_per_contact),
    "nodal_step": (("steps",), _nodal_step),
    "times_elements": (("K",), _times_elements),
    "penetration": (("K",), _penetration),
    "damping_ratio": (("D",), _damping_ratio),
    "lighter_damping": (("D",), _lighter_damping),
    "restitution": (("D",), _restitution),
    "follows_step": (("K",), _follows_step),
    "time_constant": (("K", "D"), _time_constant),
    "as_set": ((), _as_set),
}


def _explicit(method: TimeStepping) -> TimeStepping:
    """The same contact, stepped by central differences."""
    contact = {"law": method.law} | method.law_numbers
    return TimeStepping(method.stiffness, method.damping, method.steps, CentralDifference(), **contact)


@dataclass(frozen=True)
class Rule:
    """A rule of thumb for K, D or the time step, with its source.

    Attributes
    ----------
    key, title : str
    kind : str
        The function of this module, and ``number``, which it takes.
    claim : str
        What it promises.
    source, url : str
    """

    key: str
    title: str
    kind: str
    number: float
    claim: str
    source: str
    url: str = ""

    def __post_init__(self) -> None:
        if self.kind not in _KINDS or not (math.isfinite(self.number) and self.number > 0):
            raise ValueError(f"codes.toml, rule {self.key}: kind = {self.kind!r} and number = {self.number!r} are none")

    @property
    def gives(self) -> tuple[str, ...]:
        """The names of the numbers that it gives, of K, D and steps."""
        return _KINDS[self.kind][0]

    def method(self, asked: RuleQuestion) -> TimeStepping:
        """The method that is set, with the rule's numbers; raises ValueError if it gives none, or one out of range.

        The steps are at least 4, the fewest that there are.
        """
        law = asked.method.law
        if asked.method.spring_exponent != 1.0 and self.kind not in ANY_LAW:
            raise ValueError(
                stated(
                    "the rule is about a linear contact spring, which the law {} does not have", Choice("law", (law,))
                )
            )
        numbers = _KINDS[self.kind][1](asked, self.number)
        if "steps" in numbers:
            numbers["steps"] = max(4, numbers["steps"])
        return replace(_explicit(asked.method) if self.kind == EXPLICIT else asked.method, **numbers)


ANY_LAW = ("steps_per_mode", "as_set")  # kinds of rules that do not take the contact for a linear spring
EXPLICIT = "nodal_step"  # kind of the rules whose claim is a stable step of an explicit code
AS_SET = Rule("as-set", "As it is set", "as_set", 1.0, "", "")  # to judge what is set beside what rules give


@cache
def rules() -> Mapping[str, Rule]:
    """All rules by key, in the order of the file."""
    found = {row["key"]: Rule(**row) for row in table()["rule"]}
    if len(found) < len(table()["rule"]):
        raise ValueError("codes.toml has two rules with one key")
    return MappingProxyType(found)


@dataclass(frozen=True, eq=False)
class RuleOutcome:
    """The numbers that a rule gives, and the difference from the reference that they cause.

    Attributes
    ----------
    rule : Rule
    method : TimeStepping or None
        With the numbers of the rule; None where it gives none.
    motion : str or Statement
        What the motion then is; empty where there is none.
    total, part : float
        The difference from the reference, and the part of it that the rule's numbers cause; nan where not known.
    holds : bool or None
        Whether ``part`` is small; None where it is not known.
    why : str or Statement
        A sentence with the number behind ``holds``, or why there is none.
    without_solution : int
        Steps without a solution.
    motions : dict of str to Motion
        Of the ``reference`` and the ``penalty`` solution, with the evidence that decides what they are; empty where
        they were not compared.
    brief : str or Statement
        ``why`` where there is little room; of a run that ended early without what to change.
    alone : ContactAlone or None
        What a contact alone gives with these numbers, without the step and with it; None where that is not known.
    """

    rule: Rule
    method: TimeStepping | None
    motion: str | Statement = ""
    total: float = math.nan
    part: float = math.nan
    holds: bool | None = None
    why: str | Statement = ""
    without_solution: int = 0
    motions: Mapping[str, Motion] = field(default_factory=dict)
    brief: str | Statement = ""
    alone: ContactAlone | None = None

    def __post_init__(self) -> None:
        object.__setattr__(self, "brief", self.brief or self.why)

    @property
    def contact(self) -> str:
        """A sentence about the contact alone; empty where nothing is known of it."""
        return self.alone.sentence if self.alone else ""

    def as_dict(self) -> dict[str, object]:
        """Plain values for JSON; None for what is not known."""
        given = {} if self.method is None else self.method.numbers
        return {
            **{name: getattr(self.rule, name) for name in ("key", "title", "claim", "source", "url")},
            "gives": list(self.rule.gives),
            **{name: given.get(name) for name in METHOD_NUMBERS},
            "motion": self.motion or None,
            "total": finite_or_none(self.total),
            "part": finite_or_none(self.part),
            "holds": self.holds,
            "why": self.why,
            "steps_without_solution": self.without_solution,
            **alone_as_dict(self.alone),
        }


def judge(
    rule: Rule,
    asked: RuleQuestion,
    *,
    reference: Reference | None = None,
    responses: Iterable[Response] = (),
    cancelled: Poll | None = None,
    **options,
) -> RuleOutcome:
    """Run a system with the numbers that a rule gives, and measure the difference that they cause.

    Parameters
    ----------
    rule : Rule
    asked : RuleQuestion
    reference : Reference, optional
    responses : iterable of Response
        Runs of `engine.compare` that exist already; others are left out.
    cancelled : callable, optional
    **options
        ``periods``, ``keep`` and ``initial`` of `engine.ComparisonQuestion`.

    Raises
    ------
    Cancelled
        If ``cancelled()`` was true.
    """
    try:
        method = rule.method(asked)
    except ValueError as error:
        return RuleOutcome(rule, None, why=message_of(error) + ".")
    if not asked.system.excitation.drives:
        options = free_length(asked.system, asked.eta, options.get("initial")) | options
    if rule.kind == EXPLICIT:
        found = _judge_stability(rule, asked, method, options | {"cancelled": cancelled})
        return replace(found, alone=contact_alone(asked.system, asked.eta, method, math.nan))
    reference = reference or Reference()
    wanted = (method, reference)
    keep = options.get("keep")  # of a free vibration, which may be compared over longer than it is shown
    known = [each for each in responses if each.method in wanted and keep in (None, each.keep)]
    try:
        found = compare(
            ComparisonQuestion(asked.system, asked.eta, method, reference=reference, **options),
            responses=known,
            cancelled=cancelled,
        )
    except ValueError as error:  # what cannot be compared can still be run
        run = next((each for each in known if each.method == method), None)
        run = run or simulate(asked.system, asked.eta, method, **options)
        shown = motion(run) if run.ok else None
        words = of_section(repetition(shown), shown.period, method.has_step) if shown else sentence(run.message)
        count = getattr(run, "steps_without_solution", 0)
        said = {"holds": None if run.ok else False, "why": message_of(error) + ".", "without_solution": count}
        return RuleOutcome(rule, method, words, **said)
    speed = mean_closing_speed(found.runs.reference)
    outcome = _of_comparison(rule, method, found, cancelled)
    return replace(outcome, alone=contact_alone(asked.system, asked.eta, method, speed))


def _judge_stability(rule: Rule, asked: RuleQuestion, method: TimeStepping, options: dict) -> RuleOutcome:
    """Whether a run with central differences stays bounded; nothing is said of how exact it is."""
    run = simulate(asked.system, asked.eta, method, **options)
    if not run.ok:
        return _ended(rule, method, run, False)
    why = f"With central differences the run stays bounded over {run.periods:,} periods."
    return RuleOutcome(rule, method, "stays bounded", holds=True, why=why)


def _ended(rule: Rule, method: TimeStepping, run: Response, holds: bool | None, count: int = 0) -> RuleOutcome:
    """The outcome where a run ended early."""
    why, brief = sentence(run.message), sentence(run.message.brief)
    return RuleOutcome(rule, method, ENDED, holds=holds, why=why, without_solution=count, brief=brief)


def _of_comparison(rule: Rule, method: TimeStepping, found: Comparison, cancelled: Poll | None) -> RuleOutcome:
    penalty = found.runs.penalty
    count = getattr(penalty, "steps_without_solution", 0)
    if found.parts is None:
        ended = penalty if not penalty.ok else found.runs.reference
        by_step = penalty.status is Status.DIVERGED and rule.gives and "steps" not in rule.gives
        known = False if ended is penalty and not by_step else None  # a step that is too long tests no K and no D
        return _ended(rule, method, ended, known, count)
    found = found.decided(cancelled)
    motions = {"reference": found.reference, "penalty": found.penalty}
    words = repetition(found.penalty)
    name = "time_step" if "steps" in rule.gives else "regularisation"
    difference = found.difference
    part = difference.parts.get(name, math.nan) if rule.gives else difference.total
    untested = _nothing_to_test(found, name if rule.gives else "")
    if untested:
        return RuleOutcome(rule, method, words, difference.total, part, None, untested, count, motions)
    if rule.gives and not math.isfinite(part) and not found.is_free:
        part, why = _part_by_limit(found, name, cancelled)
    elif rule.gives and math.isfinite(part):
        why = f"{'the time step alone makes' if name == 'time_step' else 'K and D alone make'} {percent(part)}"
    else:
        why = f"the solutions differ by {percent(difference.total)}"
    holds = (part if math.isfinite(part) else difference.total) <= CLOSE_CURVE
    if not math.isfinite(part) and (kinds := difference_in_kind(found.reference, found.penalty)):
        holds, why = False, stated("{}; {}", kinds, why)
    return RuleOutcome(rule, method, words, difference.total, part, holds, sentence(why), count, motions)


def _part_by_limit(found: Comparison, name: str, cancelled: Poll | None) -> tuple[float, str]:
    """What K and D leave without a time step, or what the step adds to that; and a sentence about it."""
    left = Remaining(found, cancelled).whole(found.runs.penalty.method.limit)
    total = found.difference.total
    if not math.isfinite(left):
        return math.nan, f"the solutions differ by {percent(total)}; without a time step the run ends early"
    without = f"without a time step {percent(left)} is left of the {percent(total)}"
    if name == "regularisation":
        return left, without
    added = max(0.0, total - left)
    return added, f"the time step adds {percent(added)}: {without}"


def _nothing_to_test(found: Comparison, part: str) -> str:
    """Why a motion cannot show whether a rule holds that ``part`` of the difference follows from; empty if it can."""
    fact = touching(found.reference)
    if found.reference_rests:
        return f"{fact} The reference does not move, so that no relative difference exists.".strip()
    apart = found.penalty.contact_share == found.reference.contact_share == 0.0
    return fact if apart and part == "regularisation" else ""
