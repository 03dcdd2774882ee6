"""Axis ranges that the page sets: they change little while sliders move, and keep the zoom of the user.

A range follows from the data alone, so that a link shows what was seen where it was taken: its ends are those of the
data and a margin, moved outwards to the next of some places, and stay there while the data change little. A range that
the user has zoomed stays as it is until the reset tool or a scene returns it to the data.

An axis that shows its data in other units than those they are drawn in.

Ranges, zooms in links, taps and questions of studies stay in the numbers of the model. The axis and its grid lines
belong to a second range, which is that of the data times a factor. The tools of the browser move both in proportion.
"""

import math
from collections.abc import Callable, Iterable

import numpy as np
from bokeh.models import LinearScale, LogScale, Range1d
from bokeh.plotting import figure
from vibroscope.app.explorer.link import rounded_span

MARGIN = 0.07  # free space beside the data, relative to their span
_PLACES = 8  # for an end, in the span of the data, at least


def extent(columns: Iterable[np.ndarray]) -> tuple[float, float] | None:
    """Smallest and largest finite value of all columns, or None."""
    values = [c[np.isfinite(c)] for c in columns]
    values = [c for c in values if len(c)]
    if not values:
        return None
    return float(min(c.min() for c in values)), float(max(c.max() for c in values))


def fitted_range(data: tuple[float, float], headroom: float = MARGIN) -> tuple[float, float]:
    """The range for ``data``, with free space above them, relative to their span."""
    low, high = data
    span = max(high - low, 1e-3 * max(abs(low), abs(high)), 1e-9)
    step = 2.0 ** math.floor(math.log2(span / _PLACES))
    return step * math.floor((low - MARGIN * span) / step), step * math.ceil((high + headroom * span) / step)


class OwnedRange:
    """A Bokeh range, and where the page last put it."""

    def __init__(self, low: float, high: float, *, headroom: float = MARGIN) -> None:
        self.range = Range1d(low, high, reset_start=low, reset_end=high)
        self._headroom = headroom  # free space above the data for a legend, relative to their span
        self._put = self._ends = self._set_to = self._empty = (low, high)
        self._restored = False
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
        """The present ends, those of a mouse rounded as `rounded_span` does: a link holds them exactly.

        They are kept here because each update reads them, and reading Bokeh's properties is slow.
        """
        return self._ends

    @property
    def zoomed(self) -> bool:
        """Whether the user, or a link, has moved the range since."""
        return self.ends != self._put

    def _set(self, low: float, high: float) -> None:
        self._ends = self._set_to = low, high  # now: while a document holds its events, it also holds their callbacks
        self.range.update(start=low, end=high)
        self._tell()

    def _tell(self) -> None:
        for act in self.on_put:
            act()

    def _moved(self, attr: str, old: float, new: float) -> None:
        ends = self.range.start, self.range.end
        self._ends = ends if ends in (self._set_to, self._put) else rounded_span(ends)
        self.on_move()

    def follow(
        self,
        columns: Iterable[np.ndarray],
        *,
        fresh: bool = False,
        always: Iterable[float] = (),
    ) -> None:
        """Fit the range to the data by the rule above; without data it is the first one.

        Parameters
        ----------
        columns
            The data.
        fresh
            Whether a scene was chosen: this ends a zoom, as in `put`.
        always
            Values that are always in view.
        """
        data = extent([*columns, np.array([*always], float)])
        if data is not None:
            self.put(*fitted_range(data, self._headroom), fresh=fresh)
        elif not self._restored:  # a link's zoom waits for data
            self.put(*self._empty)

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


_NAME = "units"


class UnitAxis:
    """The axis of an `OwnedRange` in some figures, horizontal (``"x"``) in all of them or vertical (``"y"``)."""

    def __init__(self, owned: OwnedRange, side: str, *plots: figure) -> None:
        self._owned, self._side, self._plots = owned, side, plots
        self._factor = 1.0
        self.label = ""
        self.range = Range1d(*owned.ends)
        for plot in plots:
            is_log = isinstance(getattr(plot, f"{side}_scale"), LogScale)
            getattr(plot, f"extra_{side}_ranges")[_NAME] = self.range
            getattr(plot, f"extra_{side}_scales")[_NAME] = LogScale() if is_log else LinearScale()
        owned.on_put.append(self._follow)

    def show(self, label: str, factor: float) -> None:
        """Show the data times ``factor``, with this label."""
        self.label = label
        name = "default" if factor == 1 else _NAME
        if factor != self._factor:
            self._factor = factor
            self._follow()
        for plot in self._plots:
            (axis,), (grid,) = (getattr(plot, f"{self._side}{kind}") for kind in ("axis", "grid"))
            axis.axis_label = label
            for part in (axis, grid):
                part.update(**{f"{self._side}_range_name": name})

    def _follow(self) -> None:
        """The page has moved the range; what the user does to it, the browser does to both."""
        (low, high), home = self._owned.ends, self._owned.home
        ends = {"start": low, "end": high, "reset_start": home[0], "reset_end": home[1]}
        self.range.update(**{name: self._factor * end for name, end in ends.items()})
