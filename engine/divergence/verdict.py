"""A comparison in words: what agrees, which number is to blame, and what to change first.

Every sentence follows from computed numbers: `agreement` says what agrees of displacements, kinds of motion, impacts
and the scatter of the time step, :mod:`.alone` searches over each number, :mod:`.blame` names those whose change helps,
and :mod:`.conditions` says what the contact itself does.
"""

from collections.abc import Callable, Iterable
from dataclasses import dataclass, field, replace

import numpy as np
from vibroscope.engine.arguments import Poll
from vibroscope.engine.divergence.alone import Alone, Change
from vibroscope.engine.divergence.blame import Blame, find_blame
from vibroscope.engine.divergence.compare import Comparison, compare_changed, error_from_penalty_state
from vibroscope.engine.divergence.conditions import (
    Conditions,
    contact_conditions,
    unequal_stops_text,
    with_equal_damping,
)
from vibroscope.engine.divergence.grid import SECTION, rms, run_again
from vibroscope.engine.divergence.remaining import Remaining
from vibroscope.engine.divergence.search import search_alone, without_jump
from vibroscope.engine.divergence.sentences import (
    SENTENCE_DIGITS,
    blame_sentence,
    certainty_sentences,
    change_of,
    chosen,
    contact_sentences,
    detail_sentences,
    few_steps_text,
    rebound_text,
)
from vibroscope.engine.divergence.tolerances import CLOSE_CURVE, HALF, SAME_COUNT, SAME_CURVE, VISIBLE
from vibroscope.engine.drivers.section import sizes_of
from vibroscope.engine.facts import Amount, Choice, Dimensionless, Statement, Symbol, equation, joined, sentence, stated
from vibroscope.engine.law_table import LAWS
from vibroscope.engine.methods import STEPS_RANGE, WITHOUT_SOLUTION, TimeStepping
from vibroscope.engine.motions.description import Motion
from vibroscope.engine.motions.words import (
    SYMBOLS,
    difference_in_kind,
    repetition,
    stays_apart,
    stays_together,
    touching,
)
from vibroscope.engine.result import Status
from vibroscope.engine.wording import counted, finite_or_none, percent, rounded_to


def agreement(comparison: Comparison) -> tuple[str, str | Statement]:
    """Return how far the solutions agree, as in :class:`.verdict.Verdict`, and a sentence about it."""
    if comparison.difference.measure == "sections":
        return _agreement_of_sections(comparison)
    reference, penalty, difference = comparison.reference, comparison.penalty, comparison.difference
    total = difference.total
    impacts, kinds = _impacts_clause(reference, penalty), difference_in_kind(reference, penalty)
    amount = f"the displacements differ by {difference.amount} (rms)"
    if kinds and total <= CLOSE_CURVE:
        return "partly", stated("They agree roughly, but not in kind: {}, and {}{}.", kinds, amount, impacts)
    if kinds:
        return "no", stated("They disagree: {}, and {}{}.", kinds, amount, impacts)
    if total <= SAME_CURVE:
        return ("partly" if impacts else "yes"), f"They agree: {amount}{impacts and ', but' + impacts[1:]}."
    if total <= CLOSE_CURVE:
        return "partly", f"They agree roughly: {amount}{impacts}."
    return "no", f"They disagree: {amount}{impacts}."


def closeness(total: float) -> str:
    """How far two solutions agree whose displacements differ by so much, as in :class:`.verdict.Verdict`."""
    return "yes" if total <= SAME_CURVE else "partly" if total <= CLOSE_CURVE else "no"


def time_step_scatter(motion: Motion) -> float:
    """Return the scatter of a motion's section, a standard deviation, if the time step causes it; else 0."""
    return motion.scatter if motion.step_noise > 0 else 0.0


def is_visible(scatter: float, comparison: Comparison) -> bool:
    """Whether a scatter is large enough to be mentioned."""
    return scatter > VISIBLE * float(sizes_of(comparison.runs.penalty.section[None])[0])


def _agreement_of_sections(comparison: Comparison) -> tuple[str, str | Statement]:
    reference, penalty, difference = comparison.reference, comparison.penalty, comparison.difference
    kinds, impacts = difference_in_kind(reference, penalty), _impacts_clause(reference, penalty)
    if kinds:
        first = stated("They differ in kind: {}; only statistics can be compared", kinds)
    elif reference.near_period:
        first = "They repeat too late to be compared instant by instant, so that only statistics can be compared"
    else:
        first = "Neither repeats, so that only statistics can be compared"
    total, chance = difference.total, f"up to {percent(difference.chance)}"
    head = stated("{}: the sections differ by {}", first, difference.amount)
    if total <= difference.chance:
        agree = "yes" if total <= CLOSE_CURVE and not kinds else "partly"
        return agree, head + f", no more than chance explains ({chance})."
    agree = "partly" if total <= CLOSE_CURVE and not impacts and not kinds else "no"
    return agree, head + f" (chance explains {chance}){impacts}."


