"""The sentences of a verdict: why a number is to blame, what its change leaves, and the numbers behind it."""

import math
from dataclasses import replace

import numpy as np
from vibroscope.engine.arguments import Poll
from vibroscope.engine.contact import damping_ratio, equal_damping, equal_stiffness
from vibroscope.engine.divergence.alone import Alone, Change
from vibroscope.engine.divergence.blame import OF_STEPS, Blame, contact_fails
from vibroscope.engine.divergence.compare import Comparison
from vibroscope.engine.divergence.conditions import Conditions, stay_together
from vibroscope.engine.divergence.encounters import delivered_restitution
from vibroscope.engine.divergence.grid import run_again
from vibroscope.engine.divergence.parts import Difference
from vibroscope.engine.divergence.search import NEIGHBOURS, joint_damping_part
from vibroscope.engine.divergence.tolerances import (
    AS_ASKED,
    CLOSE_CURVE,
    HALF,
    LESS,
    SAME_CURVE,
    SAME_DURATION,
    SAME_NUMBER,
    SAME_RESTITUTION,
)
from vibroscope.engine.drivers.section import NEAR_TOLERANCE
from vibroscope.engine.drivers.step_maps import damps
from vibroscope.engine.facts import Amount, Choice, Dimensionless, Statement, equation, joined, sentence, stated
from vibroscope.engine.methods import METHOD_NUMBERS, ExactPenalty, TimeStepping
from vibroscope.engine.motions.words import touching
from vibroscope.engine.one_impact.of_system import span_text, steps_text
from vibroscope.engine.wording import percent, rounded, rounded_to

SENTENCE_DIGITS = 3  # of K and D
_NAMES = {"steps": "the time step", "joint damping": "the joint damping", "law": "the damper's jump at touch"}
_STATUSES = {"located": "steps cut where contact changes", "end": "that at the end", "start": "that at the start"}


def blame_sentence(comparison: Comparison, found: Alone, blame: Blame, now: Conditions | None) -> str | Statement:
    """Return what is to blame, why unless it has been said (None), and what to change first."""
    difference = comparison.difference
    if difference.total <= difference.chance:
        return "Nothing is to blame."
    if difference.total <= SAME_CURVE:
        return _largest_sentence(difference)
    if blame.together is not None:
        return _together_sentence(comparison, found, blame, now)
    if not blame.changes:
        return _nothing_sentence(comparison, found, blame)
    names = [name_of(comparison, each.changed) for each in blame.changes]
    only = len(names) == 1
    values = [_leaves(each, only) + _more_steps(blame, each) + _cancels(blame, each) for each in blame.changes]
    verb = "is to blame" if only else "are to blame, each alone"
    why = _reason(comparison, blame.changes[0], now)
    return sentence(stated("{} {}{}: {}.", listed(names, "and"), verb, why, listed(values, "or")))


def name_of(comparison: Comparison, changed: str) -> str | Statement:
    """Return the words for a number or a choice within a sentence."""
    method = comparison.runs.penalty.method
    if changed == "status":
        return f"the contact status at the {method.status} of the step"
    if changed == "integrator":
        of = method.integrator
        name = Choice("integrator", (of.name,))
        return Statement("the numerical damping of " if damps(of) else "the integrator ", name)
    return _NAMES.get(changed, changed)


def change_of(change: Change) -> dict[str, float | bool | str]:
    """Return a change as numbers and choices to set; empty where no setting does it."""
    method = change.method
    if method is None or not method.has_step:
        return {}
    if change.changed == "status":
        return {"located": True} if method.resolves_contacts else {"status": method.status}
    if change.changed == "integrator":
        return {"integrator": method.integrator.name, "beta": method.integrator.beta, "gamma": method.integrator.gamma}
    if change.changed == "law":
        return {"law": method.law}
    own = {"K": method.stiffness, "D": method.damping, "steps": method.steps}
    wanted = {"K and D": ("K", "D"), "K, D and the step": tuple(own)}.get(change.changed, (change.changed,))
    return {name: own[name] for name in wanted}


def value_text(change: Change) -> str | Statement:
    """Return what a change sets, such as "K = 1000" or "8,000 steps a period"."""
    method = change.method
    if change.changed == "joint damping":
        return "no joint damping of its own"
    if change.changed == "steps":
        return f"{method.steps:,} steps a period" if method.has_step else "no time step"
    if change.changed == "status":
        return chosen("status", method.status)
    if change.changed == "integrator":
        return chosen("integrator", method.integrator.name)
    if change.changed == "law":
        return chosen("law", method.law)
    numbers = change_of(change)
    steps = numbers.pop("steps", None)
    texts = [equation(name, value, SENTENCE_DIGITS) for name, value in numbers.items()]
    return joined(", ", texts + ([f"{steps:,} steps a period"] if steps else []))


