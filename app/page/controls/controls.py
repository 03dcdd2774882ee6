"""Sliders, typed values, switches and scene buttons: one component that runs in the browser.

It has native inputs in a `JSComponent`, for three measured reasons: its messages do not wait the 50 ms for which Panel
delays a widget's event, it needs no ``unsafe-eval``, and it can hold back moves until the browser has painted the last
one. Its messages hold text only, and `app.explorer.reading` decides what is accepted.
"""

import math

import param
from vibroscope.app.explorer.drawing import drawing, drawing_in_words
from vibroscope.app.explorer.field_units import plain_unit, shown_field
from vibroscope.app.explorer.parameters import (
    EXCITATION_FIELDS,
    FIELDS,
    MAIN_FIELDS,
    SECOND_STOP_FIELDS,
    START_FIELDS,
    range_text,
)
from vibroscope.app.explorer.physical_fields import (
    CONTACT_OF_SYSTEM,
    FORMS,
    PHYSICAL_FIELDS,
    is_shown,
    physical_bounds,
    physical_field,
    physical_numbers,
)
from vibroscope.app.explorer.presets import OPENING, buttons, preset_of, shelf
from vibroscope.app.explorer.state import LAWS_OF_RATIO, Setting, integrator_numbers, law_numbers, slider_range
from vibroscope.app.page.shared.component import Component
from vibroscope.app.runtime.number_text import print_number
from vibroscope.engine import LAWS_BY_RESTITUTION, written
from vibroscope.engine.excitation import HELD
from vibroscope.engine.law_table import LAW_NUMBERS, LAWS
from vibroscope.engine.physical import EITHER
from vibroscope.engine.units import time_text

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
_GROUPED = tuple(name for names in GROUPS.values() for name in names)
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
    return {"label": FIELDS[name].label, "hint": FIELDS[name].hint}


def applies(name: str, setting: Setting) -> bool:
    """Whether a number without dimension describes the system of the setting where no units are shown."""
    if name in SECOND_STOP_FIELDS and setting.stops == "one":
        return False
    if name in _ALWAYS:
        return True
    if setting.scale is not None:
        return False
    return name not in FIELDS or setting.bodies in FIELDS[name].bodies


def system_fields(setting: Setting) -> dict[str, dict]:
    """How each field that applies is shown."""
    plain = {name: plain_description(name, setting) for name in _GROUPED if _is_plain(name) and applies(name, setting)}
    if setting.scale is None:
        return plain
    numbers = (name for name in physical_numbers(setting) if is_shown(name, setting))
    return plain | {name: _physical_description(name, setting) for name in numbers}


def system_numbers(setting: Setting) -> dict[str, tuple[str, str]]:
    """The number as it is shown, and the text that sets it again, for each field that applies."""
    found = {}
    for name in _GROUPED:
        if _is_plain(name) and applies(name, setting):
            found[name] = plain_number(name, setting), print_number(getattr(setting, name))
    if setting.scale is not None:
        numbers = {name: value for name, value in physical_numbers(setting).items() if is_shown(name, setting)}
        for name, value in numbers.items():
            field = physical_field(name, setting.units)
            found[name] = written(field.factor * value, _DIGITS), print_number(value)
    return found


