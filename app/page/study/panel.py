"""The panel beside the figures of a study: what to show, how far it is, a key of the colours, and what it says."""

from __future__ import annotations

from collections.abc import Callable

import param
from vibroscope.app.page.files import script, style
from vibroscope.app.page.shared.component import Component


class StudyPanel(Component):
    """Native inputs; what comes from them is checked here against ``spec`` before anybody hears of it."""

    spec = param.Dict(doc="Title, hint, switches (name, label, choices), limits (name, label, low, high), cursor")
    chosen = param.Dict(doc="What is chosen, by name")
    status = param.Dict(default={}, doc="How far: text, share, running")
    key = param.List(default=[], doc="Colour, name and pattern of each class")
    told = param.List(default=[], doc="Head and text of what the figures say")

    _esm = script("shared/dom", "study/study")
    _stylesheets = [style("study/study")]  # noqa: RUF012 - Panel reads it from the class

    def __init__(
        self, spec: dict, chosen: dict, on_choice: Callable[[dict], None], on_stop: Callable[[bool], None], **params
    ) -> None:
        super().__init__(spec=spec, chosen=chosen, css_classes=["study"], sizing_mode="stretch_width", **params)
        self._on_choice = on_choice
        self._on_stop = on_stop
        self.on_msg(self._message)

    def _message(self, event) -> None:
        data = event.data
        if not isinstance(data, dict):
            return
        if isinstance(data.get("stop"), bool):
            self._on_stop(data["stop"])
        if isinstance(data.get("choose"), dict):
            self._on_choice(self.allowed(data["choose"]))

    def allowed(self, asked: dict) -> dict:
        """What is chosen now, with as much of what is asked as the switches and limits allow."""
        chosen = dict(self.chosen)
        for switch in self.spec["switches"]:
            value = asked.get(switch["name"])
            if isinstance(value, str) and value in switch["choices"]:
                chosen[switch["name"]] = value
        for limit in self.spec["limits"]:
            value = asked.get(limit["name"])
            if type(value) in (int, float) and limit["low"] <= value <= limit["high"]:
                chosen[limit["name"]] = round(value)
        return chosen