def chosen(field: str, value: str) -> Statement:
    """What is set that is no number, such as "law limited"; located steps are a choice of their own."""
    if value == "located":
        return Statement(Choice(field, (value,), f"{field} {value}"))
    return Statement(f"{field} ", Choice(field, (value,)))


def listed(words: list[str], last: str) -> Statement:
    """Words joined as in a sentence, ``last`` before the last of them."""
    return joined(f" {last} ", filter(None, (joined(", ", words[:-1]), words[-1])))


def rebound_text(now: Conditions) -> str:
    """Return what rebounds, with which restitution: measured, or as a contact alone does it; and the one asked for."""
    which = "a contact alone" if math.isnan(now.measured) else "the contact"
    return f"{which} rebounds with {share(now.given)} of its speed in place of {share(now.asked)}"


def few_steps_text(now: Conditions) -> str:
    """Return how few steps a contact takes, and what they make of its restitution, where K and D are as asked."""
    text = f"a contact takes only {steps_text(now.steps)} steps"
    if now.alone is None or not now.fit or not now.alone.is_off(SAME_RESTITUTION, now.asked):
        return text
    return f"{text}, with which bodies keep {span_text(now.alone.found) or 'none'} of their speed"


def share(restitution: float) -> str:
    """Return a restitution with two decimals at most."""
    return rounded(round(restitution, 2), 3)


def _reason(comparison: Comparison, change: Change, now: Conditions | None) -> str:
    """Return which condition fails, as a clause; empty if none does, or the change does not mend it."""
    present = comparison.runs.penalty.method
    if change.method is None or now is None:
        return ""
    of_contact = change.changed in ("K", "D", "K and D", "K, D and the step")
    stiffer = of_contact and change.method.stiffness > present.stiffness
    if stay_together(comparison):
        return ", since its spring gives way under the force that presses the bodies together" if stiffer else ""
    if of_contact and not (now.rebounds or now.fit):
        return f", since {rebound_text(now)}"
    if change.changed != "D" and not stiffer and not now.resolved:
        return f", since {few_steps_text(now)}"
    if stiffer:
        share = now.lasts * comparison.runs.penalty.eta / (2 * math.pi)
        return f", since contacts are too soft and last {percent(share)} of a period" if math.isfinite(share) else ""
    return ""


def _leaves(change: Change, only: bool) -> str | Statement:
    """What a change leaves; ``only``: it is the only one that is named."""
    left = percent(change.left)
    if change.changed == "joint damping":
        return f"without it {left} would be left{'; neither K nor D nor the step mends it' if only else ''}"
    if change.changed == "steps" and not change.method.has_step:
        return f"without it {left} would be left"
    if change.changed == "status":
        return f"{_STATUSES[change.method.status]} would leave {left}"
    if change.changed == "integrator":
        return f"Newmark's ¼ and ½, which damp nothing, leave {left}"
    if change.changed == "law":
        return stated("the {}, which has none, leaves {}", chosen("law", change.method.law), left)
    return stated("{} {} {}", value_text(change), "leave" if change.changed == "steps" else "leaves", left)


def _more_steps(blame: Blame, change: Change) -> str | Statement:
    """The difference that more steps leave, for codes that cannot cut a step."""
    if blame.more_steps is None or change.changed not in OF_STEPS:
        return ""
    return stated(" ({} {})", value_text(blame.more_steps), percent(blame.more_steps.left))


def _cancels(blame: Blame, change: Change) -> str:
    """Whether a change leaves so little only where errors cancel: its contact does not do what it should."""
    return " by errors that cancel" if change in blame.cancelling else ""


def _together_sentence(comparison: Comparison, found: Alone, blame: Blame, now: Conditions | None) -> Statement:
    best = found.changes[0] if found.changes else None
    helps = best is not None and best.left < LESS * found.total
    alone = "; alone at best " + _best_text(comparison, best) if helps else ""
    names = listed(["K", "D", "the time step"] if "step" in blame.together.changed else ["K", "D"], "and")
    left = blame.together.amount
    why = _reason(comparison, blame.together, now) if blame.together.changed == "K and D" else ""
    have = "would have" if found.total <= CLOSE_CURVE else "have"  # motions that agree roughly may do
    return stated(
        "{} {} to be changed together{}: {} leave {}{}.", names, have, why, value_text(blame.together), left, alone
    )


