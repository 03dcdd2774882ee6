"""Sliders, typed values, switches and scene buttons: one component that runs in the browser.

It has native inputs in a `JSComponent`, for three measured reasons: its messages do not wait the 50 ms for which Panel
delays a widget's event, it needs no ``unsafe-eval``, and it can hold back moves until the browser has painted the last
one. Its messages hold text only, and `app.explorer.reading` decides what is accepted.
"""

from __future__ import annotations

import math

import param
from vibroscope.app.explorer.drawing import drawing, drawing_in_words
from vibroscope.app.explorer.field_units import shown_field
from vibroscope.app.explorer.parameters import FIELDS, MAIN_FIELDS, START_FIELDS
from vibroscope.app.explorer.physical_fields import CONTACT_OF_SYSTEM
from vibroscope.app.explorer.scenes import OPENING, Scene, buttons, scene_key
from vibroscope.app.explorer.shelf import shelf, shelf_key
from vibroscope.app.explorer.state import LAWS_OF_RATIO, Setting, integrator_numbers, law_numbers, slider_range
from vibroscope.app.page.controls.system import (
    group_spec,
    plain_description,
    plain_number,
    system_fields,
    system_numbers,
    system_title,
    why_locked,
)
from vibroscope.app.page.shared.component import Component
from vibroscope.app.runtime.number_text import print_number
from vibroscope.engine import LAWS_BY_RESTITUTION, written
from vibroscope.engine.law_table import LAW_NUMBERS, LAWS
from vibroscope.engine.units import time_text

_STEP = 0.01  # of one arrow key: in η, and in decades of the other sliders
_SOLVER_SWITCHES = ("stiffness", "damper", "joint_damping", "located", "status", "without_solution")
_SOLVER_SWITCHES += ("initial_acceleration",)
_SOLVER_SELECTS = ("integrator", "law")
_INTEGRATOR_NUMBERS = ("beta", "gamma", "alpha", "rho")  # as far as the integrator has them
_STIFFNESS_NUMBERS = ("step_scale",)  # where K follows the step
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
            "scene": scene_key(setting) or shelf_key(setting),
            **answer,
        }


def _other_fields(setting: Setting) -> tuple[str, ...]:
    """The fields beside those of the system; a wall has no start, and an integrator only its own numbers."""
    return (
        *MAIN_FIELDS,
        "threshold",
        *integrator_numbers(setting),
        *law_numbers(setting),
        *(_STIFFNESS_NUMBERS if setting.follows_step else ()),
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
        "solverNumbers": [_number("threshold")],
        "solverSelects": [*map(_switch, _SOLVER_SELECTS)],
        "integratorNumbers": [_number(name) for name in _INTEGRATOR_NUMBERS],
        "lawNumbers": [_number(name) for name in (*LAW_NUMBERS, *_STIFFNESS_NUMBERS)],
        "starts": [_number(name) for name in START_FIELDS],
        "solverSwitches": [*map(_switch, _SOLVER_SWITCHES)],
        "viewSwitches": [*map(_switch, _VIEW_SWITCHES)],
        "scenes": [_button(scene) for scene in buttons()],
        "shelf": [each.button() for each in shelf().values()],
        "dampedByRestitution": [*LAWS_OF_RATIO, *LAWS_BY_RESTITUTION],
        "opening": OPENING,
        "defaults": Setting().texts(),
    }


def _slider(name: str) -> dict:
    return _number(name) | {"whole": FIELDS[name].whole, "log": name != "eta", "step": _STEP}


def _number(name: str) -> dict:
    return {"name": name, "label": FIELDS[name].label, "hint": FIELDS[name].hint}


def _switch(name: str) -> dict:
    field = FIELDS[name]
    return {"name": name, "label": field.label, "doc": field.hint, "choices": dict(field.choices)}


def _button(scene: Scene) -> dict:
    figure = f"motion {scene.label}, η = {scene.eta:.2f}" if scene.group == "motion" else f"{scene.group} {scene.label}"
    return {
        "key": scene.key,
        "title": scene.title,
        "figure": figure,
        "tooltip": f"{scene.caption} {scene.tooltip}",
        "first": scene.first,
    }
