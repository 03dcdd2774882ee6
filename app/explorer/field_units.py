"""The numbers of the setting as people see and type them: without dimension, or in the units that are chosen.

The setting itself is always in the numbers of the model. With units, η is shown as the frequency f = ηω₁/(2π), K and D
as spring K m₁ω₁² and damper 2D m₁ω₁, and ε as a speed. ω₁, m₁ and A define the units, and have one of their own always.

Statements of the engine in the units and the words of the page. No panel import.

Results are cached and shipped as statements. The page prints them where it shows them, so that a change of units needs
no further run. Symbols and choices have the names of the page's controls.
"""

import math
from collections.abc import Mapping
from dataclasses import replace
from typing import NamedTuple, TypeVar

from vibroscope.app.explorer.parameters import FIELDS, Field
from vibroscope.app.explorer.state import Setting
from vibroscope.app.runtime.number_text import TYPED_UNITS, plain_unit, print_number, sizes
from vibroscope.engine import Statement, Units, print_statement, written
from vibroscope.engine.facts import Choice, Symbol
from vibroscope.engine.physical import held_text

# What a number without dimension is a multiple of: k₁ = m₁ω₁² is the spring of body 1, A the amplitude of the base.
_NATURAL = {
    "displacement": "base amplitude",
    "velocity": "Aω₁",
    "acceleration": "Aω₁²",
    "contact_stiffness": "k₁",
    "contact_damping": "2m₁ω₁",
    "force": "k₁A",
    "impulse": "m₁Aω₁",
}
Content = TypeVar("Content")
_NOT_DRIVEN = "frequency that counts time: nothing drives the bodies"
_DIGITS = 6  # of a number that was converted: as many as a field has room for


class ShownField(NamedTuple):
    """How a number of the setting is shown.

    Attributes
    ----------
    label, hint, unit : str
        Symbol, name and unit beside the field.
    factor : float
        The number shown is this times the one of the setting.
    typed : dict of str to float
        What one of each unit that may be typed is worth in the setting, as `plain_unit` writes it; "" for none.
    natural : str
        What a number without dimension is a multiple of; "" for a ratio.
    """

    label: str
    hint: str
    unit: str
    factor: float
    typed: dict[str, float]
    natural: str = ""

    @property
    def name(self) -> str:
        """The words beside the symbol: name and unit, as in "penalty stiffness, N/m"."""
        unit = self.unit or self.natural
        return f"{self.hint}, {unit}" if unit else self.hint

    def number(self, value: float) -> str:
        """A number of the setting as a text in the field."""
        return print_number(value) if self.factor == 1 else print_number(float(f"{self.factor * value:.{_DIGITS}g}"))

    @property
    def column(self) -> str:
        """The name of a column of such numbers in a file."""
        return f"{self.label} [{self.unit}]" if self.unit else self.label

    def measure(self, value: float) -> str:
        """Number and unit, as in "2500000 N/m"."""
        number = self.number(value) if self.factor == 1 else written(self.factor * value)
        return f"{number} {self.unit}".rstrip()

    def words(self, value: float) -> str:
        """Symbol, number and unit, as in "K = 2500000 N/m"."""
        return f"{self.label} = {self.measure(value)}"


def shown_field(name: str, setting: Setting) -> ShownField:
    """How the number ``name`` of a setting is shown."""
    field = FIELDS[name]
    if field.defines:
        return _defining_field(field, setting)
    label, hint = field.label, field.hint
    share = {"%": 0.01} if field.also == "%" else {}
    if setting.scale is None:
        natural = unit_of(quantity_of_field(name, setting), setting) if field.quantity else ""
        if natural == "base amplitude" and not setting.base:
            natural = "A"  # of another length
        hint = hint if name != "eta" or setting.is_driven else _NOT_DRIVEN
        return ShownField(label, hint, "", 1.0, {"": 1.0, **share}, natural)
    if not field.quantity:
        ratio = {"Hz": 2 * math.pi / setting.omega1} if field.also == "Hz" else {}
        return ShownField(label, hint, "", 1.0, {"": 1.0, **share, **ratio})
    quantity = quantity_of_field(name, setting)
    label, hint = field.in_units or (label, hint)
    hint = hint if name != "eta" or setting.is_driven else _NOT_DRIVEN
    factor = setting.scale.factor(quantity)
    one = replace(setting.scale, system="si").factor(quantity)
    typed = {"": 1 / factor, **sizes(quantity, one, length_power(setting.scale, quantity))}
    return ShownField(label, hint, setting.scale.unit(quantity), factor, typed)


