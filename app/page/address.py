"""The address of the open page: what it asks for when the page is opened, and how it follows the page afterwards."""

from collections.abc import Callable
from typing import NamedTuple

from vibroscope.app.explorer.errors import Refused
from vibroscope.app.explorer.link import View, idle_numbers, parse_address, print_address, read_pins
from vibroscope.app.explorer.parameters import FIELDS
from vibroscope.app.explorer.presets import opening_setting
from vibroscope.app.explorer.reading import read_choice, read_setting
from vibroscope.app.explorer.state import Setting
from vibroscope.app.page.tab import TabHost, TabView
from vibroscope.app.page.tabs import FIRST_VIEW, VIEWS
from vibroscope.app.runtime.number_text import quote

THEMES = ["light", "dark"]
_REST = 150  # ms without another zoom or mute before the address follows


class Opening(NamedTuple):
    """The content of an address: the setting, the open view and its state, the pinned settings, the theme ("": none).

    ``note``: what of it has no effect, in a sentence; empty if nothing.
    """

    setting: Setting
    view: str = FIRST_VIEW
    state: View = View()
    pinned: tuple[Setting, ...] = ()
    theme: str = ""
    note: str = ""


def read_opening(query: str) -> Opening:
    """Read a query string; raises `Refused` at the first fault."""
    texts = parse_address(query)
    view = texts.pop("view", FIRST_VIEW)
    if view not in VIEWS:
        raise Refused("view", f"There is no view {quote(view)}: it is one of {', '.join(VIEWS)}.")
    state = VIEWS[view].read_view(*(texts.pop(name, "") for name in View._fields))
    pin, theme = texts.pop("pin", ""), texts.pop("theme", "")
    pinned = read_pins(pin)
    # A link leaves out the defaults, but a page without any parameter opens with a scene.
    setting = read_setting(texts) if texts.keys() & set(FIELDS) or pin else opening_setting()
    theme = theme and read_choice("theme", theme, THEMES)
    return Opening(setting, view, state, pinned, theme, idle_numbers(texts, setting))


class Address:
    """Prints the address of one session's page.

    Attributes
    ----------
    theme : str
        Light or dark, where the user or the link has chosen.
    frozen : bool
        Whether the address stays as it is, because the link that the page was opened with was refused.
    """

    def __init__(self, host: TabHost, on_view_change: Callable[[], None]) -> None:
        """``on_view_change`` is called a moment after the user has changed the view without a move."""
        self.theme = ""
        self.frozen = False
        self._host = host
        self._on_view_change = on_view_change
        self._check_is_due = False

    def open(self, query: str) -> tuple[Opening, str]:
        """Read a query string: its opening and an empty text or, if refused, the opening scene and the reason."""
        try:
            opening = read_opening(query)
        except Refused as error:
            error.log()
            self.frozen = True
            return Opening(opening_setting()), f"{error} The link was not accepted, so this is the opening scene."
        self.theme = opening.theme
        return opening, ""

    def link(self, view: TabView, setting: Setting) -> str:
        """The address that restores a view as it is, with ``setting``."""
        return self._print(view, setting, view.view_texts())

    def current(self, view: TabView, setting: Setting) -> str:
        """The address for the browser to show; empty if it stays as it is."""
        state = view.view_texts()
        return "" if self.frozen and not any(state.values()) else self._print(view, setting, state)

    def check_soon(self) -> None:
        """The view changes: check the address when that comes to rest, since a wheel sends many changes."""
        if not self._check_is_due:
            self._check_is_due = True
            self._host.doc.add_timeout_callback(self._check, _REST)

    def _check(self) -> None:
        self._check_is_due = False
        self._host.call_later(self._on_view_change)

    def _print(self, view: TabView, setting: Setting, state: dict[str, str]) -> str:
        key = "" if view.key == FIRST_VIEW else view.key
        return print_address(setting, key, self._host.pinned, **state, theme=self.theme)
