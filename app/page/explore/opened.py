"""A motion that was opened from a branch of the bifurcation diagram: what to know of it, while it is set."""

from collections.abc import Callable, Mapping

import param
from vibroscope.app.explorer.closed_orbit import ClosedOrbit, linked_orbit
from vibroscope.app.explorer.present import Columns
from vibroscope.app.explorer.state import Setting
from vibroscope.app.page.shared.component import Component
from vibroscope.app.page.shared.seen import orbit_words


class OpenedMotion(Component):
    """A line above the figures."""

    words = param.String(default="", doc="What to know of the motion")

    script = "explore/opened"

    def __init__(self, **params) -> None:
        super().__init__(visible=False, **params)
        self._texts: Mapping[str, str] = {}
        self._setting: Setting | None = None  # of the motion, once it is set
        self._orbit: ClosedOrbit | None = None
        self._linked: Mapping[str, float] = {}  # what a link says of it, until the first setting is shown
        self.on_close: Callable[[], None] = lambda: None  # called when the user closes the line
        self.listen(close=(bool, self._close))

    def announce(self, texts: Mapping[str, str], words: str, orbit: ClosedOrbit) -> None:
        """Show these words as soon as, and as long as, the setting is that of ``texts``."""
        self._texts, self._setting, self._orbit, self.words = texts, None, orbit, words
        self._linked = {}

    def restore(self, choice: Mapping[str, float]) -> None:
        """Show the motion that a link names beside the setting that is followed next."""
        self._linked = choice

    def choice(self) -> dict[str, float]:
        """The numbers of the motion for a link; none if it is not shown."""
        return self._orbit.linked(self._setting) if self.visible else {}

    def columns(self, setting: Setting) -> Columns:
        """The motion in the phase plots; empty if it is not that of the setting."""
        return self._orbit.columns(setting) if self.visible else {}

    def follow(self, setting: Setting) -> None:
        """Follow the setting: another motion has nothing to do with the words."""
        if self._linked:
            self._take_linked(setting)
        if self._setting is None and self._texts:
            given = setting.texts()
            if all(given[name] == text for name, text in self._texts.items() if name != "zero_start"):
                self._setting = setting
        known = self._setting is not None and setting.drawn_like(self._setting) == self._setting
        if known != self.visible:
            self.visible = known

    def _take_linked(self, setting: Setting) -> None:
        orbit, self._linked = linked_orbit(self._linked, setting), {}
        if orbit is not None:
            self._setting, self._orbit = setting, orbit
            self.words = orbit_words(orbit, orbit.largest_multiplier())

    def _close(self, _: bool) -> None:
        self.close()
        self.on_close()

    def close(self) -> None:
        """Show nothing more."""
        self._texts, self._setting, self._linked, self.visible = {}, None, {}, False
