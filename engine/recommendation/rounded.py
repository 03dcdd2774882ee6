"""A question with ten digits: what depends on further ones is rounding, and a search must not answer it differently."""

from dataclasses import fields, is_dataclass, replace

DIGITS = 10


def round_numbers(value):
    """Return a number, or a dataclass with all its numbers, rounded to so many significant digits.

    Examples
    --------
    >>> from vibroscope.engine.recommendation.rounded import round_numbers
    >>> round_numbers(1.18 * (1 + 1e-12))
    1.18
    """
    if is_dataclass(value):
        numbers = {each.name: round_numbers(getattr(value, each.name)) for each in fields(value) if each.init}
        return replace(value, **numbers)
    return float(f"{value:.{DIGITS}g}") if isinstance(value, float) else value