def _nothing_sentence(comparison: Comparison, found: Alone, blame: Blame) -> str | Statement:
    part = joint_damping_part(comparison)
    best, method = next(iter(found.changes), None), comparison.runs.penalty.method
    of_model = (
        f" The joint damping alone, which the penalty model lacks, makes {percent(part)}." if part > SAME_CURVE else ""
    )
    tried = "K, D or time step"
    if method.damping is None:
        tried = "K or time step"
        of_law = " The law {} takes its damper from e: a D of its own was not tried."
        of_model = stated(of_model + of_law, Choice("law", (method.law,)))
    if best is None or best.left >= LESS * found.total:
        return stated("No {} that was tried leaves less together with {}.{}", tried, NEIGHBOURS, of_model)
    does = "mends" if best.robust <= found.total / 2 else "halves"
    return stated("No number alone {} it: at best {}.{}", does, _best_text(comparison, best), of_model)


def _best_text(comparison: Comparison, best: Change, words: str = "{} leaves {}{}") -> Statement:
    """What the best change of one number leaves, which is luck where its contact does not do what it should."""
    cancels = " by errors that cancel" if contact_fails(comparison, best) else ""
    return stated(words, value_text(best), percent(best.left), cancels)


def _largest_sentence(difference: Difference) -> str | Statement:
    if not difference.largest:
        return "So little needs no change."
    name, share = difference.name(difference.largest), percent(difference.parts[difference.largest])
    return stated("Its largest part is that of {}{} ({}).", "" if name.startswith("K") else "the ", name, share)


def certainty_sentences(together: Change | None) -> list[Statement]:
    """How certain it is what several changed numbers leave; none where it is exact."""
    if together is None or not together.difference.certainty:
        return []
    left = together.difference
    return [stated("With {} {} are left: {}.", value_text(together), left.amount, left.certainty)]


def detail_sentences(
    comparison: Comparison, found: Alone | None, contact: Conditions, cancelled: Poll | None
) -> tuple[str | Statement, ...]:
    """Return the numbers behind the headline of a verdict as sentences; without a search if there was none."""
    difference, lines = comparison.difference, []
    if comparison.pointwise:
        parts = joined(
            ", ", (stated("{} {}", difference.name(name), percent(value)) for name, value in difference.parts.items())
        )
        total = percent(difference.total)
        lines.append(stated("Of the {}: {}; these add up at each instant, not as numbers.", total, parts))
    elif difference.measure == "displacements":
        lines.append(_why_no_parts(comparison))
    if not touching(comparison.penalty) or not touching(comparison.reference):  # else nothing meets
        lines += [*_restitution_sentences(comparison, contact, cancelled), *contact_sentences(comparison, contact)]
    if comparison.encounters is not None:
        matches = comparison.encounters
        late = "" if np.isnan(matches.phase_error) else f", {percent(matches.phase_error)} of a period apart"
        lines.append(
            f"Impacts met in a period: {matches.matched:.3g}{late}; lost: {matches.lost:.3g}; "
            f"added: {matches.added:.3g}."
        )
    shares = [percent(motion.contact_share) for motion in (comparison.reference, comparison.penalty)]
    lines.append(f"Contact takes {shares[0]} of the time in the reference, {shares[1]} in the penalty solution.")
    if found is not None and found.changes:
        less = [each for each in found.changes if each.left < LESS * found.total]
        halving = [each for each in less if max(each.left, each.robust) <= HALF * found.total]
        if left := [_best_text(comparison, each, "{} {}{}") for each in halving or less[:1]]:
            lines.append(stated("What is left at best if one number alone is changed: {}.", joined("; ", left)))
    run = comparison.runs.penalty
    if run.periods > comparison.question.periods:
        lines.append(
            f"All this is of the last {run.keep:,} of {run.periods:,} periods: after "
            f"{comparison.question.periods:,} the motions had not settled."
        )
    return tuple(lines)


