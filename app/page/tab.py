"""The base class of a view of a tab, and what it may ask of the page.

A view costs nothing until it is opened: then it is built, once, in a thread, and shown. While it is hidden it gets no
moves and sends nothing; when it is opened again it gets the setting that holds by then.
"""

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from typing import ClassVar, NamedTuple, Protocol

import panel as pn
from bokeh.document import Document
from vibroscope.app.explorer.link import Span, View, ViewChoice, print_choice, print_mute, print_zoom, read_view
from vibroscope.app.explorer.state import Setting
from vibroscope.app.export.drawing import Drawing
from vibroscope.app.export.formats import Figure, Series
from vibroscope.app.export.scripts import as_command, as_python
from vibroscope.app.page.shared.declared import Key, declared
from vibroscope.app.page.shared.muting import Muting
from vibroscope.app.page.shared.ranges import OwnedRange
from vibroscope.app.runtime.job import Job

COMPUTING = "Computing."


class Move(NamedTuple):
    """A setting to show, and the browser's number of the move that led to it."""

    number: int
    setting: Setting
    fresh: bool = False  # a scene was chosen: zoomed axes return to the data


class Look(NamedTuple):
    """How the browser shows the figures: whether the page is dark, and the outlines of the bodies (`bodies.js`)."""

    dark: bool = False
    bodies: str = ""


class TabHost(Protocol):
    """The page, as the views of its tabs use it."""

    doc: Document
    view_titles: Mapping[str, str]  # by key
    code: str  # key of the code that the tab Your code has chosen; empty before

    def set(self, texts: Mapping[str, str]) -> None:
        """Set some parameters as if the user had typed them; the page shows why a bad value is refused."""

    def visit(self, key: str, texts: Mapping[str, str], prepare: "Callable[[TabView], None] | None" = None) -> None:
        """Open another view with some parameters set; ``prepare`` is called with it before it is shown."""

    def push(self, move: int, write: Callable[[], None], follow: Callable[[], None] = ...) -> None:
        """Call ``write`` when the browser is free, unless a newer push replaces it; it changes models in place.

        ``follow`` is called then, too: what it changes is sent after the rest, which the browser paints meanwhile.
        Every move that a view is shown must end in a push or in `report_error`, or the page would say "computing" for
        ever.
        """

    def call_later(self, callback: Callable[[], None]) -> None:
        """Call ``callback`` on the session's own loop, from any thread, if the session still exists."""

    def add_models(self, add: Callable[[], None], then: Callable[[], None]) -> None:
        """Call ``add`` in a thread, then ``then`` on the session's own loop.

        Whatever adds models to the page that is open belongs into ``add``: Bokeh walks over all models of the page and
        serialises the new ones, which takes longer than others should wait.
        """

    def report_error(self, text: str, move: int | None = None) -> None:
        """Show an error with the way out of it; ``move`` is the move that it answers, None the last one."""

    def summarise(self, text: str) -> None:
        """Give screen readers a summary of the open view; its title is put before it."""

    def update_offers(self) -> None:
        """Figures to take away have come or gone, without a push."""

    @property
    def pinned(self) -> tuple[Setting, ...]:
        """The settings that the user has pinned, to compare others with."""


def on_loop(host: TabHost, take: Callable[[Job, object], None]) -> Callable[[Job, object], None]:
    """For the worker thread of a job: ``take`` is called on the session's loop unless the job is cancelled by then."""

    def deliver(job: Job, result: object) -> None:
        host.call_later(lambda: None if job.cancelled else take(job, result))

    return deliver


