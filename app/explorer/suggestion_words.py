"""What a suggestion says of its ranges, its contacts, and what it was verified for. No panel import."""

import math
from collections.abc import Callable

from vibroscope.app.explorer.method_words import words_of_scheme
from vibroscope.engine import Recommendation, percent, rounded, written
from vibroscope.engine.facts import Statement, equation, joined, span, stated
from vibroscope.engine.one_impact.of_system import steps_text

OF_THE_MODEL = "a number of the contact model, not of the system: it grows with K"


def range_words(found: Recommendation) -> Statement:
    """The ranges of K and D, empty if there are none, as "K = 7920 to 11100 where D = 14.6"."""
    k, d, _ = found.best.setting if found.best else (None, None, None)
    rows = (("stiffness", "K", equation("D", d or 0, 4)), ("damping", "D", equation("K", k or 0, 4)))
    ends = {name: found.ranges[name] for name, *_ in rows if name in found.ranges}
    return joined(
        "; ",
        (
            stated("{} where {}", span(symbol, _inwards(low, up=True), _inwards(high, up=False), 4), other)
            for name, symbol, other in rows
            if name in ends
            for low, high in [ends[name]]
        ),
    )


def _inwards(value: float, *, up: bool) -> float:
    """An end of a range with three digits, rounded into the range."""
    unit = 10.0 ** (math.floor(math.log10(value)) - 2)
    return float(f"{(math.ceil if up else math.floor)(value / unit) * unit:.3g}")


def contact_words(found: Recommendation) -> str:
    """How long the contacts are, how the bodies rebound, and what a contact alone does with this step."""
    contacts, tolerance = found.best.contacts, found.tolerances.restitution
    if contacts is None:
        return ""
    parts = [] if math.isnan(contacts.steps) else [f"{steps_text(contacts.steps)} steps in each"]
    if not math.isnan(contacts.restitution):
        asked = f"e asks for {rounded(contacts.wanted, 2)}, {_within(tolerance and rounded(tolerance, 2))}"
        parts.append(
            f"the bodies part with {rounded(contacts.restitution, 2)} of the speed at which they meet ({asked})"
        )
    if found.alone is not None:
        off = tolerance and found.alone.is_off(tolerance, contacts.wanted)
        beyond = f", not within {rounded(tolerance, 2)} at each touch" if off else ""
        parts.append(f"once its force is over, a contact alone has a restitution of {found.alone.words}{beyond}")
    if contacts.unsolved:
        parts.append(f"{contacts.unsolved:,} steps of the run have no solution: a code must cut them, or it stops")
    return "; ".join(parts)


def force_words(found: Recommendation, force: Callable[[float], str] = written) -> str:
    """The peak force, and how far it is from that without a time step."""
    contacts, tolerance = found.best.contacts, found.tolerances.force
    if contacts is None or math.isnan(contacts.peak_force):
        return "not known, since the steps are cut where contact changes" if found.question.located else "not known"
    text = f"{force(contacts.peak_force)}, {OF_THE_MODEL}"
    if math.isnan(contacts.force_error):
        return text
    side = "above" if contacts.force_error >= 0 else "below"
    limit = _within(tolerance and percent(tolerance))
    return f"{text}; {percent(abs(contacts.force_error))} {side} that without a time step ({limit})"


def verified_words(found: Recommendation) -> str:
    """The integrator, contact status and law that a suggestion was verified with."""
    return f"{words_of_scheme(found.scheme)}; from rest"


def _within(tolerance: str | float | None) -> str:
    return f"within {tolerance}" if tolerance else "no tolerance asked for"
