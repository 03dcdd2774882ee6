"""Numbers as people type them: thousands separators, decimal commas and per cent. No panel import.

An address, a file and a slider hold plain numbers, which `app.explorer.reading.read_number` reads. What a person types
passes through here first. A text that can mean two different numbers is refused with both of them, never guessed.
"""

import re
from collections.abc import Mapping

from vibroscope.app.explorer.errors import Refused
from vibroscope.app.explorer.field_units import ShownField, shown_field
from vibroscope.app.explorer.parameters import FIELDS, START_FIELDS, range_text
from vibroscope.app.explorer.physical_fields import PHYSICAL_FIELDS, physical_bounds, physical_field
from vibroscope.app.explorer.state import Setting
from vibroscope.app.runtime.number_text import (
    is_unit,
    list_units,
    parse_typed,
    print_number,
    quote,
    scaled,
    seconds_of,
    steps_of_time,
    two_meanings,
)

_PART = re.compile(r"\s*[1T]\s*/(.*)", re.DOTALL)
_NO_UNITS = {"": 1.0}


def read_typed_number(
    name: str,
    text: object,
    bounds: tuple[float, float],
    *,
    whole: bool = False,
    units: Mapping[str, float] = _NO_UNITS,
    shown: str = "",
) -> str:
    """The typed number as a text for `app.explorer.reading.read_number`.

    Parameters
    ----------
    name : str
        Of the number, for a refusal.
    text : object
        As typed.
    bounds : tuple
        Smallest and largest value; they decide what a comma means, if they can.
    whole : bool
        Whether a whole number is expected.
    units : mapping of str to float
        What one of each unit that may be typed is worth; "" for a number without one.
    shown : str
        The unit in which the number is shown.

    Raises
    ------
    Refused
        If it is no number within ``bounds``, or can mean two.
    """
    typed, (low, high) = parse_typed(text, whole=whole), bounds
    size = units.get(typed.unit)
    fitting = [
        (number, value)
        for number in typed.numbers
        if size is not None and low <= (value := scaled(number, size)) <= high and (not whole or value == int(value))
    ]
    if len(fitting) == 1:
        return print_number(fitting[0][1])
    if fitting:
        raise Refused(name, two_meanings(text, tuple(number for number, _ in fitting), typed.unit))
    kind = "a whole number" if whole else "a number"
    others = f"{', typed in' if shown else ' or in'} {list_units(units)}" if len(units) > 1 else ""
    unknown = others if typed.numbers and size is None else ""
    span = range_text(bounds, 1 / units[""])
    raise Refused(name, f"{name} must be {kind} from {span}{shown and f' {shown}'}{unknown}, not {quote(text)}.")


def plain_texts(texts: Mapping[str, object], setting: Setting) -> dict[str, object]:
    """``texts`` with a plain number in place of each ``{"typed": text}``; raises `Refused`.

    Parameters
    ----------
    texts : mapping of str to object
        By the name of the parameter.
    setting : Setting
        The one that the person who typed saw.
    """
    typed = {
        name: text["typed"] for name, text in texts.items() if isinstance(text, Mapping) and text.keys() == {"typed"}
    }
    plain = {name: _read_field(name, typed[name], setting) if name in typed else text for name, text in texts.items()}
    return plain | _own_start(setting, plain) if typed.keys() & set(START_FIELDS) else plain


def _own_start(setting: Setting, plain: Mapping[str, object]) -> dict[str, object]:
    """The own start that follows if one of its numbers is typed; the other numbers are those of rest."""
    rest = dict(zip(START_FIELDS, map(print_number, setting.initial), strict=True)) if setting.from_rest else {}
    return {"zero_start": "zero"} | {name: text for name, text in rest.items() if name not in plain}


def _read_field(name: str, text: object, setting: Setting) -> object:
    if name in PHYSICAL_FIELDS:
        return read_shown_number(name, text, physical_field(name, setting.units), physical_bounds(name))
    field = FIELDS.get(name)
    if field is None or field.choices:
        return text
    if name == "steps":
        if steps := _steps_of_time(text, setting):
            return steps
        text = _part_of_period(text)
    with_unit = setting.scale is None and (field.quantity or field.also == "Hz")
    return read_shown_number(name, text, shown_field(name, setting), field.bounds, field.whole, with_unit)


def read_shown_number(
    name: str, text: object, field: ShownField, bounds: tuple[float, float], whole: bool = False, may: bool = False
) -> str:
    """The typed number of a field, as `read_typed_number`; ``may``: whether it takes a unit once units are set."""
    on_unit = " A unit can be typed once Units is SI or mm-t-s." if may else ""
    options = {"units": field.typed, "shown": field.unit, "whole": whole}
    try:
        return read_typed_number(field.label, text, bounds, **options)
    except Refused as error:
        raise Refused(name, f"{error}{on_unit if is_unit(parse_typed(text).unit) else ''}") from None


def _part_of_period(text: object) -> object:
    """The number of steps in a step as a part of the period, as "T/2000" or "1/2000"; any other text as it is."""
    part = _PART.fullmatch(text) if isinstance(text, str) else None
    return part[1] if part else text


def _steps_of_time(text: object, setting: Setting) -> str | None:
    """The fewest steps per period of at most the typed time, as "10 µs"; None if that is no time."""
    typed = parse_typed(text)
    seconds = seconds_of(typed.unit)
    if setting.scale is None or seconds is None or len(typed.numbers) != 1 or typed.numbers[0] <= 0:
        return None
    return str(steps_of_time(setting.period, typed.numbers[0] * seconds))
