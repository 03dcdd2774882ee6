"""The panel System: which fields describe the system, without dimension or in physical units, and how each is shown."""

from __future__ import annotations

from vibroscope.app.explorer import parameters
from vibroscope.app.explorer.field_units import plain_unit, shown_field
from vibroscope.app.explorer.parameters import (
    EXCITATION_FIELDS,
    SECOND_STOP_FIELDS,
    START_FIELDS,
    bounds_of,
    range_text,
)
from vibroscope.app.explorer.physical_fields import (
    FORMS,
    PHYSICAL_FIELDS,
    is_shown,
    physical_bounds,
    physical_field,
    physical_numbers,
)
from vibroscope.app.explorer.state import Setting
from vibroscope.app.runtime.number_text import print_number
from vibroscope.engine import written
from vibroscope.engine.excitation import HELD
from vibroscope.engine.physical import EITHER

# Titles and fields of the groups; of the fields those are shown that apply to the system and to the units.
_BODY = ("mass{}_kg", "stiffness{}_N_per_m", "frequency{}_Hz", "damping{}_ratio", "damping{}_Ns_per_m")
_BODY_1, _BODY_2 = (tuple(name.format(body) for name in _BODY) for body in (1, 2))
_BASE = ("base_amplitude_mm", "base_velocity_mm_per_s", "base_acceleration_m_per_s2", "base_acceleration_g", "base")
_FORCES = ("force1_N", "force1", "force2_N", "force2", "constant1_N", "constant1", "constant2_N", "constant2")
_PHASES = ("base_phase_rad", "base_phase", "force1_phase_rad", "force1_phase", "force2_phase_rad", "force2_phase")
GROUPS = {
    "Body 1": (*_BODY_1, "spring1", "d1"),
    "Body 2": (*_BODY_2, "mass_ratio", "kappa", "d2", "kappa3"),
    "Contact": ("clearance_mm", "clearance", "restitution", "joint_damping_ratio", "d3"),
    "Second stop": ("clearance2_mm", *SECOND_STOP_FIELDS),
    "What drives it": (*_BASE, *_FORCES),
    "Phases": _PHASES,
    "What numbers are multiples of": ("length_mm", "m1", "omega1", "amplitude"),
}
FIELDS = tuple(name for names in GROUPS.values() for name in names)
_ALWAYS = ("restitution", *SECOND_STOP_FIELDS[1:])  # in units, too: they have none
_DIGITS = 6  # of a number in physical units: as many as its field has room for
_OF_BOTH = "follows from both dampers; choose “as measured” under Solver to type it"
_OF_STEP = "follows from the time step; choose “K as typed” under Solver to type it"
_OF_RESTITUTION = "follows from the restitution; choose “D as typed” under Solver to type it"


def group_spec() -> list[dict]:
    """The groups for the browser; ``forms`` are the forms that a number may have, and what chooses each."""
    return [
        {
            "title": title,
            "numbers": [{"name": name, **_words(name), "forms": _forms_of(name)} for name in names],
        }
        for title, names in GROUPS.items()
    ]


def _forms_of(name: str) -> list[dict]:
    if name == "base":
        return [{"name": held, "set": {"held": held}} for held in HELD]
    group = next((forms for forms in EITHER if name in forms), ())
    return [{"name": each, "set": FORMS[each]} for each in group]


def _words(name: str) -> dict[str, str]:
    if name in PHYSICAL_FIELDS:
        return {"label": physical_field(name).label, "hint": physical_field(name).hint}
    return {"label": parameters.FIELDS[name].label, "hint": parameters.FIELDS[name].hint}


def applies(name: str, setting: Setting) -> bool:
    """Whether a number without dimension describes the system of the setting where no units are shown."""
    if name in SECOND_STOP_FIELDS and setting.stops == "one":
        return False
    if name in _ALWAYS:
        return True
    if setting.scale is not None:
        return False
    return name not in parameters.FIELDS or setting.bodies in parameters.FIELDS[name].bodies


def system_fields(setting: Setting) -> dict[str, dict]:
    """How each field that applies is shown."""
    plain = {name: plain_description(name, setting) for name in FIELDS if _is_plain(name) and applies(name, setting)}
    if setting.scale is None:
        return plain
    numbers = (name for name in physical_numbers(setting) if is_shown(name, setting))
    return plain | {name: _physical_description(name, setting) for name in numbers}


def system_numbers(setting: Setting) -> dict[str, tuple[str, str]]:
    """The number as it is shown, and the text that sets it again, for each field that applies."""
    found = {}
    for name in FIELDS:
        if _is_plain(name) and applies(name, setting):
            found[name] = plain_number(name, setting), print_number(getattr(setting, name))
    if setting.scale is not None:
        numbers = {name: value for name, value in physical_numbers(setting).items() if is_shown(name, setting)}
        for name, value in numbers.items():
            field = physical_field(name, setting.units)
            found[name] = written(field.factor * value, _DIGITS), print_number(value)
    return found


def plain_description(name: str, setting: Setting) -> dict:
    """How one of `parameters.FIELDS` is shown; ``locked``: why it cannot be changed, empty if it can."""
    field = shown_field(name, setting)
    return _description(
        field,
        range_text(bounds_of(name), field.factor),
        why_locked(name, setting),
    )


def _physical_description(name: str, setting: Setting) -> dict:
    field = physical_field(name, setting.units)
    group = next((forms for forms in EITHER if name in forms), ())
    forms = {each: physical_field(each, setting.units).unit or "ratio" for each in group}
    allowed = range_text(physical_bounds(name), field.factor)
    return _description(field, allowed, why_locked(name, setting)) | {"forms": forms}


def _description(field, allowed: str, locked: str) -> dict:
    others = [unit for unit in field.typed if unit and unit != plain_unit(field.unit)]
    also = f"; {', '.join(others)} may be typed" if others else ""
    return {
        "label": field.label,
        "hint": field.hint,
        "name": field.name,
        "unit": field.unit,
        "factor": field.factor,
        "range": allowed,
        "about": locked or f"{allowed}{field.unit and f' {field.unit}'}{also}",
        "locked": locked,
    }


def plain_number(name: str, setting: Setting) -> str:
    """A parameter as its field shows it."""
    if why_locked(name, setting) == _OF_BOTH:
        return written(setting.system.derived_joint_damping)
    if name == "D" and why_locked(name, setting):
        return written(shown_field(name, setting).factor * setting.damping[0])
    value = setting.initial[START_FIELDS.index(name)] if name in START_FIELDS else getattr(setting, name)
    return shown_field(name, setting).number(value)


def why_locked(name: str, setting: Setting) -> str:
    """Why a number that is shown cannot be changed, since it follows from others; empty if it can."""
    if name in ("d3", "joint_damping_ratio") and setting.joint_damping == "derived":
        return _OF_BOTH
    if name == "K" and setting.follows_step:
        return _OF_STEP
    return _OF_RESTITUTION if name == "D" and setting.follows_restitution else ""


def _is_plain(name: str) -> bool:
    return name not in PHYSICAL_FIELDS


def system_title(setting: Setting) -> str:
    """The title of the folded panel: the system in short."""
    kind = {"pendulums": "pendulums", "two": "two bodies", "wall": "a body and a wall"}[setting.bodies]
    papers = all(getattr(setting, n) == getattr(Setting(), n) for n in _PAPERS)
    return "the paper’s pendulums" if papers else kind


_PAPERS = ("bodies", "kappa", "d1", "d2", "kappa3", "d3", "restitution", "clearance", "stops", *EXCITATION_FIELDS)
