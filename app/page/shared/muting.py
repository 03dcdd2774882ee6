"""Legend entries that a user mutes: which they are, by figure and name."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence

from bokeh.plotting import figure


class Muting:
    """The entries of some figures' legends; ``names`` gives those of each figure in the order of its legend."""

    def __init__(self, names: Mapping[str, Sequence[str]], figures: Iterable[figure]) -> None:
        self.on_mute: Callable[[], None] = lambda: None  # called whenever an entry is muted, or no longer
        self._entries = {
            (plot.name, name): item.renderers
            for plot in figures
            if plot.name in names
            for name, item in zip(names[plot.name], plot.legend[0].items, strict=True)
        }
        self._muted: set[tuple[str, str]] = set()  # remembered, since each update of the page asks
        for entry, renderers in self._entries.items():
            # All of an entry are muted together: the first tells of it.
            renderers[0].on_change("muted", lambda attr, old, new, entry=entry: self._heard(entry, new))

    @property
    def muted(self) -> dict[str, list[str]]:
        """Names of the muted entries by figure, in their order."""
        found: dict[str, list[str]] = {}
        for plot, name in self._entries if self._muted else ():
            if (plot, name) in self._muted:
                found.setdefault(plot, []).append(name)
        return found

    def mute(self, muted: Mapping[str, Sequence[str]]) -> None:
        """Mute these, as a link says."""
        for plot, names in muted.items():
            for renderer in (renderer for name in names for renderer in self._entries[plot, name]):
                renderer.muted = True

    def _heard(self, entry: tuple[str, str], muted: bool) -> None:
        (self._muted.add if muted else self._muted.discard)(entry)
        self.on_mute()
