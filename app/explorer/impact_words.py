"""One impact in words: what was asked for, what the step gives, and from how many steps on it is close."""

import math
from collections.abc import Iterator
from dataclasses import replace

from vibroscope.engine import (
    CONTACT_STATUSES,
    INTEGRATORS,
    Impact,
    LargestStep,
    OverMotion,
    Statement,
    WithStep,
    counted,
    impact,
    percent,
    written,
)
from vibroscope.engine.facts import Amount, stated
from vibroscope.engine.units import time_text


def answer(question: Impact, asked: float, found: WithStep) -> str:
    """What was asked for, and what the step gives."""
    steps, e = written(question.steps_per_contact, 3), found.restitution
    if math.isnan(e.mean):
        return f"You asked for {_e(asked)}; with {steps} steps in a contact no touch has a result{_shares(found)}."
    least, greatest = _e(e.least), _e(e.greatest)
    given = f"{least} to {greatest}" if least != greatest else f"{least}"
    return f"You asked for {_e(asked)}; with {steps} steps in a contact you get {given}{_shares(found)}."


def advice(largest: LargestStep | None, tolerance: float, step: str = "") -> str:
    """From how many steps on the restitution is close; ``step`` is the largest in words, by default in seconds."""
    if largest is None:
        return f"No step down to 500 in a contact keeps it within {written(tolerance)}."
    steps = written(largest.steps_per_contact, 3)
    step = step or time_text(largest.step)
    return f"From {steps} steps on it stays within {written(tolerance)}: a step of at most {step}."


def over_speeds_of_motion(found: OverMotion) -> Statement:
    """What the contact gives at all closing speeds of a motion."""
    e = found.restitution
    given = f"{_e(e.least)} to {_e(e.greatest)}, mean {_e(e.mean)}" if e.mean == e.mean else "none"
    fewest, most = (written(each, 3) for each in (found.steps.least, found.steps.greatest))
    return stated(
        "{} with closing speeds from {} to {}: restitution {}; penetration up to {}, force up to {}, "
        "in {} to {} steps.",
        counted(int(found.count.sum()), "impact"),
        Amount(found.speeds.least, "velocity"),
        Amount(found.speeds.greatest, "velocity"),
        given,
        Amount(found.penetration.greatest, "displacement"),
        Amount(found.force.greatest, "force"),
        fewest,
        most,
    )


def _e(value: float) -> str:
    return f"{value:.2f}" if value < 9.995 else written(value, 3)


def _shares(found: WithStep) -> str:
    """The touches that do not end as they should."""
    kinds = {
        "have a step without a solution": found.without_solution,
        "have a step with two solutions": found.two_solutions,
        "blow up": found.blown_up,
        "stay together": found.stuck,
        "part faster than they came": found.gained,
    }
    texts = [f"{percent(share)} of the touches {words}" for words, share in kinds.items() if share > 5e-4]
    return f"; {', '.join(texts)}" if texts else ""


def schemes(question: Impact) -> Iterator[tuple[Impact, WithStep]]:
    """The same contact with each integrator and contact status that go together."""
    for kind in INTEGRATORS.values():
        integrator = question.method.integrator if question.method.integrator.name == kind.name else kind()
        for status in CONTACT_STATUSES:
            if status == "end" and kind.explicit:
                continue
            method = replace(question.method, integrator=integrator, status=status)
            one = replace(question, method=method)
            yield one, impact(one)