def _impacts_clause(reference: Motion, penalty: Motion) -> str:
    """Impacts and contacts per period, if their numbers differ; else empty."""
    impacts, contacts = reference.impacts_per_period, penalty.impacts_per_period
    if abs(impacts - contacts) <= max(SAME_COUNT, SAME_COUNT * impacts):
        return ""
    held = "always in contact" if stays_together(penalty) else f"with {counted(contacts, 'contact')} a period"
    return f", {held} for {counted(impacts, 'impact')}"


# Relative: shifts of η at which what finishes must do so, too.
NEARBY = (0.0, -1e-6, 1e-6, -2.5e-6, 2.5e-6, -1e-5, 1e-5, -1e-4, 1e-4)
DOUBLINGS = 6  # of the steps, tried for a run that diverged, or that had no solution; and halvings of D then


@dataclass(frozen=True)
class Verdict:
    """A comparison in words.

    Attributes
    ----------
    headline : str or Statement
        At most three short sentences.
    agree : {"yes", "partly", "no", "unknown"}
    blame : tuple of {"steps", "K", "D", "joint damping", "status", "integrator", "law"}
        The numbers or choices to blame (:mod:`.blame`), the one to change first at first: each alone, or all of them
        ``together``; empty if nothing is to blame.
    change : dict of str to float, bool or str
        What to set first, tried before: some of ``K``, ``D``, ``steps``, ``located``, ``status``, ``integrator``,
        ``law`` and ``without_solution``; empty if no setting helps. :class:`engine.Newmark` has located steps and few
        laws alone: :class:`engine.TimeStepping` is the same method with all choices.
    left : float
        What remains of the difference with this change, or without what is to blame; nan if nothing is.
    together : bool
        Whether the numbers have to be changed together.
    scatter : float
        Standard deviation of ξ₂ (at a wall ξ₁) about the section's points that the time step alone causes; 0 if there
        is none.
    details : tuple of str or Statement
        The numbers behind it, a sentence each.
    alone : Alone or None
        The difference over each number alone; None where there is nothing to search for.
    contact : Conditions or None
        What the contact of the penalty solution does; None if a run ended early.
    reference, penalty : Motion or None
        The motions that it speaks of, with the evidence that decided what they are; None if a run ended early.
    """

    headline: str
    agree: str
    blame: tuple[str, ...] = ()
    change: dict[str, float | bool | str] = field(default_factory=dict)
    left: float = np.nan
    together: bool = False
    scatter: float = 0.0
    details: tuple[str, ...] = ()
    alone: Alone | None = field(default=None, repr=False)
    contact: Conditions | None = None
    reference: Motion | None = field(default=None, repr=False)
    penalty: Motion | None = field(default=None, repr=False)

    def as_dict(self) -> dict:
        """Return plain values for scripts; None for unknown numbers."""
        words = {name: value for name, value in vars(self).items() if name not in ("reference", "penalty")}
        return {
            **words,
            "left": finite_or_none(self.left),
            "blame": list(self.blame),
            "details": list(self.details),
            "alone": self.alone and self.alone.as_dict(),
            "contact": self.contact and self.contact.as_dict(),
        }


