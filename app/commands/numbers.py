"""Numbers as options have them: as people and programs write them, and for systems in physical units with a unit.

The arguments are read before it is known what a unit is worth, since the system file says that. So a number with a
unit, as ``--K "1e6 N/m"``, stays a `Measured` until `resolve_units`, when all options are there.
"""

import argparse
import math
import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import partial

from vibroscope.app.commands.parser import option
from vibroscope.app.explorer.parameters import FIELDS
from vibroscope.app.runtime.number_text import (
    TYPED_UNITS,
    list_units,
    parse_typed,
    quote,
    scaled,
    seconds_of,
    sizes,
    steps_of_time,
    two_meanings,
)
from vibroscope.engine import SystemFile, Units

# Quantities of the numbers of a state.
STATE = {"xi1": "displacement", "v1": "velocity", "xi2": "displacement", "v2": "velocity"}
# Ends of a range: the option that names their number.
_ENDS = {"low": "over", "high": "over", "along_from": "along", "along_to": "along"}
_OF_FIELD = "of the field that another option names"
# The system of commands that need none: in these units a number without one is in SI units, and so is the result.
SI = SystemFile(units=Units(omega1=1.0, m1=1.0, base_amplitude=1e3), has_units=True)
STEPS = "steps"  # a whole number of them in a period, or the time of one


class NotANumber(argparse.ArgumentTypeError, ValueError):
    """A text is no number at all, be it an argument or a part of one."""


@dataclass(frozen=True)
class Measured:
    """A number with a unit, before it is converted to a number of the model."""

    text: str
    number: float
    unit: str
    quantity: str


Read = float | Measured


def number(text: str) -> float:
    """A number as a person writes one: with separated thousands or a decimal comma, where it can mean only one."""
    return _read(text, whole=False)


def count(text: str) -> float:
    """Read a whole number as `number` does; a comma before three digits separates thousands."""
    return _read(text, whole=True)


def share(text: str) -> float:
    """A share of something, as 0.05 or 5 %."""
    typed = parse_typed(text, decimal_point=True)
    size = TYPED_UNITS["share"].get(typed.unit) if typed.numbers else None
    return number(text) if size is None else scaled(_read(text, False, typed.unit), size)


def measured(quantity: str) -> Callable[[str], Read]:
    """A reader of a number as `number` reads one, or with a unit of a quantity; or of `STEPS`."""
    return partial(_read_measured, quantity=quantity)


def of_field(name: str) -> Callable[[str], Read]:
    """A reader of the number of a field; the steps of a period may be given as a time."""
    return measured(quantity) if (quantity := _quantity_of(name)) else number


def _quantity_of(name: str) -> str:
    return STEPS if name == "steps" else FIELDS[name].quantity


def end_of_range(text: str) -> Read:
    """An end of a range of the number that another option names."""
    return _read_measured(text, _OF_FIELD)


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


def _read_measured(text: str, quantity: str) -> Read:
    typed = parse_typed(text, decimal_point=True)
    unit = typed.unit if typed.numbers else ""  # known or not: which units an option takes is known when it is resolved
    if not unit:
        return _read(text, quantity == STEPS)
    return Measured(text, _read(text, False, unit), unit, quantity)


def state_numbers(text: str) -> tuple[Read, ...]:
    """The numbers of a state, comma-separated, each with a unit or without."""
    return list_of(text, "x1,v1,x2,v2", STATE.values())


def step_numbers(text: str) -> tuple[Read, ...]:
    """Numbers of steps, comma-separated, or time steps."""
    return list_of(text, "2000,4000,8000", [STEPS] * (text.count(",") + 1))


def list_of(text: str, example: str, quantities: Iterable[str]) -> tuple[Read, ...]:
    """Numbers of these quantities, comma-separated, each with a unit or without."""
    parts, quantities = text.split(","), tuple(quantities)
    quantities += ("",) * (len(parts) - len(quantities))  # the engine says if there are more or fewer
    try:
        found = tuple(_read_measured(part, quantity) for part, quantity in zip(parts, quantities, strict=False))
    except NotANumber:
        raise argparse.ArgumentTypeError(f"{text!r} is not a list of numbers: give {example}") from None
    return _of_one_kind(text, parts, found)


def _of_one_kind(text: str, parts: Sequence[str], found: tuple[Read, ...]) -> tuple[Read, ...]:
    """What was read of parts of a text; none but zero may be without a unit beside another that has one."""
    has_unit = [isinstance(each, Measured) and each.quantity != STEPS for each in found]
    for part, each in zip(parts, found, strict=True):
        if any(has_unit) and not isinstance(each, Measured) and each != 0.0:
            raise argparse.ArgumentTypeError(
                f"{text!r}: {part.strip()} has no unit beside numbers that have one: give a unit to each, or to none"
            )
    return found


