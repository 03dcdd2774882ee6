"""What a tab is, and what it may ask of the page.

A tab costs nothing until it is opened: then it is built, once, and shown. While it is hidden it is told of no move and
sends nothing; when it is opened again it gets the setting that holds by then.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from typing import ClassVar, NamedTuple, Protocol

import panel as pn
from bokeh.document import Document
from vibroscope.app.explorer.link import Span, View, print_choice, print_mute, print_zoom, read_view
from vibroscope.app.explorer.state import Setting
from vibroscope.app.export.formats import Figure, Series
from vibroscope.app.export.scripts import as_command, as_python
from vibroscope.app.page.shared.muting import Muting
from vibroscope.app.page.shared.ranges import OwnedRange

COMPUTING = "Computing."


class Move(NamedTuple):
    """A setting to show, and the browser's number of the move that led to it."""

    number: int
    setting: Setting
    fresh: bool = False  # a scene was chosen: ranges that a user has zoomed are given back


class Desk(Protocol):
    """The page, as its tabs see it."""

    doc: Document

    def set(self, texts: Mapping[str, str]) -> None:
        """Set some of the numbers, as if the user had typed them; a bad one is refused in words on the page."""

    def push(self, move: int, write: Callable[[], None]) -> None:
        """Call ``write`` when the browser is free, unless something newer comes; it writes into models in place.

        Every move that a tab is shown must end in a push (or in `tell`), or the page would go on saying "computing".
        """

    def later(self, callback: Callable[[], None]) -> None:
        """From a worker thread: call ``callback`` on the session's own loop, if the session is still there."""

    def tell(self, error: str, move: int | None = None) -> None:
        """Show an error, in words and with the way out; ``move`` is the move that it answers."""

    def summarise(self, text: str) -> None:
        """Say what the open tab shows, after its title, for those who cannot see it."""

    def offer(self) -> None:
        """What can be taken away has changed, without a push."""

    @property
    def pinned(self) -> Setting | None:
        """The setting that the user keeps to compare with."""


class Tab(ABC):
    """One tab of one session."""

    key: ClassVar[str]  # in the address, ?tab=key
    title: ClassVar[str]
    controls: ClassVar[bool] = True  # whether the sliders stand beside it
    motions: ClassVar[bool] = False  # whether it draws motions, as the panel of the sliders says how
    axes: ClassVar[Mapping[str, Span]] = {}  # that a link may zoom, and what their ends may be
    legends: ClassVar[Mapping[str, Sequence[str]]] = {}  # by figure: names of the entries, in their order, for a link

    def __init__(self, desk: Desk) -> None:
        self.desk = desk
        self.ranges: dict[str, OwnedRange] = {}  # of ``axes``, once it is built
        self.muting = Muting({}, [])  # of ``legends``, once it is built

    @abstractmethod
    def build(self) -> pn.viewable.Viewable:
        """What is to be seen; called once, when the tab is opened for the first time, before the first `show`."""

    def at_once(self, move: Move) -> bool:
        """Show ``move`` while the page is being made, if that costs nothing; False: `show` follows once it is open."""
        self.show(move)
        return True

    def show(self, move: Move) -> None:
        """The tab is open and ``move`` holds. Here: a tab that depends on nothing that is set."""
        self.desk.push(move.number, lambda: None)

    @abstractmethod
    def summary(self, setting: Setting) -> str:
        """What it holds of ``setting``, or that it computes: for those who cannot see it, told as it is opened."""

    # -- how it is seen: see `app.explorer.link` --------------------------------------

    @classmethod
    def spec(cls) -> dict:
        """What can be chosen: ``switches`` (name, label, choices) and ``limits`` (name, label, low, high)."""
        return {}

    @classmethod
    def read_view(cls, zoom: str, choice: str, mute: str) -> View:
        """The view that an address holds, before the tab is built; raises `Refused`."""
        return read_view(zoom, choice, mute, cls.axes, cls.spec(), cls.legends)

    def restore(self, view: View) -> None:
        """See it so; called after `build`, before the first `show`."""
        for name, ends in view.zoom.items():
            self.ranges[name].restore(*ends)
        self.muting.mute(view.mute)

    def choice(self) -> dict[str, str | int]:
        """What is not chosen as at first."""
        return {}

    def printed(self) -> dict[str, str]:
        """The view as the address holds it: the fields of `app.explorer.link.View`."""
        zoom = {name: owned.ends for name, owned in self.ranges.items() if owned.zoomed}
        return {
            "zoom": print_zoom(zoom, self.axes),
            "choice": print_choice(self.choice()),
            "mute": print_mute(self.muting.muted),
        }

    def unzoom(self) -> None:
        """Take every zoom back."""
        for owned in self.ranges.values():
            owned.back()

    # -- what can be taken away: see `app.page.taking` -----------------------

    def figures(self) -> list[Figure]:
        """What the tab shows by now and has data of."""
        return []

    def table(self, name: str) -> list[Series]:
        """The data of one of its `figures`."""
        raise KeyError(name)

    def data(self) -> dict[str, object]:
        """The data of all of them: numbers, words, arrays, and dictionaries of those."""
        return {}

    def words(self) -> dict[str, str]:
        """What the figures say, by headings."""
        return {}

    def shown(self) -> Setting | None:
        """The setting that the figures are of; None where they are of none."""
        return None

    def python(self, setting: Setting) -> str:
        """A script that finds the same."""
        return as_python(setting)

    def command(self, setting: Setting) -> str:
        """Commands that find the same."""
        return as_command(setting)

    # -- shown or not --------------------------------------------------------

    def hide(self) -> None:  # noqa: B027 - most tabs have nothing to stop
        """Another tab was opened: stop what runs."""

    def close(self) -> None:
        """The session has ended."""
        self.hide()
