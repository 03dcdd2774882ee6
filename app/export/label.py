"""The label in the file of a figure: the figure, the setting, the program, the page. No panel import."""

from __future__ import annotations

import param
from vibroscope.app.explorer.field_units import shown_field
from vibroscope.app.explorer.method_words import DAMPER_NAMES
from vibroscope.app.explorer.parameters import Explorer
from vibroscope.app.explorer.state import Setting
from vibroscope.app.export.formats import Figure, program


def figure_label(tab: str, figure: Figure, setting: Setting | None, address: str) -> dict[str, str]:
    """The label of a figure's file: ``title``, ``description``, and the query of the page as ``address``."""
    lines = [figure.caption]
    if setting is not None:
        lines.append("Setting: " + ", ".join(f"{name} = {text}" for name, text, _ in setting_rows(setting)) + ".")
    lines.append(f"Made by {program()}.")
    return {"title": f"Vibroscope, {tab}: {figure.title}", "description": "\n".join(lines), "address": address}


def setting_rows(setting: Setting) -> list[tuple[str, str, str]]:
    """Symbol or name, value in the units that are shown, and meaning of each parameter."""
    return [_row(name, text, setting) for name, text in setting.texts().items()]


def _row(name: str, text: str, setting: Setting) -> tuple[str, str, str]:
    rule = Explorer.param[name]
    if not isinstance(rule, param.Number):
        return rule.label, text, rule.doc
    field = shown_field(name, setting)
    if name == "D" and setting.follows_restitution:
        return field.label, DAMPER_NAMES["restitution"], field.hint
    return field.label, field.measure(getattr(setting, name)), field.hint
