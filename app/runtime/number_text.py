"""A number as a person writes one: what its text can mean. Imports nothing, since every command reads numbers.

Thousands separators, decimal commas and powers of ten are read. A text that can mean two different numbers means
both; who asks refuses it with `two_meanings`, and never guesses.

Units that people type behind a number, on the page and on the command line. Imports nothing of the engine.
"""

import math
import re
from collections.abc import Iterable, Mapping
from typing import NamedTuple

_SQUARE, _CUBIC = ("²", "2", "^2"), ("³", "3", "^3")
# What one of each is worth in the SI unit of its quantity; as `number_text.plain_unit` writes them.
TYPED_UNITS = {
    "frequency": {"Hz": 1.0, "kHz": 1e3, "rad/s": 0.5 / math.pi, "1/s": 0.5 / math.pi},
    "angular_frequency": {"1/s": 1.0, "rad/s": 1.0, "Hz": 2 * math.pi, "kHz": 2e3 * math.pi},
    "stiffness": {"N/m": 1.0, "kN/m": 1e3, "MN/m": 1e6, "N/mm": 1e3, "kN/mm": 1e6},
    "damping": {"Ns/m": 1.0, "kg/s": 1.0, "kNs/m": 1e3, "Ns/mm": 1e3, "kNs/mm": 1e6},
    "velocity": {"m/s": 1.0, "cm/s": 1e-2, "mm/s": 1e-3},
    "mass": {"kg": 1.0, "g": 1e-3, "t": 1e3},
    "displacement": {"m": 1.0, "cm": 1e-2, "mm": 1e-3, "um": 1e-6},
    "area": {f"{of}{power}": size for of, size in (("m", 1.0), ("cm", 1e-4), ("mm", 1e-6)) for power in _SQUARE},
    "time": {"s": 1.0, "ms": 1e-3, "us": 1e-6},
    "force": {"N": 1.0, "kN": 1e3, "MN": 1e6, "mN": 1e-3},
    "acceleration": {f"{of}/s{power}": size for of, size in (("m", 1.0), ("mm", 1e-3)) for power in _SQUARE},
    "angle": {"rad": 1.0, "°": math.pi / 180, "deg": math.pi / 180},
    "share": {"": 1.0, "%": 0.01},
}
TYPED_UNITS["acceleration"]["g"] = 9.80665
# What is over the contact area, as a foundation modulus.
TYPED_UNITS["pressure"] = {
    **{f"N/m{power}": 1.0 for power in _SQUARE},
    **{f"N/mm{power}": 1e6 for power in _SQUARE},
    **{"Pa": 1.0, "kPa": 1e3, "MPa": 1e6, "GPa": 1e9},
}
for _quantity, _of_speed in (("stiffness_per_area", ""), ("damping_per_area", "s")):
    TYPED_UNITS[_quantity] = {
        **{f"N{_of_speed}/m{power}": 1.0 for power in _CUBIC},
        **{f"N{_of_speed}/mm{power}": 1e9 for power in _CUBIC},
        **{f"{of}{_of_speed}/m": size for of, size in (("Pa", 1.0), ("MPa", 1e6), ("GPa", 1e9))},
        **{f"{of}{_of_speed}/mm": size for of, size in (("Pa", 1e3), ("MPa", 1e9), ("GPa", 1e12))},
    }
TYPED_UNITS |= {f"contact_{name}": TYPED_UNITS[name] for name in ("stiffness", "damping")}
_PER_LENGTH = re.compile(r"(.+/)(m|mm)")
_OF_LAW = re.compile(r"[kM]?Ns?/m?m\^[0-9.]+")  # of a contact law that is not linear


def sizes(quantity: str, one: float, power: float = 0.0) -> dict[str, float]:
    """The factor of each unit of a quantity to the unit that is ``one`` SI unit.

    ``power``: of K and D of a contact law that is not linear, the power of length by which they are divided beyond a
    stiffness and a damper: 0.5 of a Hertz spring, in N/m^1.5.
    """
    units = TYPED_UNITS[quantity]
    if power:
        found = [(match, size) for unit, size in units.items() if (match := _PER_LENGTH.fullmatch(unit))]
        units = {
            f"{match[1]}{match[2]}^{1.0 + power:.6g}": size * TYPED_UNITS["displacement"][match[2]] ** -power
            for match, size in found
        }
    return {unit: size / one for unit, size in units.items()}


def scaled(number: float, size: float) -> float:
    """A typed number in another unit, without the digits that rounding adds: 0.3 of 1e-3 is 0.0003."""
    return number if size == 1 else float(f"{number * size:.15g}")


def seconds_of(unit: str) -> float | None:
    """A typed unit of time in seconds; None if it is none."""
    return TYPED_UNITS["time"].get(unit)


def is_unit(unit: str) -> bool:
    """Whether what is typed after a number is a unit of some quantity."""
    return bool(unit) and (any(unit in units for units in TYPED_UNITS.values()) or bool(_OF_LAW.fullmatch(unit)))


def list_units(units: Mapping[str, float]) -> str:
    """The units for a refusal."""
    return ", ".join(unit for unit in units if unit)


def steps_of_time(period: float, seconds: float) -> int:
    """The fewest steps in a period of at most a time each."""
    return math.ceil(period / seconds * (1 - 1e-9))


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
