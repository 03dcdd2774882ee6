"""One browser session: the setting, the browser components and the open view, wired together.

Everything here runs on the loop of the session's document, but for what `add_models` calls. Data run one way: message →
setting → open view → compute → present → figures.

Messages from the browser: each calls one method of the session. A message of another form is ignored.

A message is a dictionary with the browser's number of the move and one of the names below, such as
``{"move": 7, "set": {"eta": "1.2"}}``. Its content is unchecked text, and the called method decides whether it is
accepted; ``{"painted": 12}`` says that an update is on the screen.

Undo and redo are a history of settings.
"""

import math
import time
from collections import deque
from collections.abc import Callable, Mapping
from concurrent.futures import Future
from functools import partial
from typing import ClassVar

import panel as pn
from vibroscope.app.explorer.errors import Refused
from vibroscope.app.explorer.link import MOST_PINS, View
from vibroscope.app.explorer.parameters import FIELDS
from vibroscope.app.explorer.physical_fields import entered
from vibroscope.app.explorer.presets import opening_setting, preset_of, presets
from vibroscope.app.explorer.reading import read_setting
from vibroscope.app.explorer.state import Setting
from vibroscope.app.explorer.typed import plain_texts
from vibroscope.app.page.address import THEMES, Address
from vibroscope.app.page.controls.controls import Controls
from vibroscope.app.page.header.header import Header
from vibroscope.app.page.shared.component import Acts, Upload
from vibroscope.app.page.tab import Move, TabView
from vibroscope.app.page.tabs import TABS, VIEWS, TabArea
from vibroscope.app.page.take_away import LARGEST_FILE, TakeAway, offered_figures
from vibroscope.app.page.updates import SessionLoop, UpdateChannel
from vibroscope.app.runtime.compilation import compilation
from vibroscope.engine import CompileProgress
from vibroscope.engine.facts import sentence


def acts_of(session: "Session") -> Acts:
    """What ``session`` does with each message, first with its number; see `Component.listen`."""
    return {
        "move": (int, partial(setattr, session, "move")),
        "painted": (object, session.painted),
        "set": (dict, session.set),
        "scene": (str, session.choose),
        "undo": (object, lambda _: session.undo()),
        "redo": (object, lambda _: session.redo()),
        "reset": (object, lambda _: session.reset()),
        "pin": (object, lambda on: session.pin(bool(on))),
        "unpin": (int, session.unpin),
        "theme": (str, session.choose_theme),
        "view": (str, session.open),
        "take": (str, session.take),
    }


# Moves of the same control within so many seconds count as one move, so that a drag is undone as a whole.
_SAME_MOVE = 0.8  # s


class History:
    """The settings before the present one, and those that were undone."""

    def __init__(self) -> None:
        self._past: deque[Setting] = deque(maxlen=200)
        self._undone: list[Setting] = []
        self._last_move: tuple[frozenset[str], float] = (frozenset(), -math.inf)

    @property
    def can_undo(self) -> bool:
        """Whether there is a setting to go back to."""
        return bool(self._past)

    @property
    def can_redo(self) -> bool:
        """Whether there is an undone setting."""
        return bool(self._undone)

    def add(self, before: Setting, after: Setting, now: float) -> None:
        """Add the user's move from ``before`` to ``after`` at the time ``now`` (s)."""
        names = frozenset(name for name in FIELDS if getattr(before, name) != getattr(after, name))
        if not names:
            return
        last_names, last_time = self._last_move
        if not (self._past and names == last_names and now - last_time < _SAME_MOVE):
            self._past.append(before)
        self._last_move = names, now
        self._undone.clear()

    def undo(self, current: Setting) -> Setting | None:
        """The setting before the last move, or None."""
        return self._step(self._past, self._undone, current)

    def redo(self, current: Setting) -> Setting | None:
        """The setting that was undone last, or None."""
        return self._step(self._undone, self._past, current)

    def _step(self, source: deque | list, target: deque | list, current: Setting) -> Setting | None:
        self._last_move = frozenset(), -math.inf
        if not source:
            return None
        target.append(current)
        return source.pop()


_OWN_SETTING = (
    "No scene, but a setting of your own: the findings say whether its motion is real, and what to change first."
)
_NOT_SHOWN = "This could not be shown. The fault is the server's, and it has been noted."


