"""Sliders, typed values, switches and scene buttons: one component that runs in the browser.

Native inputs in a `JSComponent`, for three measured reasons: its messages skip the
50 ms that Panel waits before it handles a widget's event, it needs no ``unsafe-eval``,
and it can hold back moves until the browser has painted the last one. All that comes
from it is text, and `app.state` alone decides what is taken.
"""

from __future__ import annotations

import math
from pathlib import Path

import panel as pn
import param

from app.files import asset
from app.scenes import Scene, scenes
from app.state import Explorer, Setting, texts_of

_HINTS = {
    "eta": "excitation frequency Ω/ω₁",
    "K": "penalty stiffness",
    "D": "penalty damping",
    "steps": "steps per period T",
}
# Steps of one arrow key: linear in η, in decades elsewhere.
_STEPS = {"eta": 0.01, "K": 0.01, "D": 0.01, "steps": 0.01}
_CHOICES = {
    "joint_damping": {"table": "table 0.0330", "derived": "derived 0.0085"},
    "frame": {"relative": "relative", "absolute": "absolute"},
    "coordinate": {"xi1": "ξ₁", "xi2": "ξ₂"},
}


class Controls(pn.custom.JSComponent):
    """The panel of inputs; ``spec`` is fixed, ``shown`` is what the server last accepted."""

    spec = param.Dict(doc="Limits, labels and scenes")
    shown = param.Dict(default={}, doc="Accepted values, what was refused, and the number of the last move")

    _esm = Path(__file__).with_suffix(".js")
    _stylesheets = [asset("style.css")]  # noqa: RUF012 - Panel reads it from the class

    def __init__(self, **params) -> None:
        super().__init__(spec=_spec(), **params)


def shown(setting: Setting, move: int, frame: int, address: str, refused: str) -> dict:
    """What the browser is told: accepted texts, Δτ, the scene; ``frame`` asks for a sign once painted."""
    return {
        "texts": texts_of(setting),
        "dtau": f"Δτ = T/{setting.steps} = {2 * math.pi / setting.eta / setting.steps:.3g}",
        "scenes": [key for key, scene in scenes().items() if scene.matches(setting)],
        "address": address,
        "move": move,
        "frame": frame,
        "refused": refused,
    }


def _spec() -> dict:
    return {
        "sliders": [_slider(name) for name in _HINTS],
        "switches": [
            {"name": name, "label": Explorer.param[name].label, "doc": Explorer.param[name].doc, "choices": choices}
            for name, choices in _CHOICES.items()
        ],
        "scenes": [_button(scene) for scene in scenes().values()],
    }


def _slider(name: str) -> dict:
    rule = Explorer.param[name]
    low, high = rule.bounds
    return {
        "name": name,
        "label": rule.label,
        "hint": _HINTS[name],
        "low": low,
        "high": high,
        "log": name != "eta",
        "step": _STEPS[name],
        "whole": isinstance(rule, param.Integer),
    }


def _button(scene: Scene) -> dict:
    return {"key": scene.key, "group": scene.group, "label": scene.label, "tooltip": scene.tooltip, "eta": scene.eta}