def beside_field(setting: Setting, label: str, hint: str, quantity: str, natural: str = "") -> ShownField:
    """How a number beside those of the setting is shown; ``natural``: what one of it is without units, if known."""
    if setting.scale is None:
        return ShownField(label, hint, "", 1.0, {"": 1.0}, natural or unit_of(quantity, setting))
    factor, one = setting.scale.factor(quantity), setting.own_units.factor(quantity)
    return ShownField(label, hint, setting.scale.unit(quantity), factor, {"": 1 / factor, **sizes(quantity, one)})


def quantity_of_field(name: str, setting: Setting) -> str:
    """The physical quantity of a number of the setting that has one; of the base that which is held."""
    return setting.held if name == "base" else FIELDS[name].quantity


def held_in_words(setting: Setting) -> str:
    """What of the base keeps its amplitude over the frequency, as "base acceleration 4 m/s²"; empty if it rests."""
    forms = ("base_acceleration_g",) if setting.acceleration_form == "g" else ()
    return held_text(setting.system.excitation, setting.scale, forms)


def _defining_field(field: Field, setting: Setting) -> ShownField:
    """ω₁ in 1/s; m₁ and A in the chosen units, and in kg and mm where none are."""
    quantity = field.defines
    kept = 1e-3 if quantity == "displacement" else 1.0  # the unit of the setting, in SI units
    usual = "mm-t-s" if quantity == "displacement" else "si"
    units = Units(system=usual if setting.scale is None else setting.scale.system)
    unit = units.unit(quantity)
    size = sizes(quantity, kept)
    return ShownField(field.label, field.hint, unit, 1 / size[unit], {"": size[unit], **size})


def typed_units(quantity: str, unit: str) -> dict[str, float]:
    """The factor to ``unit`` of each unit that may be typed for a quantity; "" for a number without one."""
    one = TYPED_UNITS[quantity][plain_unit(unit)]
    return {"": 1.0, **sizes(quantity, one)}


def unit_of(quantity: str, setting: Setting) -> str:
    """The unit in which numbers of a quantity are shown: what they are multiples of where they have no dimension."""
    if setting.scale is not None:
        return setting.scale.unit(quantity)
    natural = _NATURAL.get(quantity, "")
    if natural == "base amplitude" and setting.held != "displacement":
        natural = "A"
    power = length_power(setting.own_units, quantity)
    return f"{natural}/A^{power:.6g}" if power else natural


def length_power(units: Units, quantity: str) -> float:
    """The power of length that K or D of the contact law of these units is divided by; 0 of a linear law."""
    return -units.quantity(quantity).length if quantity.startswith("contact_") else 0.0


_SYMBOLS = {"eta": "η", "omega1": "ω₁", "tau": "τ"}  # of those that the engine writes for a terminal
_CUTTING = {"yes": "cutting the step where contact changes", "no": "steps of one length"}


def shown_text(text: str | Statement, scale: Units | None) -> str:
    """A statement in the units of the page, with symbols and choices as the page writes them."""
    return print_statement(text, scale, _name)


def shown_content(content: Content, scale: Units | None) -> Content:
    """Content of the page with its statements as `shown_text` prints them, also within lists, tuples, dictionaries."""
    if isinstance(content, Statement):
        return shown_text(content, scale)
    if isinstance(content, dict):
        return {name: shown_content(part, scale) for name, part in content.items()}
    if isinstance(content, list | tuple):
        parts = [shown_content(part, scale) for part in content]
        return type(content)(*parts) if hasattr(content, "_fields") else type(content)(parts)
    return content


def _name(part: Symbol | Choice) -> str:
    """A symbol of the page; a choice by the names of its control, as “limited damper”."""
    if isinstance(part, Symbol):
        return _SYMBOLS.get(part.name, part.name)
    if (part.field, part.values) == ("status", ("located",)):
        return _CUTTING["yes"]
    names = FIELDS[part.field].choices
    quoted = " or ".join(f"“{names[value]}”" for value in part.values)
    return f"{quoted} for a step without a solution" if part.field == "without_solution" else quoted


def words_of_change(change: Mapping[str, str], setting: Setting) -> str:
    """Texts for the controls as a person reads them, as in "K = 2500, D = 8"; empty for none."""
    return ", ".join(_words_of_field(name, text, setting) for name, text in change.items())


def _words_of_field(name: str, text: str, setting: Setting) -> str:
    if name == "located":
        return _CUTTING[text]
    if choices := FIELDS[name].choices:
        return f"{FIELDS[name].label.lower()}: {choices[text]}"
    return shown_field(name, setting).words(float(text))