def verdict(
    comparison: Comparison,
    *,
    progress: Callable[[Alone], None] = lambda found: None,
    threads: int | None = None,
    cancelled: Poll | None = None,
) -> Verdict:
    """Say what a comparison means, by some hundred more runs of the penalty solution.

    Parameters
    ----------
    comparison : Comparison
    progress : callable, optional
        Called with the difference over each number alone, as far as it is known.
    threads : int, optional
        That make its runs; by default one for each core.
    cancelled : callable, optional
        Polled many times a second; when it returns true the search is cancelled.

    Raises
    ------
    Cancelled
        If ``cancelled`` returned true.

    Examples
    --------
    >>> from vibroscope.engine import ComparisonQuestion, Newmark, System, compare, verdict
    >>> found = verdict(compare(ComparisonQuestion(System(), 1.08, Newmark(100, 50, 2000))))
    >>> found.agree, found.blame
    ('no', ('D', 'K'))
    """
    if comparison.parts is None:
        return _of_early_end(comparison, cancelled)
    if comparison.is_free:
        return _of_rest(comparison) if comparison.reference_rests else _of_free_vibration(comparison, cancelled)
    if changing := comparison.changing(cancelled):
        return _of_changing_motion(comparison, changing)
    comparison = comparison.decided(cancelled)
    comparison.measure(cancelled)
    difference, scatter = comparison.difference, time_step_scatter(comparison.penalty)
    if comparison.reference_rests:
        return _of_rest(comparison)
    if not np.isfinite(difference.total):
        return Verdict(
            f"A solution does not stay bounded for {SECTION:,} periods more, so there is nothing to compare.", "unknown"
        )
    if difference.measure == "displacements" and difference.total > CLOSE_CURVE:
        elsewhere = error_from_penalty_state(comparison, cancelled)
        if elsewhere < min(CLOSE_CURVE, difference.total / 2):
            return _of_other_motion(comparison, elsewhere, scatter, cancelled)
    reference, penalty = comparison.reference, comparison.penalty
    unchanged = touching(reference) if touching(reference) == touching(penalty) else ""
    if unchanged and penalty.contact_share == reference.contact_share == 0.0:
        return _without_contact(comparison, unchanged, cancelled)
    remaining = Remaining(comparison, cancelled, threads)
    found = search_alone(comparison, remaining, progress)
    return _of_search(comparison, found, find_blame(comparison, found, remaining), unchanged, cancelled)


def _of_search(comparison: Comparison, found: Alone, blame: Blame, unchanged: str, cancelled) -> Verdict:
    """Return the verdict that the search gives."""
    agree, first = agreement(comparison)
    contact = contact_conditions(comparison)
    first_change = blame.together or next(iter(blame.changes), None)
    cancel = _cancelling_sentence(comparison, contact) if agree in ("yes", "partly") and not unchanged else ""
    scatter = time_step_scatter(comparison.penalty)
    scattered = "" if repetition(comparison.penalty) in first else _scatter_sentence(comparison, scatter)
    second = blame_sentence(comparison, found, blame, None if cancel else contact)
    run = comparison.runs.penalty
    stops = unequal_stops_text(run.system, run.method, comparison.closing_speed)
    stops = f"{stops[0].upper()}{stops[1:]}." if stops else ""
    return Verdict(
        headline=joined(" ", filter(None, (unchanged, first, cancel, stops, second))) + scattered,
        agree="partly" if cancel else agree,
        blame=_blamed(blame),
        change=change_of(first_change) if first_change else {},
        left=first_change.left if first_change else np.nan,
        together=blame.together is not None,
        scatter=scatter,
        details=(*detail_sentences(comparison, found, contact, cancelled), *certainty_sentences(blame.together)),
        alone=found,
        contact=contact,
        **_motions(comparison),
    )


def _motions(comparison: Comparison) -> dict[str, Motion]:
    return {"reference": comparison.reference, "penalty": comparison.penalty}


def _blamed(blame: Blame) -> tuple[str, ...]:
    if blame.together is not None:
        return ("K", "D") if blame.together.changed == "K and D" else ("K", "D", "steps")
    return tuple(each.changed for each in blame.changes)


def _cancelling_sentence(comparison: Comparison, contact: Conditions) -> str:
    """Where motions agree although the contact does not do what is asked: errors cancel."""
    if contact.hold or comparison.difference.total > CLOSE_CURVE or not comparison.penalty.impacts_per_period:
        return ""
    gains = ": it gains energy" if contact.given > 1 else ""
    failing = [] if contact.rebounds else [f"{rebound_text(contact)}{gains}"]
    failing += [] if contact.resolved else [few_steps_text(contact)]
    return f"But {' and '.join(failing)}."


def _of_changing_motion(comparison: Comparison, changing: dict[str, float]) -> Verdict:
    """Return the verdict where a motion is no steady one after all periods that were run."""
    names = {"reference": "the reference", "penalty": "the penalty solution"}
    who = [f"{names[name]} (its section moved by {percent(moved)})" for name, moved in changing.items()]
    text, verb = " and ".join(who), "changes" if len(who) == 1 else "change"
    run = comparison.runs.penalty
    return Verdict(
        f"{text[0].upper()}{text[1:]} still {verb} between {run.periods // 2:,} and {run.periods:,} periods, so that "
        "there is no steady motion to judge. No number is blamed.",
        "unknown",
        **_motions(comparison),
    )


