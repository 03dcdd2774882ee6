"""What the address asks for when the page is opened: read as a whole, before anything of it is applied."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

from vibroscope.app.explorer.link import View
from vibroscope.app.explorer.state import (
    Explorer,
    Refused,
    Setting,
    check_together,
    parse_address,
    quoted,
    read,
    read_choice,
)
from vibroscope.app.page.tabs import TABS

FIRST = next(iter(TABS))
THEMES = ["light", "dark"]


class Opening(NamedTuple):
    """Texts of the setting, the tab that is open and how it is seen, what is pinned, and the theme or none."""

    texts: Mapping[str, str] = {}
    tab: str = FIRST
    view: View = View()
    pinned: Setting | None = None
    theme: str = ""


def read_opening(query: str) -> Opening:
    """What a query string asks for; raises `Refused` at the first fault. The texts are still to be checked."""
    texts = parse_address(query)
    tab = _known_tab(texts.pop("tab", FIRST))
    view = TABS[tab].read_view(*(texts.pop(name, "") for name in View._fields))
    pin, theme = texts.pop("pin", ""), texts.pop("theme", "")
    pinned = _setting_of(pin) if pin else None
    return Opening(texts, tab, view, pinned, theme and read_choice("theme", theme, THEMES))


def _known_tab(key: str) -> str:
    if key not in TABS:
        raise Refused("tab", f"There is no tab {quoted(key)}: it is one of {', '.join(TABS)}.")
    return key


def _setting_of(query: str) -> Setting:
    """The setting that an address holds, on top of the defaults."""
    setting = Explorer().setting()._replace(**read(parse_address(query)))
    check_together(setting)
    return setting
