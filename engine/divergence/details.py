"""The numbers behind a verdict, a sentence each."""

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np
from vibroscope.engine.contact import damping_ratio, equal_damping, equal_stiffness
from vibroscope.engine.divergence.alone import Alone
from vibroscope.engine.divergence.compare import Comparison
from vibroscope.engine.divergence.conditions import Conditions
from vibroscope.engine.divergence.encounters import delivered_restitution
from vibroscope.engine.divergence.grid import run_again
from vibroscope.engine.divergence.sentences import SENTENCE_DIGITS, share, value_text
from vibroscope.engine.divergence.tolerances import AS_ASKED, HALF, SAME_DURATION, SAME_NUMBER
from vibroscope.engine.drivers.section import NEAR_TOLERANCE
from vibroscope.engine.facts import Amount, Choice, Dimensionless, Statement, equation, joined, stated
from vibroscope.engine.methods import METHOD_NUMBERS
from vibroscope.engine.motions.words import touching
from vibroscope.engine.one_impact.words import steps_text
from vibroscope.engine.wording import percent, rounded


def detail_sentences(
    comparison: Comparison, found: Alone | None, contact: Conditions, cancelled: Callable[[], bool] | None
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
        lines += [
            *_restitution_sentences(comparison, contact, cancelled),
            *contact_sentences(comparison, contact),
        ]
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
        halving = [each for each in found.changes if max(each.left, each.robust) <= HALF * found.total]
        left = (stated("{} {}", value_text(each), percent(each.left)) for each in halving or found.changes[:1])
        lines.append(stated("What is left at best if one number alone is changed: {}.", joined("; ", left)))
    run = comparison.runs.penalty
    if run.periods > comparison.asked:
        lines.append(
            f"All this is of the last {run.keep:,} of {run.periods:,} periods: after {comparison.asked:,} the motions "
            "had not settled."
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
    comparison: Comparison, contact: Conditions, cancelled: Callable[[], bool] | None
) -> tuple[Statement, ...]:
    """Return how fast the bodies part, measured or as a contact alone has it, and what would give e."""
    run = comparison.runs.penalty
    method, system, speed = run.method, run.system, comparison.closing_speed
    if math.isnan(contact.given):
        return ()
    who = "In a contact of this K and D alone the bodies part" if math.isnan(contact.measured) else "The bodies part"
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
        asked += stated(", which {} alone gives", joined(" or ", ways))
    return (stated("{} with {} of the speed at which they meet{}; {}.", who, share(contact.given), of_ratio, asked),)


def _ways_to_rebound(comparison: Comparison, speed: float, cancelled: Callable[[], bool] | None) -> list[Statement]:
    """The D and K of equal restitution whose own runs rebound as asked: where other forces act, they do not."""
    run, asked, ways = comparison.runs.penalty, comparison.asked, []
    system, method = run.system, run.method
    found = {"D": equal_damping(system, method, method.stiffness, speed), "K": equal_stiffness(system, method, speed)}
    for name, value in found.items():
        present = method.numbers[name]
        if not math.isfinite(value) or value <= 0.0 or abs(value - present) <= SAME_NUMBER * present:
            continue
        other, keep = replace(method, **{METHOD_NUMBERS[name]: value}), min(run.keep, asked)
        changed = run_again(run, method=other, periods=asked, keep=keep, cancelled=cancelled)
        delivered = delivered_restitution(changed) if changed.ok else math.nan
        if abs(delivered - system.restitution) <= AS_ASKED * system.restitution:
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
        sentences.append(contact.alone.sentence)
    return tuple(sentences)


def _time(duration: float, digits: int) -> Statement:
    return Statement(Dimensionless("τ = "), Amount(duration, "time", digits))
