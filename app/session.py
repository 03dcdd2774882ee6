"""One browser session: what the browser sends, checked; what holds, told; one tab at a time.

Everything here runs in the session's own document. Data run one way: state → the open tab → compute → present → views.
"""

from __future__ import annotations

import logging
import time
from collections.abc import Callable, Mapping
from concurrent.futures import Future
from functools import partial

import panel as pn

from app import logs, metrics
from app.files import style
from app.flow import Flow
from app.history import History
from app.live import stand_back
from app.opening import FIRST, Opening, read_opening
from app.scenes import scenes
from app.state import (
    Explorer,
    Refused,
    Setting,
    print_address,
    texts_of,
)
from app.tabs import TABS, Move, Tab
from app.tabs.taking import offers, take
from app.takeaway import setting_of_toml
from app.views.controls import Controls, shown
from app.views.header import Header
from app.workers import pool

_RESTS = 150  # ms after which a zoom goes into the address
_LONGEST_FILE = 65_536  # characters


class Session:
    """Wires the state of one session to the controls and to the tab that is open."""

    def __init__(self, query: str = "") -> None:
        self.doc = pn.state.curdoc
        self.state = Explorer()
        self.controls = Controls()
        self.header = Header(tabs=[[tab.key, tab.title] for tab in TABS.values()])
        self.stage = pn.Column(css_classes=["stage"], stylesheets=[style("page")], sizing_mode="stretch_width")
        self._flow = Flow(self.doc, self._answer)
        self._history = History()
        self._tabs: dict[str, Tab] = {}
        self._places: dict[str, pn.Column] = {}
        self._open = ""
        self._name = logs.session.get()
        self._move = 0  # the browser's number of its last move
        self._refused: dict[str, str] = {}
        self._pinned: Setting | None = None
        self._keep_address = False
        self._closed = False
        self._loaded = False
        self._until_loaded: list[Callable[[], None]] = []
        self._waiting = False
        self._writing = False  # a file is on its way
        self._answered = 0  # the last move that was answered
        self._seen_anew = False  # an axis has moved, and nobody has looked yet whether the address changes
        self.controls.on_msg(self._message)
        self.header.on_msg(self._message)
        self._start(query)

    def _start(self, query: str) -> None:
        """Take the address, or say why not and start from the defaults."""
        asked = Opening()
        try:
            asked = read_opening(query)
            self.state.apply(asked.texts)
        except Refused as error:
            _log_refusal(error)
            self.header.error = f"{error} The link was not taken, so this is the default setting."
            self._keep_address, asked = True, Opening()
        self._pinned = asked.pinned
        self._build(asked.tab)
        self._tabs[asked.tab].restore(asked.view)
        self._answer(self._move, 0)
        self._waiting = not self._tabs[asked.tab].at_once(Move(self._move, self.state.setting()))

    def start(self) -> None:
        """The page is open: do what had to wait, solve what was not solved before."""
        self._loaded = True
        for callback in self._until_loaded:
            callback()
        self._until_loaded.clear()
        if self._waiting:
            self._show()

    def close(self) -> None:
        """The browser is gone: nothing more is wanted."""
        self._closed = True
        for tab in self._tabs.values():
            tab.close()

    # -- from the browser ----------------------------------------------------

    def _message(self, event) -> None:
        data = event.data
        if not isinstance(data, dict):
            return
        if "painted" in data:
            self._flow.painted(data["painted"])
            return
        move = data.get("move")
        self._move = move if isinstance(move, int) else self._move
        for name, act in self._acts.items():
            if name in data:
                act(data[name])
                return

    @property
    def _acts(self) -> dict[str, Callable]:
        """What a message may ask for; each takes whatever came with it and checks it."""
        return {
            "set": lambda texts: self.set(texts) if isinstance(texts, dict) else None,
            "scene": self._choose,
            "undo": lambda _: self._go(self._history.undo(self.state.setting())),
            "redo": lambda _: self._go(self._history.redo(self.state.setting())),
            "reset": lambda _: self._reset(),
            "pin": lambda on: self._pin(bool(on)),
            "tab": lambda key: self.open(key) if isinstance(key, str) and key in TABS else None,
            "take": self._take,
            "load": self._load,
        }

    def _choose(self, key: object) -> None:
        scene = scenes().get(key) if isinstance(key, str) else None
        if scene is not None:
            self.set(scene.texts(), fresh=True)  # also when it is the same scene again: a way back from any zoom

    def _reset(self) -> None:
        self._pinned = None
        self.set(texts_of(Explorer().setting()), fresh=True)

    def set(self, texts: Mapping[str, str], *, fresh: bool = False) -> None:
        """Take all of ``texts`` and show it, or say why not."""
        before = self.state.setting()
        try:
            self.state.apply(texts)
        except Refused as error:
            _log_refusal(error)
            self._refused = {"name": error.name, "text": str(error)}
            self._answer(self._move, self._flow.frames)
            return
        self._history.record(before, self.state.setting(), time.monotonic())
        self._moved(fresh)

    def _go(self, setting: Setting | None) -> None:
        """Undo and redo."""
        if setting is not None:
            self.state.apply(texts_of(setting))
        self._moved(False)

    def _moved(self, fresh: bool) -> None:
        self._refused = {}
        self.header.error = ""
        self._keep_address = False
        self._show(fresh=fresh)

    def _pin(self, on: bool) -> None:
        self._pinned = self.state.setting() if on else None
        self._show()

    def _take(self, what: object) -> None:
        """A file or a text that the user wants to have."""
        if not isinstance(what, str):
            return
        tab, setting = self._tabs[self._open], self.state.setting()
        address = f"?{self._link(tab.printed(), tab.shown() or setting)}"
        made = take(tab, what, setting, address)
        if made is None:
            self.tell("There is nothing of that kind to take away here by now: wait for the figures.")
        elif self._writing:
            self.tell("One file after the other: the last one is still being written.")
        else:
            self._writing = True
            pool("files", 1, stand_back).submit(made).add_done_callback(
                lambda done: self.later(partial(self._give, what, done))
            )

    def _give(self, what: str, done: Future) -> None:
        self._writing = False
        if done.cancelled():
            return
        if done.exception() is None:
            self.header.give(what, done.result())
        else:
            logs.event("not written", logging.ERROR, error=done.exception(), what=what)
            self.tell(f"This file could not be written ({done.exception()}).")

    def _load(self, parts: object) -> None:
        """Parameters from a file, its text in parts, since the gate passes no long ones: all of it is taken or none."""
        texts = list(parts.values()) if isinstance(parts, dict) else []
        text = "".join(part for part in texts if isinstance(part, str))
        try:
            if len(text) > _LONGEST_FILE:
                raise ValueError(f"it is longer than {_LONGEST_FILE} characters")
            texts = setting_of_toml(text)
            self.state.check(texts)
        except ValueError as error:
            self.tell(f"The file was not taken: {error}")
        else:
            self.set(texts)

    # -- tabs ----------------------------------------------------------------

    def open(self, key: str) -> None:
        """Show a tab, built now if it was never open before."""
        if key != self._open:
            self._tabs[self._open].hide()
            self._places[self._open].visible = False
            self._build(key)
        self._show()

    def _build(self, key: str) -> None:
        if key not in self._tabs:
            self._tabs[key] = tab = TABS[key](self)
            self._places[key] = pn.Column(
                tab.build(), css_classes=["place"], stylesheets=[style("page")], sizing_mode="stretch_width"
            )
            self.stage.append(self._places[key])
            for owned in tab.ranges.values():
                owned.on_move = self._axis_moved
        self._open = self.header.tab = key
        self.offer()
        self._places[key].visible = True
        self.controls.visible = TABS[key].controls

    def _show(self, *, fresh: bool = False) -> None:
        self._waiting = False
        self._tabs[self._open].show(Move(self._move, self.state.setting(), fresh))

    @property
    def pinned(self) -> Setting | None:
        """See `app.tabs.base.Desk`."""
        return self._pinned

    # -- to the browser ------------------------------------------------------

    def push(self, move: int, write: Callable[[], None]) -> None:
        """See `app.tabs.base.Desk`."""
        self._flow.push(move, write)

    def later(self, callback: Callable[[], None]) -> None:
        """See `app.tabs.base.Desk`."""
        if self.doc.session_context is not None and not self._closed:
            self.doc.add_next_tick_callback(partial(self._once_loaded, callback))

    def _once_loaded(self, callback: Callable[[], None]) -> None:
        """Panel drops what changes between sending the page and hearing that the browser has it."""
        if self._loaded:
            with logs.named(self._name):
                callback()
        else:
            self._until_loaded.append(callback)

    def tell(self, error: str, move: int | None = None) -> None:
        """See `app.tabs.base.Desk`."""
        self.header.error = error
        self._answer(self._move if move is None else move, self._flow.frames)

    def summarise(self, text: str) -> None:
        """See `app.tabs.base.Desk`."""
        self.header.summary = text

    def _axis_moved(self) -> None:
        """A user zooms, or the page follows its data: look at it when it rests, since a wheel says much at once."""
        if not self._seen_anew and self._loaded:
            self._seen_anew = True
            self.doc.add_timeout_callback(self._follow_view, _RESTS)

    def _follow_view(self) -> None:
        """The address follows a zoom; no move is answered by that."""
        self._seen_anew = False
        if not self._closed and self._address() != self.controls.shown["address"]:
            self._answer(self._answered, self._flow.frames)

    def _address(self) -> str:
        """What the browser's address becomes; empty: a link that was refused stays there until something is changed."""
        view = self._tabs[self._open].printed()
        return "" if self._keep_address and not any(view.values()) else self._link(view, self.state.setting())

    def _link(self, view: Mapping[str, str], setting: Setting) -> str:
        """What restores the page with a setting."""
        tab = self._open if self._open != FIRST else ""
        return print_address(setting, tab, self._pinned, **view)

    def offer(self) -> None:
        """See `app.tabs.base.Desk`."""
        offered = offers(self._tabs[self._open])
        if offered != self.header.offers:
            self.header.offers = offered

    def _answer(self, move: int, frame: int) -> None:
        """Tell the browser what holds, and that ``move`` has been dealt with."""
        self._answered = move
        self.offer()
        setting = self.state.setting()
        self.controls.shown = shown(
            setting,
            move=move,
            frame=frame,
            address=self._address(),
            refused=self._refused,
            undo=self._history.can_undo,
            redo=self._history.can_redo,
            pinned=self._pinned is not None,
        )


def _log_refusal(error: Refused) -> None:
    metrics.REFUSED.add("value")
    logs.event("refused", what="value", name=error.name)