def _why_no_parts(comparison: Comparison) -> str:
    """Which motions the kept periods do not show to repeat: one that is blurred much does over more of them."""
    names = {
        "penalty": "the penalty solution",
        "exact": "the penalty solution without a time step",
        "derived": "the reference with the joint damping of the penalty model",
    }
    far = [text for name, text in names.items() if not getattr(comparison.motions, name).near_period]
    which = f"{' and '.join(far)} {'does' if len(far) == 1 else 'do'}"
    return (
        f"Over the {comparison.runs.penalty.keep} kept periods {which} not come back within "
        f"{percent(NEAR_TOLERANCE)} of the section's size, so that the difference, an average over them, has no parts."
    )


def _restitution_sentences(
    comparison: Comparison, contact: Conditions, cancelled: Poll | None
) -> tuple[Statement, ...]:
    """Return how fast the bodies part, measured or as a contact alone has it, and what would give e."""
    run = comparison.runs.penalty
    method, system, speed = run.method, run.system, comparison.closing_speed
    if math.isnan(contact.given):
        return ()
    where = "In a contact of this K and D alone" if math.isnan(contact.measured) else "In the motion"
    of_ratio = ""
    if method.linear:
        of_ratio = (
            f" (damping ratio of the contact ζ = {rounded(damping_ratio(system, method.stiffness, method.damping), 2)})"
        )
    asked = f"the restitution e asks for {share(system.restitution)}"
    if method.damping is None:
        asked += stated(", from which the law {} takes its damper", Choice("law", (method.law,)))
    as_asked = abs(contact.given - system.restitution) <= AS_ASKED * system.restitution
    ways = [] if as_asked else _ways_to_rebound(comparison, speed, cancelled)
    if ways:
        asked += stated(
            "; {} alone gives it" if method.damping is None else ", which {} alone gives", joined(" or ", ways)
        )
    return (
        stated(
            "{} the bodies part with {} of the speed at which they meet{}; {}.",
            where,
            share(contact.given),
            of_ratio,
            asked,
        ),
    )


def _ways_to_rebound(comparison: Comparison, speed: float, cancelled: Poll | None) -> list[Statement]:
    """The D and K of equal restitution, as they are written, whose own runs rebound as asked.

    Where other forces act, they do not. With the step and without it: with it alone a few contacts may do so by chance.
    """
    run, asked, ways = comparison.runs.penalty, comparison.question.periods, []
    system, method = run.system, run.method
    of_law = method.damping is None  # taken from the restitution: a D of its own may give it
    own = replace(method, damping=1.0) if of_law else method
    found = {"D": equal_damping(system, own, method.stiffness, speed), "K": equal_stiffness(system, method, speed)}
    keep = min(run.keep, asked)

    def rebounds(method: ExactPenalty | TimeStepping) -> bool:
        changed = run_again(run, method=method, periods=asked, keep=keep, cancelled=cancelled)
        delivered = delivered_restitution(changed) if changed.ok else math.nan
        return abs(delivered - system.restitution) <= AS_ASKED * system.restitution

    for name, value in found.items():
        present = math.nan if of_law else method.numbers[name]
        if not math.isfinite(value) or value <= 0.0 or abs(value - present) <= SAME_NUMBER * present:
            continue
        other = replace(method, **{METHOD_NUMBERS[name]: rounded_to(value, SENTENCE_DIGITS)})
        if all(rebounds(each) for each in dict.fromkeys((other, other.limit))):
            ways.append(equation(name, value, SENTENCE_DIGITS))
    return ways


def contact_sentences(comparison: Comparison, contact: Conditions) -> tuple[str | Statement, ...]:
    """Return how long a contact alone lasts, if it does not creep, and its restitution without the step and with it.

    Contacts in the motion may be held together for longer by other forces.
    """
    run, sentences = comparison.runs.penalty, []
    if run.method.linear and damping_ratio(run.system, run.method.stiffness, run.method.damping) < 1.0:
        beside = ""
        if abs(contact.lasts - contact.duration) > SAME_DURATION * contact.duration:
            beside = stated(" In the motion contacts last {} (median).", _time(contact.lasts, 3))
        steps = steps_text(contact.duration * run.eta * run.method.steps / (2 * math.pi))
        alone = _time(contact.duration, 4)
        sentences.append(stated("A contact of this K and D alone lasts {}: {} steps.{}", alone, steps, beside))
    if contact.alone is not None:
        once = "two bodies that meet once, without the springs, loads and further contacts of the motion"
        sentences.append(f"{contact.alone.sentence} Alone means {once}.")
    return tuple(sentences)


def _time(duration: float, digits: int) -> Statement:
    return Statement(Dimensionless("τ = "), Amount(duration, "time", digits))