def _without_contact(comparison: Comparison, fact: str, cancelled) -> Verdict:
    """Return the verdict where neither motion has a contact: what is left is the error of the steps."""
    total = comparison.difference.total
    return Verdict(
        f"{fact} The time step alone makes a difference of {percent(total)}.",
        closeness(total),
        ("steps",) if total > SAME_CURVE else (),
        details=detail_sentences(comparison, None, contact_conditions(comparison), cancelled),
        **_motions(comparison),
    )


def _of_free_vibration(comparison: Comparison, cancelled) -> Verdict:
    """Return the verdict on two free vibrations from one start.

    Nothing lasts, so that there is no search. But K and D may not give the restitution: D that does is tried.
    """
    run, difference = comparison.runs.penalty, comparison.difference
    total = difference.total
    sizes = (stated("{} {}", difference.name(name), percent(share)) for name, share in difference.parts.items())
    which = f"last {run.keep} of {run.periods} periods T"
    if run.keep == run.periods:
        which = "first period T" if run.periods == 1 else f"first {run.periods} periods T"
    parts = stated(" Its parts: {}.", joined(", ", sizes)) if difference.parts else ""
    if all(stays_apart(each) for each in (comparison.reference, comparison.penalty)):
        fact = f"nothing touches in the {which} of this free vibration, so that K and D have no effect there"
        return Verdict(f"Nothing drives the bodies, and {fact}." + parts, closeness(total))
    contact = contact_conditions(comparison)
    change = _equal_damping(comparison, contact, cancelled)
    blame = Blame((change,) if change else (), least=change.left if change else total)
    first = (
        f"Nothing drives the bodies: in the {which} the displacements of this free vibration differ by "
        f"{percent(total)} (rms)." + parts
    )
    return Verdict(
        joined(" ", (first, blame_sentence(comparison, None, blame, contact))) if change else first,
        closeness(total),
        blame=_blamed(blame),
        change=change_of(change) if change else {},
        left=blame.least if change else np.nan,
        details=contact_sentences(comparison, contact),
        contact=contact,
    )


def _equal_damping(comparison: Comparison, contact: Conditions, cancelled) -> Change | None:
    """The D that rebounds as asked, where the present one does not, if it leaves half of the difference at most."""
    run, total = comparison.runs.penalty, comparison.difference.total
    if contact.fit or run.method.damping is None or not total > SAME_CURVE:
        return None
    method = with_equal_damping(run.system, run.method, run.method.stiffness, comparison.closing_speed)
    if method == run.method:
        return None
    found = compare_changed(comparison, method, cancelled)
    return Change("D", found.total, found.total, method) if found and found.total <= HALF * total else None


def _of_rest(comparison: Comparison) -> Verdict:
    """Return the verdict where the reference does not move, as a body that a preload holds at a wall."""
    moving = 1 if comparison.runs.reference.system.wall else 2
    apart = Amount(rms(comparison.parts.total[:moving]), "displacement", 2)
    said = stated(
        "{} The reference does not move, so that no relative difference exists: the penalty solution is off by {} "
        "(rms{}), by which the spring K gives way.",
        touching(comparison.reference),
        apart,
        Dimensionless(", in units of length"),
    )
    return Verdict(sentence(said), "unknown", **_motions(comparison))


def _scatter_sentence(comparison: Comparison, scatter: float) -> str | Statement:
    if not is_visible(scatter, comparison):
        return ""
    symbol = Symbol(SYMBOLS[comparison.penalty.body])
    return stated(
        " The time step blurs each point of the section ({} by ±{}).", symbol, Amount(scatter, "displacement", 2)
    )


def _of_other_motion(comparison: Comparison, elsewhere: float, scatter: float, cancelled) -> Verdict:
    """Return the verdict on a penalty solution that agrees with another motion of the reference."""
    total = percent(comparison.difference.total)
    start = "rest" if comparison.start is None else "the same start"
    headline = (
        "The penalty solution shows a different but valid motion: started from its state, the reference moves "
        f"so too, {percent(elsewhere)} apart. From {start} they are {total} apart: the result depends on the start."
    )
    return Verdict(
        headline,
        "partly",
        left=elsewhere,
        scatter=scatter,
        details=detail_sentences(comparison, None, contact_conditions(comparison), cancelled),
        **_motions(comparison),
    )


