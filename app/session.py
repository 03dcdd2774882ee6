"""One browser session: state → compute → present → push, one way.

Everything here runs in the session's own document, apart from `_solved`, which a
worker thread calls and which only schedules. One update is in flight at a time:
the next is pushed when the browser says that it has painted the last.
"""

from __future__ import annotations

import logging
import time
from dataclasses import dataclass
from functools import partial

import panel as pn
from bokeh.models import Span

from app import words
from app.compute import Frame, Latest, kept_frame
from app.diagrams import kept
from app.present import WINDOW, Columns, present
from app.scenes import scene_of, scenes
from app.state import Explorer, Refused, Setting, parse_address, print_address, print_number
from app.views.base import INK
from app.views.controls import Controls, shown
from app.views.diagram import DiagramView
from app.views.displacement import DisplacementView
from app.views.force import ForceView
from app.views.phase import PhaseView
from app.views.ranges import OwnedRange
from app.views.report import Report
from engine import Diagram

log = logging.getLogger("vibroscope")

# A browser that says nothing for so long (seconds) is pushed to all the same.
_PATIENCE = 1.0


@dataclass(frozen=True, eq=False)
class _Ready:
    """A frame, ready to be written: the browser's move it answers, and what the views need."""

    move: int
    setting: Setting
    columns: dict[str, Columns]
    told: words.Told


def _ready(move: int, frame: Frame) -> _Ready:
    return _Ready(move, frame.setting, present(frame), words.tell(frame))


class Session:
    """Wires the state of one session to its views."""

    def __init__(self, query: str = "") -> None:
        self.state = Explorer()
        self.controls = Controls()
        self.report = Report()
        self._time = OwnedRange(0, WINDOW)
        hair = Span(dimension="height", line_color=INK, line_dash="dotted", line_width=1)
        self.phase = PhaseView()
        self.displacement = DisplacementView(self._time.range, hair)
        self.force = ForceView(self._time.range, hair)
        self.diagram = DiagramView(self.phase.sections, self._diagram, self._tapped)
        self._doc = pn.state.curdoc
        self._latest = Latest(self._solved)
        self._move = 0  # the browser's number of its last move
        self._scene = ""  # ranges start afresh when this changes
        self._refused = ""
        self._keep_address = False
        self._ready: _Ready | None = None
        self._closed = False
        self._unpainted = 0
        self._pushed_at = 0.0
        self._frames = 0
        self.controls.on_msg(self._message)
        self._open(query)
        self._show_what_is_kept()

    def _open(self, query: str) -> None:
        """Take the address, or say why not and start from the defaults."""
        try:
            self.state.apply(parse_address(query))
        except Refused as error:
            self.report.error = f"{error} The link was not taken, so this is the default setting."
            self._keep_address = True
        self._show_controls(self._move)

    def _show_what_is_kept(self) -> None:
        """A setting that was solved before goes out with the page itself, a round trip earlier."""
        frame = kept_frame(self.state.setting())
        if frame is not None:
            self._push(_ready(self._move, frame))

    def start(self) -> None:
        """First computation, once the page is open, unless its result is there already."""
        if not self._frames:
            self._ask()

    def close(self) -> None:
        """The browser is gone: nothing more is wanted."""
        self._closed = True
        self._latest.close()

    # -- from the browser ----------------------------------------------------

    def _message(self, event) -> None:
        data = event.data
        if not isinstance(data, dict):
            return
        if "painted" in data:
            self._painted(data["painted"])
            return
        move = data.get("move")
        self._move = move if isinstance(move, int) else self._move
        if "scene" in data:
            self._choose(data["scene"])
        elif isinstance(data.get("set"), dict):
            self._set(data["set"])

    def _choose(self, key: object) -> None:
        scene = scenes().get(key) if isinstance(key, str) else None
        if scene is not None:
            self._scene = ""  # also when it is the same scene again: a way back from any zoom
            self._set(scene.texts())

    def _tapped(self, eta: float) -> None:
        self._set({"eta": print_number(eta)})

    def _set(self, texts: dict) -> None:
        try:
            self.state.apply(texts)
        except Refused as error:
            self._refuse(error)
            self._show_controls(self._move)
            return
        self._refused = self.report.error = ""
        self._keep_address = False
        self._ask()

    def _refuse(self, error: Refused) -> None:
        self._refused = error.name
        self.report.error = str(error)

    # -- compute -------------------------------------------------------------

    def _ask(self) -> None:
        self._latest.submit(self._move, self.state.setting())

    def _solved(self, move: int, result: Frame | Exception) -> None:
        """In a worker thread: prepare all that needs no document, then go to the session's own loop."""
        if isinstance(result, Frame):
            try:
                self._later(partial(self._arrived, _ready(move, result)))
                return
            except Exception as error:  # told on the page as any other
                result = error
        self._later(partial(self._failed, move, result))

    def _later(self, callback) -> None:
        if self._doc.session_context is not None and not self._closed:
            self._doc.add_next_tick_callback(callback)

    def _arrived(self, ready: _Ready) -> None:
        self._ready = ready
        self._push_when_painted()

    def _failed(self, move: int, error: Exception) -> None:
        log.error("computing failed", exc_info=error)
        self.report.error = f"This setting could not be computed ({error}). The figures show the last one that could."
        self._show_controls(move)

    def _diagram(self, joint_damping: str) -> Diagram | None:
        """The kept diagram, or None until it has been read or computed."""
        future = kept(joint_damping)
        if not future.done():
            future.add_done_callback(lambda _: self._later(self._redraw))
            return None
        return future.result() if future.exception() is None else None

    def _redraw(self) -> None:
        with pn.io.hold(self._doc):
            self.diagram.redraw()

    # -- push ----------------------------------------------------------------

    def _push_when_painted(self) -> None:
        waited = time.monotonic() - self._pushed_at
        if self._unpainted and waited < _PATIENCE:
            return
        if self._ready is not None:
            ready, self._ready = self._ready, None
            self._push(ready)

    def _painted(self, frame: object) -> None:
        if frame == self._unpainted:
            self._unpainted = 0
            self._push_when_painted()

    def _push(self, ready: _Ready) -> None:
        """All figures, in one message."""
        setting, columns = ready.setting, ready.columns
        scene = scene_of(setting)
        fresh, self._scene = bool(scene) and scene != self._scene, scene
        self._frames += 1
        self._unpainted, self._pushed_at = self._frames, time.monotonic()
        with pn.io.hold(self._doc):
            if fresh:
                self._time.put(0, WINDOW)
            self.phase.update(columns, fresh=fresh)
            self.displacement.update(columns, setting.frame, fresh=fresh)
            self.force.update(columns, fresh=fresh)
            self.diagram.update(setting.eta, setting.joint_damping, setting.coordinate)
            self.report.update(ready.told)
            self._show_controls(ready.move)
        self._doc.add_timeout_callback(self._push_when_painted, int(1000 * _PATIENCE) + 50)

    def _show_controls(self, move: int) -> None:
        """Tell the browser what holds, and that ``move`` has been dealt with."""
        setting = self.state.setting()
        address = "" if self._keep_address else print_address(setting)
        self.controls.shown = shown(setting, move, self._frames, address, self._refused)
