"""Muted legend entries, by figure and name: their curves are hidden."""

from collections.abc import Callable, Mapping, Sequence
from functools import partial

from bokeh.models import LegendItem

_Entry = tuple[str, str]  # names of a figure and of an entry of its legend
_MUTED = "muted"  # a tag of an entry


def show_entry(item: LegendItem, shown: bool) -> None:
    """Take an entry into its legend, or out of it. Its curves are drawn while it is in the legend and not muted.

    Nothing else may set ``visible`` of an entry: a callback that did the rest would not be called for what Python
    changes while it holds a document's events, or before the browser has the page.
    """
    item.visible = shown
    for renderer in item.renderers:
        renderer.visible = shown and _MUTED not in item.tags


class Muting:
    """Muted entries of some figures' legends; ``names`` gives the entries of each figure in the order of its legend.

    The browser hides the curves of an entry at a click, and shows them at the next. ``items`` are those that there are:
    others may come later, see `watch`.
    """

    def __init__(self, names: Mapping[str, Sequence[str]], items: Mapping[_Entry, LegendItem]) -> None:
        self.on_mute: Callable[[], None] = lambda: None  # called when the user mutes or unmutes an entry
        self._names = names
        self._linked: set[_Entry] = set()  # muted by a link before they were there
        self._items: dict[_Entry, LegendItem] = {}
        for (plot, name), item in items.items():
            self.watch(plot, name, item)

    def watch(self, plot: str, name: str, item: LegendItem) -> None:
        """Mute this entry of the legend of a figure, too."""
        self._items[plot, name] = item
        # The browser hides all curves of an entry together, so it is enough to observe the first.
        item.renderers[0].on_change("visible", partial(self._changed, item))
        self._mute(item, (plot, name) in self._linked)

    @property
    def muted(self) -> dict[str, list[str]]:
        """Names of the muted entries by figure, in the order of the legend."""
        muted = {entry for entry, item in self._items.items() if _MUTED in item.tags}
        muted |= self._linked - self._items.keys()
        found = {plot: [name for name in names if (plot, name) in muted] for plot, names in self._names.items()}
        return {plot: names for plot, names in found.items() if names}

    def mute(self, muted: Mapping[str, Sequence[str]]) -> None:
        """Mute the entries that a link names, by figure."""
        self._linked = {(plot, name) for plot, names in muted.items() for name in names}
        for entry in self._linked & self._items.keys():
            self._mute(self._items[entry], True)

    def _mute(self, item: LegendItem, muted: bool) -> None:
        item.tags = [_MUTED] if muted else []
        show_entry(item, item.visible)

    def _changed(self, item: LegendItem, attr: str, old: bool, new: bool) -> None:
        muted = not item.renderers[0].visible
        # Not a click: `show_entry` has changed the entry, or its state is already known.
        if not item.visible or muted == (_MUTED in item.tags):
            return
        item.tags = [_MUTED] if muted else []
        self.on_mute()
