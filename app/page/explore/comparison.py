"""The comparison: the numbers of the present setting and of the pinned ones in a table, with the errors of each."""

from __future__ import annotations

import math
from collections.abc import Sequence

import param
from vibroscope.app.explorer.explanation import Explanation
from vibroscope.app.explorer.field_units import shown_field
from vibroscope.app.explorer.parameters import DRAWING_FIELDS, FIELDS, MAIN_FIELDS
from vibroscope.app.explorer.state import Setting
from vibroscope.app.page.explore.explainer import known_explanation
from vibroscope.app.page.explore.result import Result
from vibroscope.app.page.shared.component import Component
from vibroscope.app.page.shared.figure import PARTS, name_of_part
from vibroscope.engine import Excitation, percent

_OTHER_FIELDS = [name for name in FIELDS if name not in (*MAIN_FIELDS, *DRAWING_FIELDS)]


class PinComparison(Component):
    """A row for each setting; without a pin there are none."""

    parts = param.Dict(default={}, doc="Heads of the errors: those that a row has, or all until they are known")
    rows = param.List(default=[], doc="See `_row`; the first is the present setting, the others are in their order")

    script = "explore/comparison"
    sheets = ("shared/scroll_cue", "shared/table")

    def __init__(self, **params) -> None:
        super().__init__(visible=False, **params)

    def show(
        self, live: Result, explanation: Explanation | None, pinned: Sequence[tuple[Setting, Result | None]]
    ) -> None:
        """Show the pinned settings below the present one."""
        rows = []
        if pinned:
            settings = [live.setting, *(setting for setting, _ in pinned)]
            other = [name for name in _OTHER_FIELDS if len({getattr(setting, name) for setting in settings}) > 1]
            shown = (setting.drawn_like(live.setting) for setting, _ in pinned)
            rows = [_row(live.setting, live, explanation, other)]
            rows += [
                _row(setting, result, known_explanation(setting), other)
                for setting, (_, result) in zip(shown, pinned, strict=True)
            ]
        if rows != self.rows:
            has = {part for row in rows for part in row["errors"]} or PARTS  # a column has a number at least
            parts = {part: name_of_part(part) for part in PARTS if part in has}
            self.param.update(rows=rows, parts=parts, visible=bool(rows))

    @property
    def table(self) -> dict[str, list]:
        """The columns of the table as numbers; not a number where an error is unknown."""
        names = self.rows[0]["texts"] if self.rows else {}
        columns = {name: [_as_number(row["texts"][name]) for row in self.rows] for name in names}
        if self.rows:  # of the base, whatever is held, the amplitude of its displacement
            drives = (Excitation(base, held=held) for base, held in zip(columns["base"], columns["held"], strict=True))
            columns["base"] = [drive.base_amplitude(eta) for drive, eta in zip(drives, columns["eta"], strict=True)]
        errors = {name: [row["errors"].get(name, math.nan) for row in self.rows] for name in self.parts}
        return columns | {f"error {name}": column for name, column in errors.items()}


def _as_number(text: str) -> float | str:
    try:
        return float(text)
    except ValueError:  # a choice
        return text


def _row(setting: Setting, result: Result | None, explanation: Explanation | None, other: list[str]) -> dict:
    """Make the row of a setting.

    Returns
    -------
    dict
        ``texts``: what sets its parameters. ``numbers``: symbol, name with unit, and text of each slider. ``other``:
        those beside the sliders in which the rows differ. ``motion``: what the penalty model shows. ``explained``:
        whether the following are known. ``errors``: the parts of its difference by name, as far as they have a meaning.
        ``shown``: the same as texts. ``measure``: what they measure. ``headline``: the difference in words.
    """
    texts, explanation = setting.texts(), explanation and explanation.in_units(setting.scale)
    return {
        "texts": {name: texts[name] for name in FIELDS if name not in DRAWING_FIELDS},
        "numbers": [_number(name, setting) for name in MAIN_FIELDS],
        "other": ", ".join(_in_words(name, setting) for name in other),
        "motion": result.description.lines(explanation)["penalty"] if result else "",
        "explained": explanation is not None,
        "errors": explanation.parts if explanation else {},
        "shown": {name: percent(value) for name, value in explanation.parts.items()} if explanation else {},
        "measure": explanation.measure if explanation else "",
        "headline": explanation.headline if explanation else "",
    }


def _number(name: str, setting: Setting) -> list[str]:
    field = shown_field(name, setting)
    return [field.label, field.name, field.number(getattr(setting, name))]


def _in_words(name: str, setting: Setting) -> str:
    field, value = FIELDS[name], getattr(setting, name)
    return f"{field.label}: {value}" if field.choices else shown_field(name, setting).words(value)
