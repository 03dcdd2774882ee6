"""One impact in words: what was asked for, what the step gives, and from how many steps on it is close."""

import math
from collections.abc import Iterator
from dataclasses import replace

from vibroscope.engine import (
    CONTACT_STATUSES,
    INTEGRATORS,
    Impact,
    LargestStep,
    MoreauJean,
    OverMotion,
    Statement,
    WithStep,
    counted,
    impact,
    written,
)
from vibroscope.engine.contact import restitution_of_units
from vibroscope.engine.facts import Amount, stated
from vibroscope.engine.law_table import LAWS
from vibroscope.engine.one_impact.forward import Span
from vibroscope.engine.one_impact.of_system import ends_text, restitution_text, shares_text, span_text, steps_text
from vibroscope.engine.units import time_text


def counted_as(question: Impact) -> str:
    """What steps in a contact count, where the contact lasts longer or shorter; else empty."""
    lasts = question.without_step.time / question.time_step
    if steps_text(lasts) == steps_text(question.steps_per_contact):
        return ""
    damped = question.method.spring_exponent == 1.0 and question.ratio < 1.0
    spring = "its spring with the damper" if damped else "its spring alone"
    really = f"lasts {steps_text(lasts)} steps" if math.isfinite(lasts) else "does not end"
    return f"steps in a contact are counted as half a cycle of {spring}; without a step the contact {really}"


def by_formula(question: Impact, asked: float) -> str:
    """What the damper gives that the authors of the law made for this restitution; empty where that is the same."""
    law, method = LAWS[question.method.law], question.unit_method.limit
    if not law.damper or (law.divides and not asked):
        return ""
    given = restitution_text(restitution_of_units(replace(method, damping=None), asked))
    return "" if given == restitution_text(asked) else f"by the formula of the law's authors, its damper gives {given}"


def answer(question: Impact, asked: float, found: WithStep, by_numbers: bool = False) -> str:
    """What was asked for, or with ``by_numbers`` what K and D give, and what the step gives."""
    given, span = f"with {steps_text(question.steps_per_contact)} steps in a contact", span_text(found)
    got = f"you get {span}" if span else "no touch has a result"
    wanted = "K and D give {} without a step" if by_numbers else "You asked for {}"
    said = f"{wanted.format(restitution_text(asked))}; {given} {got}{shares_text(found)}."
    alone = restitution_text(question.without_step.restitution) if question.force else restitution_text(asked)
    pressed = f" Under the constant force the contact gives {alone} without a step."
    return said if alone == restitution_text(asked) else said + pressed


def advice(largest: LargestStep | None, tolerance: float, step: str | None = None) -> str:
    """From how many steps on the restitution is close; ``step`` is the largest in words, by default in seconds."""
    if largest is None:
        return f"No step down to 500 in a contact keeps it within {written(tolerance)}."
    steps = steps_text(largest.steps_per_contact)
    step = step or time_text(largest.step)
    return f"From {steps} steps on it stays within {written(tolerance)}: a step of at most {step}."


def over_speeds_of_motion(found: OverMotion) -> Statement:
    """What the contact gives at all closing speeds of a motion."""
    least, mean, greatest = map(restitution_text, found.restitution)
    given = f"{ends_text(least, greatest)}, mean {mean}"
    slow, fast = Amount(found.speeds.least, "velocity"), Amount(found.speeds.greatest, "velocity")
    same = written(slow.value, 3) == written(fast.value, 3)
    return stated(
        "{} with closing speeds {}: restitution {}; penetration up to {}, force up to {}, in {} steps.",
        counted(int(found.count.sum()), "impact"),
        stated("of {}", fast) if same else stated("from {} to {}", slow, fast),
        "none" if math.isnan(found.restitution.mean) else given,
        Amount(found.penetration.greatest, "displacement"),
        Amount(found.force.greatest, "force"),
        ends_text(*map(steps_text, (found.steps.least, found.steps.greatest))),
    )


def steps_in_contact(found: WithStep) -> str:
    """From the fewest steps in which the force acts to the most, or that there is no end to them."""
    if found.restitution.greatest == 0.0:  # it was only watched for some
        return "the contact does not end"
    return f"force in {ends_text(*map(str, found.steps))} steps"


def span_and_mean(span: Span) -> str:
    """From the least to the greatest, with the mean between them; "none" where no touch has a result."""
    if math.isnan(span.mean):
        return "none"
    ends = ends_text(written(span.least, 3), written(span.greatest, 3))
    return f"{ends}, mean {written(span.mean, 3)}" if " to " in ends else ends


def schemes(question: Impact, asked: float) -> Iterator[tuple[Impact | MoreauJean, WithStep]]:
    """The same contact with each integrator and contact status that go together, and last with an impact law."""
    for kind in INTEGRATORS.values():
        integrator = question.method.integrator if question.method.integrator.name == kind.name else kind()
        for status in CONTACT_STATUSES:
            if status == "end" and kind.explicit:
                continue
            method = replace(question.method, integrator=integrator, status=status)
            one = replace(question, method=method)
            yield one, impact(one)
    nonsmooth = MoreauJean(asked, question.time_step, question.speed, question.mass, question.force)
    yield nonsmooth, impact(nonsmooth)
