"""Muted legend entries, by figure and name."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence

from bokeh.plotting import figure


class Muting:
    """Muted entries of some figures' legends; ``names`` gives the entries of each figure in the order of its legend."""

    def __init__(self, names: Mapping[str, Sequence[str]], figures: Iterable[figure]) -> None:
        self.on_mute: Callable[[], None] = lambda: None  # called when an entry is muted or unmuted
        self._entries = {
            (plot.name, name): item.renderers
            for plot in figures
            if plot.name in names
            for name, item in zip(names[plot.name], plot.legend[0].items, strict=True)
        }
        self._muted: set[tuple[str, str]] = set()  # kept here because each update of the page reads them
        for entry, renderers in self._entries.items():
            # All renderers of an entry are muted together, so it is enough to observe the first.
            renderers[0].on_change("muted", lambda attr, old, new, entry=entry: self._changed(entry, new))

    @property
    def muted(self) -> dict[str, list[str]]:
        """Names of the muted entries by figure, in the order of the legend."""
        found: dict[str, list[str]] = {}
        for plot, name in self._entries if self._muted else ():
            if (plot, name) in self._muted:
                found.setdefault(plot, []).append(name)
        return found

    def mute(self, muted: Mapping[str, Sequence[str]]) -> None:
        """Mute the entries that a link names, by figure."""
        for plot, names in muted.items():
            for renderer in (renderer for name in names for renderer in self._entries[plot, name]):
                renderer.muted = True

    def _changed(self, entry: tuple[str, str], muted: bool) -> None:
        (self._muted.add if muted else self._muted.discard)(entry)
        self.on_mute()
