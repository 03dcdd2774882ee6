"""A number as a person writes one: what its text can mean. Imports nothing, since every command reads numbers.

Thousands separators, decimal commas and powers of ten are read. A text that can mean two different numbers means
both; who asks refuses it with `two_meanings`, and never guesses.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterable
from typing import NamedTuple

LONGEST_NUMBER = 40
_LONGEST_QUOTE = 30
_SPACING = str.maketrans(dict.fromkeys(" ·⋅*") | {"µ": "u", "μ": "u"})
_POINTS = re.compile(r"(?<![0-9])\.|\.(?![0-9])")  # between parts of a unit, as in N.s/m; not that in m^1.5
_SUPERSCRIPTS = str.maketrans("⁰¹²³⁴⁵⁶⁷⁸⁹⁻⁺", "0123456789-+")
# Sign, digits with separators, power of ten as 1e5 or 1·10⁵, and the rest: a unit.
_TYPED = re.compile(
    r"([+\-−]?)\s*([0-9][0-9.,'’_\s]*|[.,][0-9]+)"
    r"(?:[eE]([+\-−]?[0-9]{1,4})|\s*[×·*x]\s*10\s*(?:\^|\*\*)?\s*([+\-−]?[0-9]{1,4}|[⁺⁻]?[⁰¹²³⁴⁵⁶⁷⁸⁹]{1,4}))?\s*(.*)",
    re.DOTALL,
)
_GROUPS = {mark: re.compile(rf"[0-9]{{1,3}}({re.escape(mark)}[0-9]{{3}})+") for mark in " '_,."}
_LEADING_GROUP = re.compile(r"[1-9][0-9]{0,2}")


class Typed(NamedTuple):
    """The meanings of a typed text: one number, or two if comma and point are ambiguous; and its unit."""

    numbers: tuple[float, ...]
    unit: str


def parse_typed(text: object, *, whole: bool = False, decimal_point: bool = False) -> Typed:
    """The numbers that ``text`` can mean, none if it is no number.

    ``whole``: a whole number is expected; ``decimal_point``: a single point is one, as programs write it.
    """
    match = _TYPED.fullmatch(text.strip()) if isinstance(text, str) and len(text) <= LONGEST_NUMBER else None
    if match is None:
        return Typed((), "")
    sign, digits, plain_power, ten_power, unit = match.groups()
    power = (plain_power or ten_power or "0").translate(_SUPERSCRIPTS).replace("−", "-")
    bodies = _plain_digits(" ".join(digits.replace("’", "'").split()), whole, decimal_point)
    numbers = (float(f"{sign.replace('−', '-')}{body}e{power}") for body in bodies)
    return Typed(tuple(dict.fromkeys(n for n in numbers if math.isfinite(n))), plain_unit(unit))


def _plain_digits(text: str, whole: bool, decimal_point: bool) -> Iterable[str]:
    """The digits without separators and with a decimal point, one text for each meaning."""
    for mark in " '_":
        if mark in text:  # it can only separate thousands
            return _grouped(text, mark, decimal="," if "," in text else ".")
    marks = {mark: text.count(mark) for mark in ".," if mark in text}
    if len(marks) == 2:  # the last one is the decimal one
        thousands, decimal = sorted(marks, key=text.rfind)
        return _grouped(text, thousands, decimal)
    if not marks:
        return [text]
    ((mark, count),) = marks.items()
    if count > 1:
        return _grouped(text, mark, decimal="")
    left, _, right = text.partition(mark)
    if not right and mark == ",":
        return []
    as_decimal, as_thousands = f"{left or 0}.{right or 0}", left + right
    if not (_LEADING_GROUP.fullmatch(left) and len(right) == 3) or (mark == "." and decimal_point):
        return [as_decimal]
    if whole:
        return [as_thousands]  # nobody writes the decimals of a whole number
    return [as_thousands, as_decimal] if mark == "," or right == "000" else [as_decimal]


def _grouped(text: str, thousands: str, decimal: str) -> list[str]:
    """The digits of a number with separated thousands, and perhaps decimals; nothing if they are not in threes."""
    left, _, right = text.partition(decimal) if decimal else (text, "", "")
    is_number = _GROUPS[thousands].fullmatch(left) and (not right or re.fullmatch("[0-9]+", right))
    return [f"{left.replace(thousands, '')}.{right or 0}"] if is_number else []


def two_meanings(text: str, numbers: tuple[float, float], unit: str = "") -> str:
    """Why a text is refused that can mean two numbers, and how to write each of them."""
    large, small = numbers
    unit = unit and f" {unit}"
    return (
        f"{quote(text)} can mean {print_number(large)}{unit} or {print_number(small)}{unit}: "
        f"write {print_number(large)} or {float(small)!r}."
    )


def plain_unit(text: str) -> str:
    """A unit as typed, without spaces and points between its parts."""
    return _POINTS.sub("", text.replace("**", "^").translate(_SPACING))


def quote(text: object) -> str:
    """A value from outside in quotes, printable and short enough to show; of what is not text, the type."""
    shown = text if isinstance(text, str) else type(text).__name__
    printable = "".join(c if c.isprintable() else "�" for c in shown[:_LONGEST_QUOTE])
    return f"“{printable}{'…' if len(shown) > _LONGEST_QUOTE else ''}”"


def print_number(value: float | int) -> str:
    """The shortest text that reads back as exactly ``value``."""
    if isinstance(value, float) and value.is_integer() and abs(value) < 1e15:
        return str(int(value))
    return repr(value)


def print_value(value: float | int | str) -> str:
    """The text of a choice, or of a number, from which a reader of settings reads exactly the same value."""
    return value if isinstance(value, str) else print_number(value)
