"""Sliders, typed values, switches and scene buttons: one component that runs in the browser.

Native inputs in a `JSComponent`, for three measured reasons: its messages skip the
50 ms that Panel waits before it handles a widget's event, it needs no ``unsafe-eval``,
and it can hold back moves until the browser has painted the last one. All that comes
from it is text, and `app.explorer.state` alone decides what is taken.
"""

from __future__ import annotations

import math

import param
from vibroscope.app.explorer.scenes import Scene, scenes
from vibroscope.app.explorer.state import MAIN_FIELDS, Explorer, Setting, texts_of
from vibroscope.app.page.files import script, style
from vibroscope.app.page.shared.component import Component

# Steps of one arrow key: linear in η, in decades elsewhere.
_STEP = 0.01
_NUMBERS = ("kappa", "d1", "d2", "kappa3", "d3", "restitution", "threshold", "omega1", "m1", "amplitude")
_FOLDED = {
    "joint_damping": {"table": "as measured", "derived": "from d₁, d₂"},
    "located": {"no": "at the next step", "yes": "located"},
}
_SHOWN = {
    "frame": {"relative": "relative", "absolute": "absolute", "difference": "difference"},
    "coordinate": {"xi1": "ξ₁", "xi2": "ξ₂"},
    "units": {"none": "non-dimensional", "physical": "mm, s, N"},
}


class Controls(Component):
    """The panel of inputs; ``spec`` is fixed, ``shown`` is what the server last accepted."""

    spec = param.Dict(doc="Limits, labels and scenes")
    motions = param.Boolean(default=True, doc="Whether the open tab draws motions: else how they are shown is hidden")
    shown = param.Dict(default={}, doc="Accepted values, what was refused, and the number of the last move")

    _esm = script("shared/dom", "controls/controls")
    _stylesheets = [style("controls/controls")]  # noqa: RUF012 - Panel reads it from the class

    def __init__(self, **params) -> None:
        super().__init__(spec=_spec(), css_classes=["controls"], sizing_mode="stretch_both", **params)


def shown(setting: Setting, **more) -> dict:
    """What the browser is told: accepted texts, a note below each slider, the scene, and ``more``.

    ``move`` is the number of the move that is answered, ``frame`` asks for a sign once painted, ``address`` is what the
    page's address becomes, ``refused`` has a name and a text, ``undo``, ``redo``, ``pinned`` say what can be done.
    """
    return {
        "texts": texts_of(setting),
        "notes": _notes(setting),
        "scenes": [key for key, scene in scenes().items() if scene.matches(setting)],
        **more,
    }


def _notes(setting: Setting) -> dict[str, str]:
    """Below the sliders: Δτ, and what the numbers are in an FE input file."""
    step = f"Δτ = T/{setting.steps} = {2 * math.pi / setting.eta / setting.steps:.3g}"
    if setting.scale is None:
        return {"steps": step}
    numbers = setting.scale.settings(setting.eta, setting.penalty)
    return {
        "eta": f"{numbers['excitation']:.4g} Hz, T = {numbers['period']:.4g} s",
        "K": f"{numbers['stiffness']:.4g} N/m",
        "D": f"damper 2D: {numbers['damping']:.4g} N·s/m",
        "steps": f"{step}: {numbers['time_step']:.4g} s",
    }


def _spec() -> dict:
    return {
        "sliders": [_number(name) | {"log": name != "eta", "step": _STEP} for name in MAIN_FIELDS],
        "numbers": [_number(name) for name in _NUMBERS],
        "folded": [_switch(name, choices) for name, choices in _FOLDED.items()],
        "shown": [_switch(name, choices) for name, choices in _SHOWN.items()],
        "scenes": [_button(scene) for scene in scenes().values()],
        "defaults": texts_of(Explorer().setting()),
    }


def _number(name: str) -> dict:
    rule = Explorer.param[name]
    low, high = rule.bounds
    return {
        "name": name,
        "label": rule.label,
        "hint": rule.doc,
        "low": low,
        "high": high,
        "whole": isinstance(rule, param.Integer),
    }


def _switch(name: str, choices: dict[str, str]) -> dict:
    rule = Explorer.param[name]
    return {"name": name, "label": rule.label, "doc": rule.doc, "choices": choices}


def _button(scene: Scene) -> dict:
    return {"key": scene.key, "group": scene.group, "label": scene.label, "tooltip": scene.tooltip, "eta": scene.eta}