class TabView(ABC):
    """One view of a tab, of one session."""

    key: ClassVar[str]  # in the address, ?view=key
    title: ClassVar[str]  # shown where its tab has others; in reports
    controls: ClassVar[bool] = True  # whether the sliders are shown beside it
    starts: ClassVar[bool] = False  # whether the start of the runs counts in it; the controls then offer its numbers
    motions: ClassVar[bool] = False  # whether it draws motions; the controls then offer how to draw them
    axes: ClassVar[Mapping[str, Span]] = {}  # that a link may zoom: limits of their ends
    legends: ClassVar[Mapping[str, Sequence[str]]] = {}  # by figure: names of the entries in a link, in their order
    choices: ClassVar[Sequence[ViewChoice]] = ()
    chosen: ClassVar[Mapping[str, str | float | None]] = {}  # at first, of the ``choices`` in both panel and link

    def __init_subclass__(cls, **options) -> None:
        super().__init_subclass__(**options)
        cls.chosen = {each.name: each.first for each in cls.choices if each.shown and each.linked}

    def __init__(self, host: TabHost) -> None:
        self.host = host
        self.ranges: dict[str, OwnedRange] = {}  # of ``axes``, once it is built
        self.muting = Muting({}, {})  # of ``legends``, once it is built

    @abstractmethod
    def build(self) -> pn.viewable.Viewable:
        """Make what is seen; called once, when the view is opened for the first time, before the first `show`."""

    def show_if_ready(self, move: Move) -> bool:
        """Show ``move`` while the page is built, if that costs nothing; otherwise `show` follows when it is open."""
        self.show(move)
        return True

    def show(self, move: Move) -> None:
        """Show ``move``; the view is open. Here: a view that does not depend on the setting."""
        self.host.push(move.number, lambda: None)

    @abstractmethod
    def summary(self, setting: Setting) -> str:
        """Summary of ``setting`` for screen readers, or that it is being computed; asked when the view is opened."""

    def hide(self) -> None:  # noqa: B027 - most have nothing to stop
        """Another view was opened: stop what runs."""

    def reset(self) -> None:  # noqa: B027 - most have nothing to return
        """The user has asked for the page as it is at first, also of a view that is not open."""

    def close(self) -> None:
        """The session has ended."""
        self.hide()

    # -- how it is viewed, see `app.explorer.link` ---------------------------------------------

    @classmethod
    def read_view(cls, zoom: str, choice: str, mute: str) -> View:
        """What an address holds of the view, before it is built; raises `Refused`."""
        return read_view(zoom, choice, mute, cls.axes, cls.choices, cls.legends)

    def restore(self, view: View) -> None:
        """Restore a view; called after `build`, before the first `show`."""
        for name, ends in view.zoom.items():
            self.ranges[name].restore(*ends)
        self.muting.mute(view.mute)

    def watch_view(self, on_change: Callable[[], None]) -> None:
        """Call ``on_change`` whenever the user changes the view without a move; called after `build`."""
        for owned in self.ranges.values():
            owned.on_move = on_change
        self.muting.on_mute = on_change

    def choice(self) -> dict[str, str | float]:
        """Choices other than the default."""
        return {}

    def view_texts(self) -> dict[str, str]:
        """The present view as texts for the address: the fields of `app.explorer.link.View`."""
        zoom = {name: owned.ends for name, owned in self.ranges.items() if owned.zoomed}
        return {
            "zoom": print_zoom(zoom, self.axes),
            "choice": print_choice(self.choice()),
            "mute": print_mute(self.muting.muted),
        }

    def unzoom(self) -> None:
        """Return every axis to its data."""
        for owned in self.ranges.values():
            owned.unzoom()

    # -- files to take away, see `app.page.take_away` -----------------------------------

    def figures(self) -> list[Figure]:
        """The figures that can be taken away: those that have data, or get them in `prepare`."""
        return []

    def prepare(self, what: str, take: Callable[[], None]) -> None:
        """Call ``take`` once all is computed that the file ``what`` of `app.page.take_away` holds; here: at once."""
        take()

    def awaited(self) -> str:
        """The computation that a requested file waits for, in words; empty if it waits for none."""
        return ""

    def table(self, name: str) -> list[Series]:
        """The data of one of the `figures`."""
        raise KeyError(name)

    def drawing(self, name: str, look: Look) -> Callable[[], Drawing]:
        """A function that gives one of the `figures` as it is on the page now; it may be called in another thread."""
        drawing = declared(self.host.doc.get_model_by_name(name), self.key_of(name), dark=look.dark)
        return lambda: drawing

    def key_of(self, name: str) -> Key:
        """The key of the colours of one of the `figures`; without rows where it has none."""
        return Key()

    def data(self) -> dict[str, object]:
        """The data of all figures: numbers, texts, arrays, and dictionaries of those."""
        return {}

    def suggestion(self) -> list[str]:
        """What to set instead, in sentences; empty where nothing was searched for."""
        return []

    def words(self) -> dict[str, str]:
        """The meaning of the figures: paragraphs by their headings."""
        return {}

    def shown_setting(self) -> Setting | None:
        """The setting that the figures are of; None if they are of none."""
        return None

    def python(self, setting: Setting) -> str:
        """A script that finds the same numbers."""
        return as_python(setting)

    def command(self, setting: Setting) -> str:
        """Commands that find the same numbers."""
        return as_command(setting)
