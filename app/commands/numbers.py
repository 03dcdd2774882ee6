"""Numbers as options have them: as people and programs write them, and for systems in physical units with a unit.

The arguments are read before it is known what a unit is worth, since the system file says that. So a number with a
unit, as ``--K "1e6 N/m"``, stays a `Measured` until `resolve_units`, when all options are there.
"""

import argparse
import math
from contextlib import suppress
from dataclasses import dataclass, replace

from vibroscope.app.runtime.number_text import parse_typed, quote, two_meanings
from vibroscope.app.runtime.typed_units import is_unit, list_units, scaled, seconds_of, sizes, steps_of_time

# Quantities of the options that may have a unit, by their names; the time step is given as a time.
QUANTITIES = {"eta": "frequency", "K": "stiffness", "K_max": "stiffness", "D": "damping", "threshold": "velocity"}
QUANTITIES |= {"penetration": "displacement", "steps": "time"}
# Ends of a range: the option that names their number.
_ENDS = {"low": "over", "high": "over", "along_from": "along", "along_to": "along"}


class NotANumber(argparse.ArgumentTypeError, ValueError):
    """A text is no number at all, be it an argument or a part of one."""


@dataclass(frozen=True)
class Measured:
    """A number with a unit, of which it is not yet known what it is in the model."""

    text: str
    number: float
    unit: str


def number(text: str) -> float:
    """A number as a person writes one: with separated thousands or a decimal comma, where it can mean only one."""
    return _read(text, whole=False)


def count(text: str) -> float:
    """The same where a whole number is expected, so that a comma before three digits separates thousands."""
    return _read(text, whole=True)


def measured(text: str) -> float | Measured:
    """The same as `number`, or with a unit."""
    return _read_measured(text, whole=False)


def measured_count(text: str) -> float | Measured:
    """The same as `count`, or with a unit."""
    return _read_measured(text, whole=True)


def _read(text: str, whole: bool, unit: str = "") -> float:
    typed = parse_typed(text, whole=whole, decimal_point=True)
    found = list(typed.numbers if typed.unit == unit else ())
    with suppress(ValueError):  # what a program writes has that meaning too
        found.append(float(text))
    if not found:
        raise NotANumber(f"{quote(text)} is no number: write it as 12000, 1.08 or 1.2e4, without a unit")
    if len(meanings := tuple(dict.fromkeys(found))) == 2:
        raise argparse.ArgumentTypeError(two_meanings(text, meanings, unit).removesuffix("."))
    return found[0]


def _read_measured(text: str, whole: bool) -> float | Measured:
    unit = parse_typed(text, decimal_point=True).unit
    if not unit or not is_unit(unit):
        return _read(text, whole)
    return Measured(text, _read(text, False, unit), unit)


def numbers(text: str) -> tuple[float, ...]:
    """Comma-separated numbers."""
    try:
        return tuple(float(part) for part in text.split(","))
    except ValueError:
        raise argparse.ArgumentTypeError(f"{text!r} is not a list of numbers: give x1,v1,x2,v2") from None


def resolve_units(options: argparse.Namespace) -> None:
    """Put the number of the model in place of each one with a unit; raises ValueError in words."""
    given = vars(options)
    for name in sorted(given, key=lambda name: name == "steps"):  # a time is a part of the period, which η gives
        swept = given.get(_ENDS[name]) if name in _ENDS else name
        given[name] = _resolved(given[name], name, QUANTITIES.get(swept), options)


def _resolved(value: object, name: str, quantity: str | None, options: argparse.Namespace) -> object:
    if isinstance(value, tuple):  # a range
        return tuple(_resolved(each, name, quantity, options) for each in value)
    if not isinstance(value, Measured):
        return value
    option = f"--{name.replace('_', '-')}"
    option = {"--low": "--from", "--high": "--to"}.get(option, option)
    if quantity is None:
        raise ValueError(f"{option} {value.text!r}: this number is given without a unit")
    file = getattr(options, "system", None)
    if file is None or not file.has_units:
        raise ValueError(
            f"{option} {value.text!r}: a unit has no meaning without a system in physical units: give --system FILE "
            "with [physical] or [units], or the number without a unit"
        )
    return _of_model(option, value, quantity, file, options)


def _of_model(option: str, value: Measured, quantity: str, file, options: argparse.Namespace) -> float:
    one = replace(file.units, system="si").factor(quantity)
    units = sizes(quantity, one)
    if value.unit not in units:
        raise ValueError(f"{option} {value.text!r}: give it in {list_units(units)}, or without a unit")
    if quantity != "time":
        return scaled(value.number, units[value.unit])
    eta = file.eta if options.eta is None else options.eta
    if eta is None or not eta > 0 or not value.number > 0:
        raise ValueError(f"{option} {value.text!r}: a time step is above 0 and needs --eta or frequency_Hz: give both")
    return steps_of_time(2 * math.pi / eta * one, value.number * seconds_of(value.unit))