def _of_early_end(comparison: Comparison, cancelled) -> Verdict:
    """Return the verdict where Newmark or the reference did not reach its end."""
    runs = comparison.runs
    if not runs.reference.ok:
        message = runs.reference.message
        return Verdict(stated("The reference ended early, so there is nothing to compare: {}.", message), "unknown")
    if runs.penalty.status is Status.WITHOUT_SOLUTION:
        return _of_no_solution(comparison, cancelled)
    fact = "The penalty solution blew up, so there is nothing to compare."
    if runs.penalty.status is not Status.DIVERGED or not runs.exact.ok:
        return Verdict(f"{fact} K and D are to blame: take a smaller K.", "unknown", ("K",))
    advice, change = _sufficient_steps(comparison, cancelled)
    text = f"{fact} The time step is to blame: the same K and D without one stay bounded."
    return Verdict(f"{text} {advice}", "unknown", ("steps",), change, details=_of_early_contact(comparison))


def _of_early_contact(comparison: Comparison) -> tuple[str | Statement, ...]:
    """Where a run ended, and what its contact alone does with its step."""
    return comparison.runs.penalty.message, *contact_sentences(comparison, contact_conditions(comparison))


def _sufficient_steps(comparison: Comparison, cancelled) -> tuple[str, dict]:
    """Find by trying with how many steps the run reaches its end."""
    found = _first_that_finishes(comparison, _more_steps(comparison.runs.penalty.method), cancelled)
    if found is not None:
        return f"{found.steps:,} steps are enough for that.", {"steps": found.steps}
    return "Take a smaller K, or the located step.", {}


def _more_steps(method: TimeStepping) -> list[TimeStepping]:
    """The method with doubled numbers of steps."""
    doubled = (method.steps * 2**doubling for doubling in range(1, DOUBLINGS + 1))
    return [replace(method, steps=steps) for steps in doubled if steps <= STEPS_RANGE[1]]


def _first_that_finishes(comparison: Comparison, methods: Iterable, cancelled) -> TimeStepping | None:
    """Return the first of some methods whose run reaches its end, not at this η alone; None if none does."""
    run = comparison.runs.penalty

    def finishes(method: TimeStepping) -> bool:
        how = {"method": method, "keep": 1, "initial": comparison.start, "cancelled": cancelled}
        return all(run_again(run, eta=run.eta * (1.0 + shift), **how).ok for shift in NEARBY)

    return next(filter(finishes, methods), None)


def _of_no_solution(comparison: Comparison, cancelled) -> Verdict:
    """Return the verdict where a step had no solution: when, why, and which changes finish, each of them tried."""
    run = comparison.runs.penalty
    method, cause = run.method, replace(run.method, damping=0.0)
    jumps = _first_that_finishes(comparison, (cause,), cancelled) is not None
    at_touch = LAWS[method.law].jumps
    damper = "The damper's jump at touch" if at_touch else "The damper"
    why = damper if jumps else f"The contact status at the {method.status} of the step"
    halved = range(1, DOUBLINGS + 1) if method.damping is not None else ()
    tried = {
        "without_solution": [
            replace(method, without_solution=each)
            for each in reversed(WITHOUT_SOLUTION[1:])
            if each != method.without_solution
        ],
        "steps": _more_steps(method),
        "damping": [replace(method, damping=rounded_to(method.damping / 2**i, 3)) for i in halved],
        "law": [smooth] if (smooth := without_jump(method)) is not None else [],
        "status": [replace(method, status="start")],
    }
    found = {name: _first_that_finishes(comparison, methods, cancelled) for name, methods in tried.items()}
    change = {name: getattr(each, name) for name, each in found.items() if each is not None}
    ways = [_way(name, value) for name, value in change.items()]
    first = {"damping": "D"}
    step = run.cost.steps + 1
    when = f"step {step} (period {(step - 1) // method.steps + 1})"
    finishes = stated("What finishes, each tried alone: {}.", joined(", or ", ways)) if ways else ""
    return Verdict(
        f"The penalty solution stopped at {when}, which has no solution. {why} is to blame. "
        + (finishes or "Nothing tried finishes."),
        "unknown",
        (("law" if at_touch else "D") if jumps else "status",),
        {first.get(name, name): value for name, value in list(change.items())[:1]},
        details=_of_early_contact(comparison),
    )


def _way(name: str, value: float | str) -> str | Statement:
    """A change after which a run finishes, in words."""
    if name == "steps":
        return f"{value:,} steps"
    if name == "damping":
        return equation("D", value, SENTENCE_DIGITS)
    if name == "without_solution":
        return Statement(Choice(name, (value,), f"without-solution {value}"))
    return chosen(name, value)
