"""What a contact gives with its step in words: the restitution over the instant of touch, and what goes wrong."""

import math

from vibroscope.engine.one_impact.forward import WithStep
from vibroscope.engine.units import written
from vibroscope.engine.wording import percent

_SHOWN = 5e-4  # share of the touches from which on it is said


def steps_text(steps: float) -> str:
    """Steps in a contact, as they are written wherever they are counted."""
    return written(steps, 3)


def restitution_text(value: float) -> str:
    """A restitution with two decimals; with three digits where it is none any more."""
    return f"{value:z.2f}" if value < 9.995 else written(value, 3)


def span_text(found: WithStep) -> str:
    """The restitution from the least to the greatest over the instant of touch; empty if no touch has a result."""
    if math.isnan(found.restitution.mean):
        return ""
    least, greatest = restitution_text(found.restitution.least), restitution_text(found.restitution.greatest)
    return f"{least} to {greatest}" if least != greatest else least


def shares_text(found: WithStep) -> str:
    """The touches that do not end as they should, after a semicolon; empty if there are none."""
    kinds = {
        "have a step without a solution": found.without_solution,
        "have a step with two solutions": found.two_solutions,
        "blow up": found.blown_up,
        "stay together": found.stuck,
        "part faster than they came": found.gained,
    }
    texts = [f"{percent(share)} of the touches {words}" for words, share in kinds.items() if share > _SHOWN]
    return f"; {', '.join(texts)}" if texts else ""
