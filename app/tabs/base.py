"""What a tab is, and what it may ask of the page.

A tab costs nothing until it is opened: then it is built, once, and shown. While it is hidden it is told of no move and
sends nothing; when it is opened again it gets the setting that holds by then.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from typing import ClassVar, NamedTuple, Protocol

import panel as pn
from bokeh.document import Document

from app.state import Setting


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
        """Say what the figures show, for those who cannot see them."""

    @property
    def pinned(self) -> Setting | None:
        """The setting that the user keeps to compare with."""


class Tab(ABC):
    """One tab of one session."""

    key: ClassVar[str]  # in the address, ?tab=key
    title: ClassVar[str]
    controls: ClassVar[bool] = True  # whether the sliders stand beside it

    def __init__(self, desk: Desk) -> None:
        self.desk = desk

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

    def hide(self) -> None:  # noqa: B027 - most tabs have nothing to stop
        """Another tab was opened: stop what runs."""

    def close(self) -> None:
        """The session has ended."""
        self.hide()

    def take(self, what: str) -> dict | None:
        """A file to take away (``name``, ``type``, ``text``) of what the tab shows, or None if there is none."""
        return None