def span(text: str, quantity: str, example: str = "a:b:n, as 100:60000:64") -> tuple[Read, Read, float]:
    """``a:b:n``: both ends of a range, each with a unit or without, and how many values it has."""
    try:
        low, high, cells = text.split(":")
        ends, count = (_read_measured(low, quantity), _read_measured(high, quantity)), number(cells)
    except ValueError:
        raise argparse.ArgumentTypeError(f"{text!r} is no range: give {example}") from None
    return *_of_one_kind(text, (low, high), ends), count


def resolve_units(options: argparse.Namespace) -> dict[str, str]:
    """Put the number of the model in place of each one with a unit; raises ValueError in words.

    Returns what was typed for each such number, by the number as the words of a refusal have it, for `as_typed`: by
    its name too, or by the number alone where no other is the same.
    """
    given, typed = vars(options), {}
    plain = {repr(value) for value in given.values() if isinstance(value, float | int)}  # which were not typed so
    for name in sorted(given, key=lambda name: name == "steps"):  # a time is a part of the period, which η gives
        before, given[name] = given[name], _resolved(given[name], name, options)
        many = isinstance(before, tuple)
        for text, number in zip(before, given[name], strict=True) if many else [(before, given[name])]:
            if not isinstance(text, Measured):
                continue
            size = math.nan if text.quantity == STEPS else _resolved(replace(text, number=1.0), name, options)
            typed[f"{name} = {number!r} is "] = text, size
            if repr(number) not in plain:
                plain.add(repr(number))
                typed[f" = {number!r} is "] = text, size
    return typed


_RANGE = re.compile(r"(outside [\[(])([^,\s]+), ([^\])]+)([\])])")
_OF_PAPER = re.compile(r"; the paper uses [^:;]*$")


def as_typed(words: str, typed: Mapping[str, tuple[Measured, float]], file: SystemFile | None = None) -> str:
    """The words of a refusal, with what was typed behind the number of the model that they name, and its range so.

    The numbers of the paper are no advice for the system of a file that is counted in units of its own.
    """
    words = words if file is None or file.units == Units() else _OF_PAPER.sub("", words)
    for named, (given, size) in typed.items():
        if named not in words:
            continue
        words = words.replace(named, f"{named.removesuffix(' is ')} ({given.text.strip()}) is ", 1)
        return words if math.isnan(size) else _RANGE.sub(partial(_in_unit, given.unit, size), words, count=1)
    return words


def _in_unit(unit: str, size: float, found: re.Match) -> str:
    """A range of the model, and the same in a unit of this size."""
    low, high = (f"{float(end) / size:.4g}" for end in found.group(2, 3))
    return f"{found[0]} ({low} to {high} {unit})"


def _resolved(value: object, name: str, options: argparse.Namespace) -> object:
    if isinstance(value, tuple):  # a range or a list
        return tuple(_resolved(each, name, options) for each in value)
    if not isinstance(value, Measured):
        return value
    named, quantity = option({"low": "from", "high": "to"}.get(name, name)), value.quantity
    if quantity == _OF_FIELD:
        quantity = _quantity_of(getattr(options, _ENDS[name]))
    if not quantity:
        raise ValueError(f"{named} {value.text!r}: this number is given without a unit")
    file = getattr(options, "file", None)
    if file is None or not file.has_units:
        raise ValueError(
            f"{named} {value.text!r}: a unit has no meaning without a system in physical units: give --system FILE "
            "with [physical] or [units], or the number without a unit"
        )
    return _of_model(named, value, quantity, file, options)


def _of_model(named: str, value: Measured, quantity: str, file, options: argparse.Namespace) -> float:
    scale, power = replace(file.units, system="si"), 0.0
    if quantity.startswith("contact_"):
        scale = replace(scale, **_contact_law(named, value, options))
        power = -scale.quantity(quantity).length
    of_step = quantity == STEPS
    quantity = "time" if of_step else quantity
    one = scale.factor(quantity)
    units = sizes(quantity, one, power)
    if value.unit not in units:
        of_law = f" of the contact law {scale.law} has no physical unit {value.unit}" if power else ""
        raise ValueError(f"{named} {value.text!r}{of_law}: give it in {list_units(units)}, or without a unit")
    if not of_step:
        return scaled(value.number, units[value.unit])
    eta = file.usual_eta if options.eta is None else options.eta
    if eta is None or not eta > 0 or not value.number > 0:
        raise ValueError(f"{named} {value.text!r}: a time step is above 0 and needs --eta or frequency_Hz: give both")
    return steps_of_time(2 * math.pi / eta * one, value.number * seconds_of(value.unit))


def _contact_law(named: str, value: Measured, options: argparse.Namespace) -> dict[str, object]:
    """The law, and its exponent, that says what units K and D have; raises ValueError where that is every law."""
    given = options
    if getattr(options, "code", None) is not None:
        from vibroscope.app.codes.catalogue import codes  # with the engine, which numbers do without

        given = codes().get(options.code)  # an unknown one is refused where it is used
    own = {name: getattr(given, name, None) for name in ("law", "exponent")}
    if own["law"] == "all":
        raise ValueError(f"{named} {value.text!r}: K and D have other units in each law: give it without a unit")
    return {name: number for name, number in own.items() if number}
