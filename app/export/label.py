"""The label in the file of a figure: the figure, the setting, the program, the page. No panel import."""

from __future__ import annotations

from vibroscope.app.explorer.field_units import shown_field
from vibroscope.app.explorer.parameters import EXCITATION_FIELDS, FIELDS, SECOND_STOP_FIELDS, START_FIELDS
from vibroscope.app.explorer.physical_fields import is_shown, physical_field, physical_numbers
from vibroscope.app.explorer.state import Setting, integrator_numbers, law_numbers
from vibroscope.app.export.formats import Figure, program
from vibroscope.engine import written

_ALWAYS = ("damping1_ratio", "damping2_ratio", "clearance_mm")  # said where they are zero, too


def figure_label(tab: str, figure: Figure, setting: Setting | None, address: str) -> dict[str, str]:
    """The label of a figure's file: its ``title`` and ``description``, with the address of the page."""
    lines = [figure.caption]
    if setting is not None:
        lines.append("Setting: " + ", ".join(f"{name} = {text}" for name, text, _ in setting_rows(setting)) + ".")
    lines += [f"Made by {program()}.", f"The page: {address}"]
    return {"title": f"Vibroscope, {tab}: {figure.title}", "description": "\n".join(lines)}


Rows = list[tuple[str, str, str]]  # symbol or name, value in the units that are shown, and meaning


def setting_rows(setting: Setting) -> Rows:
    """All that a setting is: the system, its contact, and how it is solved; nothing that it does not have."""
    return [*system_rows(setting), *contact_rows(setting)]


def system_rows(setting: Setting) -> Rows:
    """The system as it was entered, without forces, phases and constants that are zero."""
    kind = [_choice("bodies", setting)]
    if setting.scale is None:
        names = (*setting.described_by, *(name for name in EXCITATION_FIELDS if name != "held"))
        names = [name for name in names if getattr(setting, name) or name not in EXCITATION_FIELDS]
        rows = [_row(name, setting) for name in names if name != "d3" or setting.joint_damping == "table"]
    else:
        numbers = {name: value for name, value in physical_numbers(setting).items() if is_shown(name, setting)}
        rows = [_physical_row(name, value, setting) for name, value in numbers.items() if value or name in _ALWAYS]
        rows.append(_row("restitution", setting))
        rows += [_row(name, setting) for name in SECOND_STOP_FIELDS[1:] if setting.stops == "two"]
    held = (
        [("held", f"{setting.held} of the base", "what keeps its amplitude over the frequency")] if setting.base else []
    )
    return [*kind, *rows, *held, _row("eta", setting)]


def contact_rows(setting: Setting) -> Rows:
    """The contact and the solvers: K, D, the step, law, integrator and their own numbers; the reference's ε and d₃."""
    names = ["K", "D", "steps", "law", *law_numbers(setting), "integrator", *integrator_numbers(setting)]
    names += ["located"] if setting.located == "yes" else ["status"]
    names += ["without_solution"] if setting.status == "end" else []
    names += ["stiffness", "step_scale"] if setting.follows_step else []
    names += ["initial_acceleration"] if setting.initial_acceleration != "equation" else []
    names += ["threshold"] + ([] if setting.bodies == "wall" else ["joint_damping"])
    if not setting.from_rest:
        names += START_FIELDS[:2] if setting.bodies == "wall" else START_FIELDS
    return [_row(name, setting) for name in names]


def _physical_row(name: str, value: float, setting: Setting) -> tuple[str, str, str]:
    field = physical_field(name, setting.units)
    return field.label, f"{written(field.factor * value, 6)} {field.unit}".strip(), field.hint


def _choice(name: str, setting: Setting) -> tuple[str, str, str]:
    field = FIELDS[name]
    return field.label, field.choices[getattr(setting, name)], field.hint


def _row(name: str, setting: Setting) -> tuple[str, str, str]:
    if FIELDS[name].choices:
        return _choice(name, setting)
    field = shown_field(name, setting)
    if name == "D" and setting.follows_restitution:
        return field.label, FIELDS["damper"].choices["restitution"], field.hint
    return field.label, field.measure(getattr(setting, name)), field.hint
