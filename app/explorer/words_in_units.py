"""Sentences of the engine in the units and the words of the page. No panel import.

The engine writes K, D, η and ξ₂ without dimension, and results are cached and shipped so. The page converts them where
it shows them, so that a change of units needs no further run. Choices have the names of the command line there, and get
those of the page's controls.
"""

from __future__ import annotations

import re
from collections.abc import Mapping

from vibroscope.app.explorer.field_units import shown_field, time_text
from vibroscope.app.explorer.method_words import CHOICE_NAMES
from vibroscope.app.explorer.parameters import Explorer
from vibroscope.app.explorer.state import Setting
from vibroscope.engine import Units, written

_NUMBER = r"([0-9]+(?:\.[0-9]+)?(?:e[+-]?[0-9]+)?)"
# Numbers in sentences: the text before the number, the same in a sentence with units, and the quantity.
_RULES = tuple(
    (re.compile(before + _NUMBER), shown, quantity)
    for before, shown, quantity in (
        (r"(?<!\w)K = ", "K = ", "contact_stiffness"),
        (r"(?<!\w)K ≈ ", "K ≈ ", "contact_stiffness"),
        (r"(?<!\w)D ≈ ", "2D ≈ ", "contact_damping"),
        (r"(?<!\w)K up to ", "K up to ", "contact_stiffness"),
        (r"(?<!\w)D = ", "2D = ", "contact_damping"),
        (r"(?<!\w)D than ", "2D than ", "contact_damping"),
        (r"(?<!\w)(?:η|eta) = ", "f = ", "frequency"),
        (r"ξ₁ by ±", "x₁ by ±", "displacement"),
        (r"ξ₂ by ±", "x₂ by ±", "displacement"),
        (r"±(?=[0-9.e+-]+ (?:in ξ[₁₂]|at T/))", "±", "displacement"),
        (r"(?:(?<=last )|(?<=lasts ))τ = ", "", "time"),
        (r"the residual \(", "the residual (", "displacement"),
        (r"own noise \(", "own noise (", "displacement"),
    )
)
_POWER = re.compile(r"(?<![\w.])[0-9]+(?:\.[0-9]+)?e[+-]?[0-9]+")
_RANGE = re.compile(rf"(?<!\w)([ηKD]) = {_NUMBER} to {_NUMBER}")
_RANGES = {"η": ("f", "frequency"), "K": ("K", "contact_stiffness"), "D": ("2D", "contact_damping")}
_CHOICES = re.compile(
    r"(?<![\w-])(integrator|numerical damping of|law|status|without[-_]solution(?: =)?) "
    r"('?[a-z2]+(?:-[a-z2]+)*'?(?: or '[a-z]+')*)"
)
_CUTTING = {"yes": "cutting the step where contact changes", "no": "steps of one length"}
_DIGITS = {"displacement": 3}  # of a blur, which the engine writes with two; of others four


def in_units(text: str, scale: Units | None) -> str:
    """A sentence of the engine in the units of the page, with numbers and choices as the page writes them."""
    text = _CHOICES.sub(_choice, text)
    if scale is None:
        return _POWER.sub(lambda match: written(float(match[0])), text)
    found = list(_RANGE.finditer(text))
    begins, ends = [0, *(m.end() for m in found)], [*(m.start() for m in found), len(text)]
    between = [_single_numbers(text[begin:end], scale) for begin, end in zip(begins, ends, strict=True)]
    ranges = [*(_range(m, scale) for m in found), ""]
    text = "".join(part for pair in zip(between, ranges, strict=True) for part in pair)
    return text.replace(" in ξ₁", " in x₁").replace(" in ξ₂", " in x₂")


def _choice(match: re.Match) -> str:
    """A choice by the names of its control, as in "law “limited damper”"; other words as they are."""
    what, values = match.groups()
    field = "without_solution" if what.startswith("without") else what.replace("numerical damping of", "integrator")
    values = [value.strip("'") for value in values.split(" or ")]
    if (field, values) == ("status", ["located"]):
        return _CUTTING["yes"]
    names = CHOICE_NAMES[field]
    if not set(values) <= set(names) or match.string.startswith(names[values[0]], match.start(2)):
        return match[0]  # no choice, or its name already
    quoted = " or ".join(f"“{names[value]}”" for value in values)
    return f"{quoted} for a step without a solution" if field == "without_solution" else f"{what} {quoted}"


def _single_numbers(text: str, scale: Units) -> str:
    for pattern, shown, quantity in _RULES:
        text = pattern.sub(lambda m, s=shown, q=quantity: f"{s}{_measure(scale, q, float(m[1]))}", text)
    return text


def _measure(scale: Units, quantity: str, value: float) -> str:
    if quantity == "time":
        return time_text(scale.physical(quantity, value))
    return scale.text(quantity, value, _DIGITS.get(quantity, 4))


def _range(match: re.Match, scale: Units) -> str:
    symbol, *ends = match.groups()
    shown, quantity = _RANGES[symbol]
    first, last = (scale.text(quantity, float(end)) for end in ends)
    return f"{shown} = {first.removesuffix(f' {scale.unit(quantity)}')} to {last}"


def plain_symbols(text: str) -> str:
    """Words of the command line with the symbols of the page."""
    for word, symbol in {"eta": "η", "omega1": "ω₁", "tau": "τ"}.items():
        text = re.sub(rf"\b{word}\b", symbol, text)
    return text


def words_of_change(change: Mapping[str, str], setting: Setting) -> str:
    """Texts for the controls as a person reads them, as in "K = 2500, D = 8"; empty for none."""
    return ", ".join(_words_of_field(name, text, setting) for name, text in change.items())


def _words_of_field(name: str, text: str, setting: Setting) -> str:
    rule = Explorer.param[name]
    if name == "located":
        return _CUTTING[text]
    if name in CHOICE_NAMES:
        return f"{rule.label.lower()}: {CHOICE_NAMES[name][text]}"
    return shown_field(name, setting).words(float(text))
