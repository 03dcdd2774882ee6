"""Axis ranges that the page sets: they change little while sliders move, and keep the zoom of the user.

A range is fitted to the data when a scene is chosen, when data leave it, or when they fill less than `_FILL` of it. One
that was fitted to data still being computed is fitted once more when they are complete, so that the result does not
depend on the speed of the computation. A range that the user has zoomed stays as it is until the reset tool or a scene
returns it to the data.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable

import numpy as np
from bokeh.models import Range1d

_FILL = 0.5
_MARGIN = 0.07


def extent(columns: Iterable[np.ndarray]) -> tuple[float, float] | None:
    """Smallest and largest finite value of all columns, or None."""
    values = [c[np.isfinite(c)] for c in columns]
    values = [c for c in values if len(c)]
    if not values:
        return None
    return float(min(c.min() for c in values)), float(max(c.max() for c in values))


def fitted_range(
    now: tuple[float, float],
    data: tuple[float, float],
    *,
    fresh: bool,
    headroom: float = _MARGIN,
) -> tuple[float, float] | None:
    """The range for ``data``, or None if the range ``now`` is still good; ``fresh``: fit it in any case."""
    low, high = data
    span = max(high - low, 1e-3 * max(abs(low), abs(high)), 1e-9)
    # Growing data may use up the margin, but not the space for a legend.
    inside = now[0] <= low and high + max(0.0, headroom - 2 * _MARGIN) * span <= now[1]
    filled = span >= _FILL * (now[1] - now[0])
    if inside and filled and not fresh:
        return None
    return low - _MARGIN * span, high + headroom * span


class OwnedRange:
    """A Bokeh range, and where the page last put it."""

    def __init__(self, low: float, high: float, *, headroom: float = _MARGIN) -> None:
        self.range = Range1d(low, high, reset_start=low, reset_end=high)
        self._headroom = headroom  # free space above the data for a legend, relative to their span
        self._put = self._ends = (low, high)
        self._restored = False
        self._provisional = False  # fitted to data that were not complete
        self.on_put: list[Callable[[], None]] = []  # called when the page has moved the range, or its home
        self.on_move: Callable[[], None] = lambda: None  # called when an end has moved
        for end in ("start", "end"):
            self.range.on_change(end, self._moved)

    @property
    def home(self) -> tuple[float, float]:
        """The ends where the page last put the range."""
        return self._put

    @property
    def ends(self) -> tuple[float, float]:
        """The present ends; kept here because each update reads them, and reading Bokeh's properties is slow."""
        return self._ends

    @property
    def zoomed(self) -> bool:
        """Whether the user, or a link, has moved the range since."""
        return self.ends != self._put

    def _set(self, low: float, high: float) -> None:
        self._ends = low, high  # now: while a document holds its events, it also holds their callbacks
        self.range.update(start=low, end=high)
        self._tell()

    def _tell(self) -> None:
        for act in self.on_put:
            act()

    def _moved(self, attr: str, old: float, new: float) -> None:
        self._ends = self.range.start, self.range.end
        self.on_move()

    def follow(
        self,
        columns: Iterable[np.ndarray],
        *,
        fresh: bool = False,
        complete: bool = True,
        always: Iterable[float] = (),
    ) -> None:
        """Fit the range to the data by the rule above.

        Parameters
        ----------
        columns
            The data.
        fresh
            Whether a scene was chosen.
        complete
            Whether the data are all computed.
        always
            Values that are always in view.
        """
        data = extent(columns)
        if data is None:
            self._provisional |= fresh
            return
        data = min(data[0], *always, data[1]), max(data[1], *always, data[0])
        refit = fresh or (complete and self._provisional)
        new = fitted_range(self._put, data, fresh=refit, headroom=self._headroom)
        if new:
            self._provisional = not complete
        self.put(*(new or self._put), fresh=fresh)

    def put(self, low: float, high: float, *, fresh: bool = False) -> None:
        """Put the range here: the reset tool returns to it, and the range moves there unless it is zoomed.

        ``fresh`` ends a zoom, except one that a link has just set.
        """
        stays = self.zoomed and (self._restored or not fresh)
        self._restored = False
        if (low, high) == self._put and (stays or not self.zoomed):
            return
        self._put = (low, high)
        self.range.update(reset_start=low, reset_end=high)
        if stays:
            self._tell()
        else:
            self._set(low, high)

    def restore(self, low: float, high: float) -> None:
        """Zoom to the ends that a link gives, before there are data."""
        self._restored = True
        self._set(low, high)

    def unzoom(self) -> None:
        """End the zoom, whether of the user or of a link."""
        self._restored = False
        self.put(*self._put, fresh=True)
