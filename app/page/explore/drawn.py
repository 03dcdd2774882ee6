"""The figures of Explore as they are drawn, for files: which there are, and their columns."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from vibroscope.app.explorer.measured import Placed
from vibroscope.app.export.drawing import Call, Drawing
from vibroscope.app.export.formats import Figure, Series
from vibroscope.app.export.tables import DIFFERENCE, FIGURES, columns_in_units, difference_table, figure_table
from vibroscope.app.page.explore.alone import NUMBERS, AloneView
from vibroscope.app.page.explore.body_drawing import body_drawing
from vibroscope.app.page.explore.comparison import PinComparison
from vibroscope.app.page.explore.displacement import DisplacementView
from vibroscope.app.page.explore.eta_map import EtaMapView
from vibroscope.app.page.explore.result import Result
from vibroscope.app.page.explore.suggest import Suggester
from vibroscope.app.page.shared.figure import BLUE, INK, file_colour, file_style
from vibroscope.app.page.tab import Look

_SINGLE = {"diagram": "reference", "front": "found", "comparison": "compared"}  # figures with one series: its label
_FRONT = (360, 200)  # px


class DrawnFigures:
    """Figures, tables and columns of a result, taken from the parts of the tab that draw them."""

    def __init__(
        self,
        displacement: DisplacementView,
        comparison: PinComparison,
        suggester: Suggester,
        eta_map: EtaMapView,
        alone: AloneView,
    ) -> None:
        self._displacement, self._comparison = displacement, comparison
        self._suggester, self._eta_map, self._alone = suggester, eta_map, alone

    def figures(self, result: Result) -> list[Figure]:
        """All figures; the map once it is loaded, a suggestion and curves over numbers once they are found."""
        figures = FIGURES | ({"displacement": DIFFERENCE} if _draws_difference(result) else {})
        ready = {"diagram": self._eta_map.ready, "front": bool(self._suggester.front)}
        ready |= {f"alone_{number}": number in self._alone.numbers for number in NUMBERS}
        ready |= {"comparison": bool(self._comparison.rows), "phase2": not _at_wall(result)}
        return [figure for figure in figures.values() if ready.get(figure.name, True)]

    def table(self, name: str, result: Result, placed: Placed) -> list[Series]:
        """The columns of a figure, in the units of the setting."""
        setting, columns = result.setting, self.data(result, placed)
        if name.startswith("alone_"):
            return self._alone.table(name.removeprefix("alone_"))
        if name in _SINGLE:
            return [Series(_SINGLE[name], columns[name])]
        if name == "displacement" and _draws_difference(result):
            return difference_table(columns["difference"], setting.coordinate, setting.scale)
        return figure_table(name, columns, setting.scale, located=setting.located == "yes", wall=_at_wall(result))

    def drawing(self, name: str, result: Result, look: Look) -> Callable[[], Drawing] | None:
        """A function that gives a figure that the page draws without Bokeh; None for others."""
        if name == "mechanism":
            return lambda: body_drawing(look.bodies, dark=look.dark)
        front, tolerance = self._suggester.front, self._suggester.tolerance
        return (lambda: _front(front, tolerance, look)) if name == "front" else None

    def data(self, result: Result, placed: Placed) -> dict[str, object]:
        """The columns of all sources, of the difference, the map, a suggestion and a measurement."""
        scale, front = result.setting.scale, self._suggester.front
        more = {"difference": dict(self._displacement.difference.data)} if _draws_difference(result) else {}
        more |= {"front": front} if front else {}
        more |= {"comparison": columns_in_units(self._comparison.table, scale)} if self._comparison.rows else {}
        more |= {"alone": self._alone.facts} if self._alone.facts else {}
        more |= {"measured": placed._asdict()} if len(placed.phase["x1"]) else {}
        diagram = columns_in_units(self._eta_map.in_view(), scale)
        return {**result.columns, **more, "diagram": diagram}


def _front(front: dict[str, list[float]], tolerance: float, look: Look) -> Drawing:
    """Error over steps of the settings that were found, and the tolerance."""
    ink, blue = (file_colour(colour, dark=look.dark) for colour in (INK, BLUE))
    line = {"linewidth": 1.0}
    points = np.array(front["steps"], float), np.array(front["error"], float)
    calls = [
        Call("axes", "plot", points, line | {"color": blue, "marker": "o", "label": "settings found"}),
        Call("axes", "axhline", (tolerance,), line | {"color": ink, "linestyle": "--", "label": "tolerance"}),
        Call("axes", "set_xscale", ("log",)),
        Call("axes", "set_yscale", ("log",)),
    ]
    labels = {"x": "steps per period T/Δτ", "y": "error"}
    return Drawing(_FRONT, "Suggestion", labels, calls, file_style(dark=look.dark))


def _at_wall(result: Result) -> bool:
    return result.setting.bodies == "wall"


def _draws_difference(result: Result) -> bool:
    return result.setting.frame == "difference"
