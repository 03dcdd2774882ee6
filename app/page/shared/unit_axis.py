"""An axis that shows its data in other units than those they are drawn in.

Ranges, zooms in links, taps and questions of studies stay in the numbers of the model. The axis and its grid lines
belong to a second range, which is that of the data times a factor. The tools of the browser move both in proportion.
"""

from __future__ import annotations

from bokeh.models import LinearScale, LogScale, Range1d
from bokeh.plotting import figure
from vibroscope.app.page.shared.ranges import OwnedRange

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