def plain_description(name: str, setting: Setting) -> dict:
    """How one of `FIELDS` is shown; ``locked``: why it cannot be changed, empty if it can."""
    field = shown_field(name, setting)
    return _description(
        field,
        range_text(FIELDS[name].bounds, field.factor),
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


_STEP = 0.01  # of one arrow key: in η, and in decades of the other sliders
_SOLVER_SWITCHES = ("stiffness", "damper", "joint_damping", "located", "status", "without_solution")
_SOLVER_SWITCHES += ("initial_acceleration",)
_INTEGRATOR_NUMBERS = ("beta", "gamma", "alpha", "rho")  # as far as the integrator has them
_LAW_NUMBERS = (*LAW_NUMBERS, "step_scale", "threshold")  # as far as the law has them, or K follows the step
_VIEW_SWITCHES = ("frame", "coordinate")


class Controls(Component):
    """The panel of inputs."""

    spec = param.Dict(doc="Limits, labels and scenes; fixed")
    starts = param.Boolean(default=True, doc="Whether the start of the runs counts in the open tab, and is shown")
    motions = param.Boolean(default=True, doc="Whether the open tab draws motions, and the switches for that are shown")
    fields = param.Dict(default={}, doc="How the number of each field is shown: another one in other units")
    spans = param.Dict(default={}, doc="First and last value of each slider")
    system = param.Dict(default={}, doc="The system to scale, see `app.explorer.drawing`; its title, and it in words")
    shown = param.Dict(default={}, doc="The accepted setting, see `show_setting`")

    script = "controls/controls"
    sheets = ("shared/scroll_cue", "shared/bodies")

    def __init__(self, **params) -> None:
        super().__init__(spec=_spec(), css_classes=["controls"], sizing_mode="stretch_both", **params)

    def show_setting(self, setting: Setting, **answer) -> None:
        """Show the accepted setting: its texts, the notes below the sliders, the pressed scene buttons.

        Parameters
        ----------
        setting : Setting
        **answer
            ``move``: number of the move that this answers. ``update``: number of the update to be confirmed once it is
            painted. ``address``: the new query string of the page; empty if it stays. ``refused``: name and text of a
            refused value. ``undo``, ``redo``: whether there is something to undo or redo. ``pinned``: whether this
            setting is pinned.
        """
        fields = {name: plain_description(name, setting) for name in _other_fields(setting)} | system_fields(setting)
        spans = {name: slider_range(name, setting.system) for name in MAIN_FIELDS}
        numbers = system_numbers(setting)
        system = {
            "drawing": drawing(setting),
            "title": system_title(setting),
            "words": drawing_in_words(setting),
            "length": _length(setting),
        }
        # a move of a slider changes none of them, another system hardly ever how its numbers are shown
        self.param.update(fields=fields, spans=spans, system=system)
        self.shown = {
            "texts": setting.texts()
            | {"D": print_number(setting.damping[0])}  # where its slider stands
            | {name: text for name, (_, text) in numbers.items()},
            "numbers": {name: plain_number(name, setting) for name in _other_fields(setting)}
            | {name: number for name, (number, _) in numbers.items()},
            "notes": _notes(setting),
            "offers": _offers(setting),
            "scene": preset.key if (preset := preset_of(setting)) else "",
            **answer,
        }


def _other_fields(setting: Setting) -> tuple[str, ...]:
    """The fields beside those of the system; a wall has no start, and an integrator only its own numbers."""
    return (
        *MAIN_FIELDS,
        "threshold",
        *integrator_numbers(setting),
        *law_numbers(setting),
        *(("step_scale",) if setting.follows_step else ()),
        *(START_FIELDS[:2] if setting.bodies == "wall" else START_FIELDS),
    )


def _length(setting: Setting) -> dict:
    """Value and unit of one length of the drawing, as the fields of the panel have it."""
    return {"unit": "", "factor": 1.0} if setting.scale is None else {"unit": "mm", "factor": setting.amplitude}


def _notes(setting: Setting) -> dict[str, str]:
    """The notes below the sliders: Δτ, and with units the numbers of the model."""
    typed = [name for name in MAIN_FIELDS if not why_locked(name, setting)]
    beyond = {name: words for name in typed if (words := _beyond_slider(name, setting))}
    notes = _numbers_below(setting)
    if setting.follows_restitution:
        notes["D"] = _of_restitution(setting)
    if setting.finds_damping:
        notes["D"] = _with("; ", notes.get("D"), f"from e = {written(setting.restitution)} until it is typed")
    if setting.follows_system:
        rule = "a contact lasts 1 % of the shorter natural period, until K is typed"
        notes["K"] = _with("; ", notes.get("K"), rule)
    if setting.follows_step:
        rule = f"{written(setting.step_scale)} m/Δτ²: half the step gives four times K"
        notes["K"] = _with("; ", notes.get("K"), rule)
    return notes | {name: _with("; ", notes.get(name), words) for name, words in beyond.items()}


def _with(joint: str, *texts: str | None) -> str:
    return joint.join(filter(None, texts))


def _offers(setting: Setting) -> dict[str, dict]:
    """Buttons beside K and D of a system of one's own, for who does not know them: what sets them by the system."""
    offers = {}
    if setting.bodies == "pendulums":
        return offers
    if setting.stiffness == "typed" and LAWS[setting.law].exponent == 1.0:
        offers["K"] = {"text": "I do not know K", "set": {"stiffness": CONTACT_OF_SYSTEM["stiffness"]}}
    if setting.damper == "typed" and setting.law in (*LAWS_OF_RATIO, *LAWS_BY_RESTITUTION):
        offers["D"] = {"text": "I do not know D", "set": {"damper": CONTACT_OF_SYSTEM["damper"]}}
    return offers


def _of_restitution(setting: Setting) -> str:
    """The origin of the locked D, and the closing speed for which it holds."""
    origin = f"from e = {written(setting.restitution)} by the formula of its law"
    if not setting.damping[1]:
        return origin
    speed = "1" if setting.scale is None else setting.scale.text("velocity", 1.0)
    return f"{origin}, at a closing speed of {speed}; half of it at twice the speed"


def _beyond_slider(name: str, setting: Setting) -> str:
    """Whether a typed number lies below or above its slider; empty within, and for 0 on a logarithmic slider."""
    (low, high), value, field = slider_range(name, setting.system), getattr(setting, name), shown_field(name, setting)
    if value == 0 or low <= value <= high:
        return ""
    if value > high:
        return f"above the slider, which ends at {field.measure(high)}"
    softer = "softer than the stiffer spring, " if name == "K" and value < setting.system.stiffer_spring else ""
    return f"{softer}below the slider, which begins at {field.measure(low)}"


def _numbers_below(setting: Setting) -> dict[str, str]:
    step = f"time step Δτ = T/{setting.steps} = {written(2 * math.pi / setting.eta / setting.steps)}"
    if setting.scale is None:
        return {"steps": step}
    numbers = setting.scale.settings(setting.eta, setting.penalty)
    return {
        "eta": f"ratio η = {written(setting.eta, 5)}, period T = {time_text(numbers['period'])}",
        "K": f"K = {written(setting.K, 5)} without dimension",
        "D": f"D = {written(setting.damping[0], 5)} without dimension",
        "steps": f"time step Δt = T/{setting.steps} = {time_text(numbers['time_step'])}",
    }


def _spec() -> dict:
    return {
        "sliders": [_slider(name) for name in MAIN_FIELDS],
        "groups": group_spec(),
        "system": [_switch("bodies"), _switch("stops")],
        "units": _switch("units"),
        "solver": [_list("integrator"), *map(_number, _INTEGRATOR_NUMBERS), _list("law"), *map(_number, _LAW_NUMBERS)],
        "solverSwitches": [*map(_switch, _SOLVER_SWITCHES)],
        "starts": [*map(_number, START_FIELDS)],
        "viewSwitches": [*map(_switch, _VIEW_SWITCHES)],
        "scenes": [each.button() for each in buttons()],
        "shelf": [each.button() for each in shelf().values()],
        "dampedByRestitution": [*LAWS_OF_RATIO, *LAWS_BY_RESTITUTION],
        "opening": OPENING,
        "defaults": Setting().texts(),
    }


def _slider(name: str) -> dict:
    return _number(name) | {"whole": FIELDS[name].whole, "log": name != "eta", "step": _STEP}


def _number(name: str) -> dict:
    return {"name": name, "label": FIELDS[name].label, "hint": FIELDS[name].hint}


def _list(name: str) -> dict:
    """A choice of many."""
    return _switch(name) | {"listed": True}


def _switch(name: str) -> dict:
    field = FIELDS[name]
    return {"name": name, "label": field.label, "doc": field.hint, "choices": dict(field.choices)}
