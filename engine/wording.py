"""Numbers as they appear in sentences: percentages, counts with their noun, periods of recurrence.

Every share in the sentences, bars and tables of a comparison and a recommendation passes through :func:`percent`, so
that one number has the same digits wherever it stands.
"""

import math
from collections.abc import Mapping
from html import escape

NOT_KNOWN = "not known"  # no sentence holds nan or inf
MOST_DIGITS = 6  # of a share beside a limit that it hardly differs from
ROUNDED_DIGIT = 1e-9  # of the second digit: a number that exceeds it by less does so by rounding
MOST_SHARE = 10  # a larger share is of motions that have nothing in common, whatever its size


def percent(fraction: float, beside: float | None = None) -> str:
    """A fraction in per cent with two digits, never with an exponent; rounding errors count as zero.

    What is above 1000 % is said to be so.

    Parameters
    ----------
    fraction : float
    beside : float, optional
        A limit that stands beside it: it gets as many digits more as show on which side of the limit it lies.

    Examples
    --------
    >>> from vibroscope.engine import percent
    >>> percent(0.0123456), percent(3e-9)
    ('1.2 %', '0 %')
    >>> percent(0.0999), percent(0.0999, beside=0.1)
    ('10 %', '9.99 %')
    >>> percent(1.2e7)
    'more than 1000 %'
    """
    if not math.isfinite(100 * fraction):
        return NOT_KNOWN
    if fraction < 1e-7:
        return "0 %"
    if fraction > MOST_SHARE:
        return f"more than {100 * MOST_SHARE} %"
    digits = 2
    text = rounded(100 * fraction, digits)
    while beside is not None and digits < MOST_DIGITS and _hides_side(float(text) / 100, fraction, beside):
        digits += 1
        text = rounded(100 * fraction, digits)
    return f"{text} %"


def rounded_to(value: float, digits: int) -> float:
    """Round to so many significant digits."""
    return float(f"{value:.{digits}g}")


def rounded_up(value: float) -> float:
    """Round up to two significant digits; what exceeds two by rounding alone keeps them.

    Examples
    --------
    >>> from vibroscope.engine.wording import rounded_up
    >>> rounded_up(1201.0), rounded_up(0.012)
    (1300.0, 0.012)
    """
    unit = 10.0 ** (math.floor(math.log10(value)) - 1)
    return rounded_to(math.ceil(value / unit - ROUNDED_DIGIT) * unit, 2)


def rounded(value: float, digits: int) -> str:
    """A number with so many significant digits, or all those before the point; no exponent, no zeros at the end.

    Examples
    --------
    >>> from vibroscope.engine import rounded
    >>> rounded(1234.5, 2), rounded(0.000123, 2)
    ('1234', '0.00012')
    """
    if not math.isfinite(value):
        return NOT_KNOWN
    if value == 0:
        return "0"
    decimals = max(0, digits - 1 - math.floor(math.log10(abs(value))))
    text = f"{value:.{decimals}f}"
    return text.rstrip("0").rstrip(".") if "." in text else text


def counted(count: float, noun: str) -> str:
    """A count with its noun in the singular or plural, such as "1 period" or "2.5 contacts".

    Examples
    --------
    >>> from vibroscope.engine import counted
    >>> counted(1, "period"), counted(2.5, "contact")
    ('1 period', '2.5 contacts')
    """
    text = rounded(count, 3)
    return f"{text} {noun}{'' if text == '1' else 's'}"


def many(count: int) -> str:
    """A large whole number, such as "55", "410,000" or "16.4 million"."""
    if not math.isfinite(count):
        return NOT_KNOWN
    return f"{count:,}" if count < 1e6 else f"{rounded(count / 1e6, 3)} million"


def end_text(value: float) -> str:
    """A number as the end of a range, such as "0.05" or "1e-9"."""
    return f"{value:.6g}".replace("e+", "e").replace("e0", "e").replace("e-0", "e-")


def finite_or_none(value: float) -> float | None:
    """The number, or None where it is infinite or not a number, which JSON cannot hold."""
    return value if math.isfinite(value) else None


def every(periods: int) -> str:
    """How often something recurs: "every period" or "every 2 periods"."""
    return "every period" if periods == 1 else f"every {periods} periods"


def _hides_side(shown: float, fraction: float, limit: float) -> bool:
    """Whether the rounded fraction lies on the other side of the limit than the fraction, or on the limit."""
    return fraction != limit and (shown - limit) * (fraction - limit) <= 0


def html_table(title: str, rows: Mapping[str, object]) -> str:
    """A result as a notebook shows it: its line, and a row for each of its numbers."""
    texts = {name: f"{value:.6g}" if isinstance(value, float) else str(value) for name, value in rows.items()}
    body = "".join(f"<tr><th>{escape(name)}</th><td>{escape(text)}</td></tr>" for name, text in texts.items())
    return f"<p>{escape(title)}</p><table>{body}</table>"
