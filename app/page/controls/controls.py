"""Sliders, typed values, switches and scene buttons: one component that runs in the browser.

It has native inputs in a `JSComponent`, for three measured reasons: its messages do not wait the 50 ms for which Panel
delays a widget's event, it needs no ``unsafe-eval``, and it can hold back moves until the browser has painted the last
one. Its messages hold text only, and `app.explorer.state` decides what is accepted.
"""

from __future__ import annotations

import math

import param
from vibroscope.app.explorer.field_units import shown_field
from vibroscope.app.explorer.scenes import Scene, buttons, scene_key
from vibroscope.app.explorer.state import MAIN_FIELDS, START_FIELDS, Explorer, Setting, print_end
from vibroscope.app.page.files import script, style
from vibroscope.app.page.shared.component import Component
from vibroscope.engine import written

_STEP = 0.01  # of one arrow key: in η, and in decades of the other sliders
_NUMBERS = ("kappa", "d1", "d2", "kappa3", "d3", "restitution", "threshold", "omega1", "m1", "amplitude")
_SOLVER_SWITCHES = {
    "joint_damping": {"table": "as measured", "derived": "of both dampers"},
    "located": {"no": "at the next step", "yes": "cut at contact"},
}
_VIEW_SWITCHES = {
    "frame": {"relative": "relative", "absolute": "absolute", "difference": "difference"},
    "coordinate": {"xi1": "pendulum 1", "xi2": "pendulum 2"},
    "units": {"none": "non-dimensional", "si": "SI", "mm-t-s": "mm-t-s"},
}


class Controls(Component):
    """The panel of inputs."""

    spec = param.Dict(doc="Limits, labels and scenes; fixed")
    motions = param.Boolean(default=True, doc="Whether the open tab draws motions, and the switches for that are shown")
    fields = param.Dict(default={}, doc="How the number of each field is shown: another one in other units")
    shown = param.Dict(default={}, doc="The accepted setting, see `show_setting`")

    _esm = script("shared/dom", "controls/parts", "controls/controls")
    _stylesheets = [style("shared/scroll_cue", "controls/controls")]  # noqa: RUF012 - Panel reads it from the class

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
        fields = {name: _field(name, setting) for name in (*MAIN_FIELDS, *_NUMBERS, *START_FIELDS)}
        if fields != self.fields:  # a move changes none of them
            self.fields = fields
        self.shown = {
            "texts": setting.texts(),
            "numbers": {name: _number_text(name, setting) for name in fields},
            "notes": _notes(setting),
            "scene": scene_key(setting),
            **answer,
        }


def _field(name: str, setting: Setting) -> dict:
    """How a number is shown; ``locked``: why it cannot be changed, empty if it can."""
    field, rule = shown_field(name, setting), Explorer.param[name]
    low, high = (print_end(field.factor * end) for end in rule.bounds)
    return {
        "label": field.label,
        "hint": field.hint,
        "name": field.name,
        "unit": field.unit,
        "factor": field.factor,
        "range": f"{low} to {'' if rule.inclusive_bounds[1] else 'below '}{high}",
        "locked": "follows from both dampers; choose “as measured” to type it" if _is_derived(name, setting) else "",
    }


def _number_text(name: str, setting: Setting) -> str:
    """A number as its field shows it."""
    if _is_derived(name, setting):
        return written(setting.system.derived_joint_damping)
    return shown_field(name, setting).number(getattr(setting, name))


def _is_derived(name: str, setting: Setting) -> bool:
    return name == "d3" and setting.joint_damping == "derived"


def _notes(setting: Setting) -> dict[str, str]:
    """The notes below the sliders: Δτ, and with units the numbers of the model."""
    step = f"time step Δτ = T/{setting.steps} = {written(2 * math.pi / setting.eta / setting.steps)}"
    if setting.scale is None:
        return {"steps": step}
    numbers = setting.scale.settings(setting.eta, setting.penalty)
    return {
        "eta": f"ratio η = {written(setting.eta, 5)}, period T = {written(numbers['period'])} s",
        "K": f"K = {written(setting.K, 5)} without dimension",
        "D": f"D = {written(setting.D, 5)} without dimension",
        "steps": f"time step Δt = T/{setting.steps} = {written(numbers['time_step'])} s",
    }


def _spec() -> dict:
    return {
        "sliders": [_slider(name) for name in MAIN_FIELDS],
        "numbers": [_number(name) for name in _NUMBERS],
        "starts": [_number(name) for name in START_FIELDS],
        "solverSwitches": [_switch(name, choices) for name, choices in _SOLVER_SWITCHES.items()],
        "viewSwitches": [_switch(name, choices) for name, choices in _VIEW_SWITCHES.items()],
        "scenes": [_button(scene) for scene in buttons()],
        "defaults": Setting().texts(),
    }


def _slider(name: str) -> dict:
    low, high = Explorer.param[name].softbounds
    whole = isinstance(Explorer.param[name], param.Integer)
    return _number(name) | {"low": low, "high": high, "whole": whole, "log": name != "eta", "step": _STEP}


def _number(name: str) -> dict:
    rule = Explorer.param[name]
    return {"name": name, "label": rule.label, "hint": rule.doc}


def _switch(name: str, choices: dict[str, str]) -> dict:
    rule = Explorer.param[name]
    return {"name": name, "label": rule.label, "doc": rule.doc, "choices": choices}


def _button(scene: Scene) -> dict:
    figure = f"η {scene.eta:.2f} {scene.label}" if scene.group == "motion" else f"{scene.group} {scene.label}"
    return {
        "key": scene.key,
        "title": scene.title,
        "figure": figure,
        "tooltip": f"{scene.caption} {scene.tooltip}",
        "first": scene.first,
    }
