"""Axis ranges that the page owns: calm while sliders move, and never taken from a user who zoomed.

Rule: a range follows the data when a scene is chosen, when data leave it, or when
they fill less than `_FILL` of it. One that was fitted to data still being computed
is fitted once more when they are complete, so that it tells nothing of how fast they
came. A range that the user has changed (it no longer stands where it was put) stays
as it is until the reset tool or a scene gives it back.
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


def wanted(
    now: tuple[float, float],
    data: tuple[float, float],
    *,
    fresh: bool,
    headroom: float = _MARGIN,
) -> tuple[float, float] | None:
    """The range that ``data`` call for, or None where the present one still serves."""
    low, high = data
    span = max(high - low, 1e-3 * max(abs(low), abs(high)), 1e-9)
    # The margin is spent slowly, yet what is kept free for a legend stays free.
    inside = now[0] <= low and high + max(0.0, headroom - 2 * _MARGIN) * span <= now[1]
    filled = span >= _FILL * (now[1] - now[0])
    if inside and filled and not fresh:
        return None
    return low - _MARGIN * span, high + headroom * span


class OwnedRange:
    """A Bokeh range with the memory of where the page last put it."""

    def __init__(self, low: float, high: float, *, headroom: float = _MARGIN) -> None:
        self.range = Range1d(low, high, reset_start=low, reset_end=high)
        self._headroom = headroom  # share of the span left free above the data, for a legend
        self._put = self._ends = (low, high)
        self._restored = False
        self._provisional = False  # fitted to data that were not complete
        self.on_move: Callable[[], None] = lambda: None  # called whenever an end has moved
        for end in ("start", "end"):
            self.range.on_change(end, self._moved)

    @property
    def home(self) -> tuple[float, float]:
        """Where the page last put the range."""
        return self._put

    @property
    def ends(self) -> tuple[float, float]:
        """Where the range stands: remembered, since each update of the page asks, and Bokeh is slow to tell."""
        return self._ends

    @property
    def zoomed(self) -> bool:
        """Whether the user has moved the range since."""
        return self.ends != self._put

    def _go(self, low: float, high: float) -> None:
        self._ends = low, high  # at once: while a document holds its events, it also holds what they call
        self.range.update(start=low, end=high)

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
        """Adjust to the data by the rule above; the values in ``always`` are kept in view whatever the data."""
        data = extent(columns)
        if data is None:
            self._provisional |= fresh
            return
        data = min(data[0], *always, data[1]), max(data[1], *always, data[0])
        anew = fresh or (complete and self._provisional)
        new = wanted(self._put, data, fresh=anew, headroom=self._headroom)
        if new:
            self._provisional = not complete
        self.put(*(new or self._put), fresh=fresh)

    def put(self, low: float, high: float, *, fresh: bool = False) -> None:
        """The page has the range here: the reset tool returns to it, and the range itself goes there if nobody zoomed.

        A ``fresh`` start takes a zoom back, but not one that a link has only just brought.
        """
        stays = self.zoomed and (self._restored or not fresh)
        self._restored = False
        if (low, high) == self._put and (stays or not self.zoomed):
            return
        self._put = (low, high)
        self.range.update(reset_start=low, reset_end=high)
        if not stays:
            self._go(low, high)

    def restore(self, low: float, high: float) -> None:
        """Zoom as a link says, before there are data."""
        self._restored = True
        self._go(low, high)

    def back(self) -> None:
        """Take the zoom back, whoever it is from."""
        self._restored = False
        self.put(*self._put, fresh=True)
