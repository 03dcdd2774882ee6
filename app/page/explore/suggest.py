"""Suggest K, D, Δτ: a tolerance, a button, how far the search has come, and what it found."""

from __future__ import annotations

from collections.abc import Callable

import param
from vibroscope.app.page.files import script, style
from vibroscope.app.page.shared.component import Component


class Suggest(Component):
    """Sends ``{"suggest": tolerance in per cent, as typed}`` and ``{"cancel": true}``; draws ``told``."""

    told = param.Dict(
        default={"phase": "idle"},
        doc="phase: idle, running, done or failed; share; error; and what `app.explorer.suggestion.told_of` says",
    )

    _esm = script("shared/dom", "explore/suggest")
    _stylesheets = [style("explore/suggest")]  # noqa: RUF012 - Panel reads it from the class

    def __init__(self, on_ask: Callable[[object], None], on_cancel: Callable[[], None], **params) -> None:
        super().__init__(**params)
        self._on_ask = on_ask
        self._on_cancel = on_cancel
        self.on_msg(self._message)

    def _message(self, event) -> None:
        data = event.data
        if not isinstance(data, dict):
            return
        if "suggest" in data:
            self._on_ask(data["suggest"])
        elif "cancel" in data:
            self._on_cancel()