class Session:
    """Holds the setting of one session; for the views it is the `app.page.tab.TabHost`."""

    view_titles: ClassVar = {key: view.title for key, view in VIEWS.items()}

    def __init__(self, query: str = "") -> None:
        self.doc = pn.state.curdoc
        self.code = ""  # that the tab Your code has chosen
        self.move = 0  # the browser's number of its last move
        self._wanted = ""  # the view that was asked for last
        self._refused: dict[str, str] = {}
        self._history = History()
        self._loop = SessionLoop(self.doc)
        self.call_later = self._loop.call_later
        self._updates = UpdateChannel(self.doc, self._send_answer)
        self.push, self.painted = self._updates.push, self._updates.painted
        self._address = Address(self, self._update_address)
        opening, error = self._address.open(query)
        self.setting, self.pinned = opening.setting, opening.pinned
        self.controls = Controls()
        tabs = [[tab.title, [[view.key, view.title] for view in tab.views]] for tab in TABS]
        self.header = Header(tabs, theme=opening.theme, error=error, note=opening.note)
        self._take_away = TakeAway(self, self.header.send_file)
        for component in (self.controls, self.header):
            component.listen(**acts_of(self))
        self.header.listen(**Upload(self._begin_file, self.load, LARGEST_FILE).acts)
        self.tab_area = TabArea(self, self._address.check_soon)
        self._open_view(opening.view, opening.state)
        self._follow_compilation()
        self._updates.answer(self.move)
        self._waits_for_page = not self.tab_area.view.show_if_ready(Move(self.move, self.setting))

    def start(self) -> None:
        """The page is open: show what had to wait for it."""
        self._loop.start()
        if self._waits_for_page:
            self._show()

    def close(self) -> None:
        """The browser is gone."""
        self._loop.close()
        self.tab_area.close()

    # -- from the browser, see `app.page.session` ------------------------------------

    def set(self, texts: Mapping[str, object], *, fresh: bool = False) -> None:
        """Accept all of ``texts``, also typed ones (`plain_texts`), and show the new setting, or say why not."""
        before = self.setting
        try:
            self.setting = read_setting(entered(plain_texts(texts, before), before), before)
        except Refused as error:
            error.log()
            self._refused = {"name": error.name, "text": str(error)}
            self._updates.answer(self.move)
            return
        self._history.add(before, self.setting, time.monotonic())
        self._show_move(fresh)

    def choose(self, key: str) -> None:
        """Set a scene or a system of the shelf; all axes return to its data, also for the same one."""
        if key in presets():
            self.set(presets()[key].texts(), fresh=True)

    def undo(self) -> None:
        """Return to the setting before the last move, if there is one."""
        self.setting = self._history.undo(self.setting) or self.setting
        self._show_move()

    def redo(self) -> None:
        """Return to the setting that was undone last, if there is one."""
        self.setting = self._history.redo(self.setting) or self.setting
        self._show_move()

    def reset(self) -> None:
        """Return to the opening scene, without pins and without a code."""
        self.pinned, self.code = (), ""
        self.tab_area.reset()
        self.set(opening_setting().texts(), fresh=True)

    def pin(self, on: bool) -> None:
        """Pin the present setting, or unpin it."""
        others = tuple(pinned for pinned in self.pinned if not self._shows(pinned))
        if on and len(others) == MOST_PINS:
            self.report_error(f"At most {MOST_PINS} settings can be pinned: unpin one of them first.")
            return
        self.pinned = (*others, self.setting) if on else others
        self._show()

    def unpin(self, place: int) -> None:
        """Unpin one of the pinned settings, by its place among them."""
        self.pinned = tuple(pinned for i, pinned in enumerate(self.pinned) if i != place)
        self._show()

    def _shows(self, pinned: Setting) -> bool:
        """Whether a pinned setting is the present one, however it is drawn."""
        return pinned.drawn_like(self.setting) == self.setting

    def choose_theme(self, theme: str) -> None:
        """Note the theme that the user has chosen, for the address; the browser applies it."""
        if theme in THEMES:
            self._address.theme = theme
            self._address.check_soon()

    def open(self, key: str) -> None:
        """Open a view."""
        if key in VIEWS:
            self._when_open(key, self._show)

    def visit(self, key: str, texts: Mapping[str, str], prepare: Callable[[TabView], None] | None = None) -> None:
        """Open a view, prepared by ``prepare``, with some parameters set; see `app.page.tab.TabHost`."""
        self._when_open(key, partial(self._visit, texts, prepare))

    def _visit(self, texts: Mapping[str, str], prepare: Callable[[TabView], None] | None) -> None:
        if prepare is not None:
            prepare(self.tab_area.view)
        if texts:
            self.set(texts)
        if not texts or self._refused:
            self._show()

    def take(self, asked: str) -> None:
        """Send a file that the user wants to take away: its name in `take_away.file_writer`, "?", and its options."""
        view = self.tab_area.view
        view.prepare(asked.partition("?")[0], partial(self._take, asked, view))
        self.update_offers()

    def _take(self, asked: str, view: TabView) -> None:
        address = f"?{self._address.link(view, view.shown_setting() or self.setting)}"
        self._take_away.request(asked, view, self.setting, address)

    def load(self, content: bytes) -> None:
        """Set the parameters of an uploaded file; the whole file is accepted, or nothing of it."""
        self._take_away.load(content, self._loaded)

    def _begin_file(self, name: str, size: float) -> None:
        if size > LARGEST_FILE:
            self.report_error(f"This file is larger than {LARGEST_FILE} bytes, so it is no parameter file.")

    def _loaded(self, read: Future) -> None:
        try:
            loaded = read.result()
            read_setting(loaded.texts, self.setting)
        except ValueError as error:
            self.report_error(f"The file was not accepted: {error}")
        else:
            self.set(loaded.texts)
            if loaded.assumed and not self._refused:
                self.header.note = " ".join(["The file was loaded.", *map(sentence, loaded.assumed)])

    # -- the solvers, on a first start -------------------------------------------------

    def _follow_compilation(self) -> None:
        self._show_compilation(compilation.progress)
        compilation.watch(lambda progress: self.call_later(partial(self._show_compilation, progress)))

    def _show_compilation(self, progress: CompileProgress | None) -> None:
        self.header.compiling = {} if progress is None else progress._asdict()

    # -- to the open view --------------------------------------------------------------

    def _when_open(self, key: str, then: Callable[[], None]) -> None:
        """Open a view, then call ``then``; one that has never been open is built in a thread first.

        Nothing is done if another view was asked for before it could be built.
        """
        self._wanted = key
        if self.tab_area.has(key):
            self._open_view(key)
            then()
        else:
            self.add_models(*(partial(self._if_wanted, key, act) for act in (partial(self._open_view, key), then)))

    def _if_wanted(self, key: str, act: Callable[[], None]) -> None:
        if key == self._wanted:
            act()

    def _open_view(self, key: str, state: View | None = None) -> None:
        self.tab_area.open(key, state)
        self.header.view = key
        self.update_offers()
        kind = VIEWS[key]
        self.controls.param.update(visible=kind.controls, starts=kind.starts, motions=kind.motions)
        self.summarise(self.tab_area.view.summary(self.setting))

    def _show_move(self, fresh: bool = False) -> None:
        self._refused = {}
        self.header.param.update(error="", note="")
        self._address.frozen = False
        self._show(fresh)

    def _show(self, fresh: bool = False) -> None:
        self._waits_for_page = False
        self.tab_area.view.show(Move(self.move, self.setting, fresh))

    # -- to the browser, see `app.page.tab.TabHost` ------------------------------------

    def add_models(self, add: Callable[[], None], then: Callable[[], None]) -> None:
        """Change the page in a thread, then call ``then``."""
        self._loop.add_models(add, then, partial(self.report_error, _NOT_SHOWN))

    def report_error(self, text: str, move: int | None = None) -> None:
        """Show an error; ``move`` is the move that it answers, None the last one."""
        self.header.error = text
        self._updates.answer(self.move if move is None else move)

    def summarise(self, text: str) -> None:
        """Give screen readers a summary of the open view."""
        self.header.summary = f"{self.tab_area.view.title}. {text}"

    def update_offers(self) -> None:
        """Figures to take away have come or gone."""
        offers = offered_figures(self.tab_area.view)
        awaited = self.tab_area.view.awaited()
        if (offers, awaited) != (self.header.offers, self.header.awaited):
            self.header.param.update(offers=offers, awaited=awaited)

    def _update_address(self) -> None:
        """Send the address if the view has changed it; this answers no move."""
        if self._current_address() != self.controls.shown["address"]:
            self._updates.answer()

    def _current_address(self) -> str:
        return self._address.current(self.tab_area.view, self.setting)

    def _send_answer(self, move: int, update: int) -> None:
        """Tell the browser the accepted setting, and that ``move`` is dealt with."""
        self.update_offers()
        scene = preset_of(self.setting)
        caption = scene.caption if scene else _OWN_SETTING
        if not VIEWS[self.header.view].motions:
            caption = ""
        self.header.param.update(caption=caption, look=scene.look if scene else "")
        self.controls.show_setting(
            self.setting,
            move=move,
            update=update,
            address=self._current_address(),
            refused=self._refused,
            undo=self._history.can_undo,
            redo=self._history.can_redo,
            pinned=any(map(self._shows, self.pinned)),
        )
