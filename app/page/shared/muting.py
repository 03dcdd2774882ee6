"""Muted legend entries, by figure and name: their curves are hidden."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import partial

from bokeh.plotting import figure

_Entry = tuple[str, str]  # names of a figure and of an entry of its legend


class Muting:
    """Muted entries of some figures' legends; ``names`` gives the entries of each figure in the order of its legend.

    The curves of an entry are visible while it is in the legend and not muted; the browser hides them at a click.
    """

    def __init__(self, names: Mapping[str, Sequence[str]], figures: Iterable[figure]) -> None:
        self.on_mute: Callable[[], None] = lambda: None  # called when the user mutes or unmutes an entry
        self._items = {
            (plot.name, name): item
            for plot in figures
            if plot.name in names
            for name, item in zip(names[plot.name], plot.legend[0].items, strict=True)
        }
        self._muted: set[_Entry] = set()
        for entry, item in self._items.items():
            # The browser hides all curves of an entry together, so it is enough to observe the first.
            item.renderers[0].on_change("visible", partial(self._changed, entry))
            item.on_change("visible", lambda attr, old, new, entry=entry: self._draw(entry))
            self._draw(entry)

    @property
    def muted(self) -> dict[str, list[str]]:
        """Names of the muted entries by figure, in the order of the legend."""
        found: dict[str, list[str]] = {}
        for plot, name in self._items if self._muted else ():
            if (plot, name) in self._muted:
                found.setdefault(plot, []).append(name)
        return found

    def mute(self, muted: Mapping[str, Sequence[str]]) -> None:
        """Mute the entries that a link names, by figure."""
        entries = {(plot, name) for plot, names in muted.items() for name in names}
        self._muted |= entries
        for entry in entries:
            self._draw(entry)

    def _draw(self, entry: _Entry) -> None:
        item = self._items[entry]
        for renderer in item.renderers:
            renderer.visible = item.visible and entry not in self._muted

    def _changed(self, entry: _Entry, attr: str, old: bool, visible: bool) -> None:
        # What `_draw` changes is of an entry that is not in the legend, or agrees with what is known.
        if not self._items[entry].visible or visible != (entry in self._muted):
            return
        (self._muted.discard if visible else self._muted.add)(entry)
        self.on_mute()
