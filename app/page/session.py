"""One browser session: what the browser sends, checked; what holds, told; one tab at a time.

Everything here runs in the session's own document. Data run one way: state → the open tab → compute → present → views.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping

import panel as pn
from vibroscope.app.explorer.history import History
from vibroscope.app.explorer.scenes import scenes
from vibroscope.app.explorer.state import Explorer, Refused, Setting, texts_of
from vibroscope.app.export.formats import joined, setting_of_toml
from vibroscope.app.page.address import Address
from vibroscope.app.page.controls.controls import Controls, shown
from vibroscope.app.page.flow import Flow
from vibroscope.app.page.handout import Handout
from vibroscope.app.page.header.header import Header
from vibroscope.app.page.loop import Loop
from vibroscope.app.page.opening import THEMES, Opening, read_opening
from vibroscope.app.page.tab_area import Stage
from vibroscope.app.page.tabs import TABS, Move
from vibroscope.app.page.taking import offers, take
from vibroscope.app.runtime import logs, metrics


class Session:
    """Wires the state of one session to the controls and to the tab that is open."""

    def __init__(self, query: str = "") -> None:
        self.doc = pn.state.curdoc
        self.state = Explorer()
        self.controls = Controls()
        self.header = Header(tabs=[[tab.key, tab.title] for tab in TABS.values()])
        self._address = Address(self, self._seen_anew)
        self.stage = Stage(self, self._address.follow)
        self._loop = Loop(self.doc)
        self._flow = Flow(self.doc, self._answer)
        self._history = History()
        self._files = Handout(self, self.header.give)
        self._move = 0  # the browser's number of its last move
        self._refused: dict[str, str] = {}
        self._pinned: Setting | None = None
        self._waiting = False  # what is set is not solved before the page is open
        self._answered = 0  # the last move that was answered
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
            self._address.refused, asked = True, Opening()
        self._pinned = asked.pinned
        self._address.theme = self.header.theme = asked.theme
        self._open(asked.tab)
        self.stage.tab.restore(asked.view)
        self._introduce()
        self._answer(self._move, 0)
        self._waiting = not self.stage.tab.at_once(Move(self._move, self.state.setting()))

    def start(self) -> None:
        """The page is open: do what had to wait, solve what was not solved before."""
        self._loop.start()
        if self._waiting:
            self._show()

    def close(self) -> None:
        """The browser is gone: nothing more is wanted."""
        self._loop.close()
        self.stage.close()

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
            "theme": self._dress,
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
        self._address.refused = False
        self._show(fresh=fresh)

    def _pin(self, on: bool) -> None:
        self._pinned = self.state.setting() if on else None
        self._show()

    def _dress(self, theme: object) -> None:
        """The user has chosen light or dark, now or on an earlier visit: the page does it, the link says it."""
        if theme in THEMES:
            self._address.theme = theme
            self._address.follow()

    def _take(self, what: object) -> None:
        """A file or a text that the user wants to have."""
        if isinstance(what, str):
            tab, setting = self.stage.tab, self.state.setting()
            address = f"?{self._address.link(tab, tab.shown() or setting)}"
            self._files.write(what, take(tab, what, setting, address))

    def _load(self, parts: object) -> None:
        """Parameters from a file: all of it is taken or none."""
        try:
            texts = setting_of_toml(joined(parts))
            self.state.check(texts)
        except ValueError as error:
            self.tell(f"The file was not taken: {error}")
        else:
            self.set(texts)

    # -- tabs ----------------------------------------------------------------

    def open(self, key: str) -> None:
        """Show a tab."""
        self._open(key)
        self._introduce()
        self._show()

    def _open(self, key: str) -> None:
        self.stage.open(key)
        self.header.tab = key
        self.offer()
        self.controls.param.update(visible=TABS[key].controls, motions=TABS[key].motions)

    def _show(self, *, fresh: bool = False) -> None:
        self._waiting = False
        self.stage.tab.show(Move(self._move, self.state.setting(), fresh))

    @property
    def pinned(self) -> Setting | None:
        """See `app.page.tab.Desk`."""
        return self._pinned

    # -- to the browser ------------------------------------------------------

    def push(self, move: int, write: Callable[[], None]) -> None:
        """See `app.page.tab.Desk`."""
        self._flow.push(move, write)

    def later(self, callback: Callable[[], None]) -> None:
        """See `app.page.tab.Desk`."""
        self._loop.later(callback)

    def tell(self, error: str, move: int | None = None) -> None:
        """See `app.page.tab.Desk`."""
        self.header.error = error
        self._answer(self._move if move is None else move, self._flow.frames)

    def summarise(self, text: str) -> None:
        """See `app.page.tab.Desk`."""
        self.header.summary = f"{self.stage.tab.title}. {text}"

    def _introduce(self) -> None:
        """Say what the tab is that has been opened, or the last one's verdict would stay."""
        self.summarise(self.stage.tab.summary(self.state.setting()))

    def _seen_anew(self) -> None:
        """The address follows how the page is seen; no move is answered by that."""
        if self._shown_address() != self.controls.shown["address"]:
            self._answer(self._answered, self._flow.frames)

    def _shown_address(self) -> str:
        return self._address.shown(self.stage.tab, self.state.setting())

    def offer(self) -> None:
        """See `app.page.tab.Desk`."""
        offered = offers(self.stage.tab)
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
            address=self._shown_address(),
            refused=self._refused,
            undo=self._history.can_undo,
            redo=self._history.can_redo,
            pinned=self._pinned is not None,
        )


def _log_refusal(error: Refused) -> None:
    metrics.REFUSED.add("value")
    logs.event("refused", what="value", name=error.name)
