"""Statements of the engine in the units and the words of the page. No panel import.

Results are cached and shipped as statements. The page prints them where it shows them, so that a change of units needs
no further run. Symbols and choices have the names of the page's controls.
"""

from __future__ import annotations

from collections.abc import Mapping

from vibroscope.app.explorer.field_units import shown_field
from vibroscope.app.explorer.parameters import FIELDS
from vibroscope.app.explorer.state import Setting
from vibroscope.engine import Statement, Units, print_statement
from vibroscope.engine.facts import Choice, Symbol

_SYMBOLS = {"eta": "η", "omega1": "ω₁", "tau": "τ"}  # of those that the engine writes for a terminal
_CUTTING = {"yes": "cutting the step where contact changes", "no": "steps of one length"}


def shown_text(text: str | Statement, scale: Units | None) -> str:
    """A statement in the units of the page, with symbols and choices as the page writes them."""
    return print_statement(text, scale, _name)


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
