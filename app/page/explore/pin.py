"""The pinned result behind the others: solved once, and presented anew only where it is to be drawn otherwise."""

from __future__ import annotations

from collections.abc import Callable

import panel as pn
from vibroscope.app.explorer.compute import Frame, Latest, kept_frame
from vibroscope.app.explorer.present import Columns, present
from vibroscope.app.explorer.state import Setting
from vibroscope.app.explorer.words import cause
from vibroscope.app.page.delivery import prepared
from vibroscope.app.page.tab import Desk

_DRAWN = ("frame", "units", "omega1", "m1", "amplitude")  # how a result is drawn, not what it is


class Pin:
    """What is pinned, as the present setting would draw it; ``draw`` gets its columns, or None where there are none."""

    def __init__(self, desk: Desk, draw: Callable[[dict[str, Columns] | None], None]) -> None:
        self.desk = desk
        self._draw = draw
        self._latest = Latest(prepared(desk, _drawn, self._arrived, self._failed))
        self._wanted: Setting | None = None

    def follow(self, setting: Setting) -> None:
        """Draw what is pinned, if that is not done or under way: at once if it is kept, else when it is solved."""
        pinned = self.desk.pinned
        wanted = pinned and pinned._replace(**{name: getattr(setting, name) for name in _DRAWN})
        if wanted == self._wanted:
            return
        self._wanted = wanted
        frame = kept_frame(wanted) if wanted else None
        if wanted and frame is None:
            self._latest.submit(0, wanted)
            return
        self._latest.withdraw()
        self._draw(present(frame) if frame else None)

    def close(self) -> None:
        """The session has ended."""
        self._latest.close()

    def _arrived(self, _: int, drawn: tuple[Setting, dict[str, Columns]]) -> None:
        """Also while another tab is open: nothing would ask for it again."""
        setting, columns = drawn
        if setting == self._wanted:
            with pn.io.hold(self.desk.doc):
                self._draw(columns)

    def _failed(self, _: int, error: Exception) -> None:
        if self._wanted is not None:
            self._draw(None)
            self.desk.tell(f"What is pinned could not be computed ({cause(error)}). Unpin it, or pin another setting.")


def _drawn(frame: Frame) -> tuple[Setting, dict[str, Columns]]:
    return frame.setting, present(frame)
