"""Muted legend entries, by figure and name: their curves are hidden."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import partial

from bokeh.models import LegendItem
from bokeh.plotting import figure

_Entry = tuple[str, str]  # names of a figure and of an entry of its legend


class Muting:
    """Muted entries of some figures' legends; ``names`` gives the entries of each figure in the order of its legend.

    The curves of an entry are visible while it is in the legend and not muted; the browser hides them at a click.
    """

    def __init__(self, names: Mapping[str, Sequence[str]], figures: Iterable[figure]) -> None:
        self.on_mute: Callable[[], None] = lambda: None  # called when the user mutes or unmutes an entry
        self._names = names
        self._items: dict[_Entry, LegendItem] = {}
        self._muted: set[_Entry] = set()
        for plot in figures:
            # The last entries of a legend may be added later.
            for name, item in zip(names.get(plot.name, ()), plot.legend[0].items if plot.legend else (), strict=False):
                self.watch(plot.name, name, item)

    def watch(self, plot: str, name: str, item: LegendItem) -> None:
        """Mute this entry of the legend of a figure, too."""
        entry = (plot, name)
        self._items[entry] = item
        # The browser hides all curves of an entry together, so it is enough to observe the first.
        item.renderers[0].on_change("visible", partial(self._changed, entry))
        item.on_change("visible", lambda attr, old, new: self._draw(entry))
        self._draw(entry)

    @property
    def muted(self) -> dict[str, list[str]]:
        """Names of the muted entries by figure, in the order of the legend."""
        found = {plot: [name for name in names if (plot, name) in self._muted] for plot, names in self._names.items()}
        return {plot: names for plot, names in found.items() if names}

    def mute(self, muted: Mapping[str, Sequence[str]]) -> None:
        """Mute the entries that a link names, by figure."""
        entries = {(plot, name) for plot, names in muted.items() for name in names}
        self._muted |= entries
        for entry in entries:
            self._draw(entry)

    def _draw(self, entry: _Entry) -> None:
        item = self._items.get(entry)
        for renderer in item.renderers if item else ():
            renderer.visible = item.visible and entry not in self._muted

    def _changed(self, entry: _Entry, attr: str, old: bool, visible: bool) -> None:
        # Changes by `_draw` itself: the entry is not in the legend, or its state is already known.
        if not self._items[entry].visible or visible != (entry in self._muted):
            return
        (self._muted.discard if visible else self._muted.add)(entry)
        self.on_mute()
