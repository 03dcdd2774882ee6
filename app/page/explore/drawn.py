"""The figures of Explore as they are drawn, for files: which there are, and their columns."""

from __future__ import annotations

from vibroscope.app.explorer.measured import Placed
from vibroscope.app.export.formats import Figure, Series
from vibroscope.app.export.tables import (
    DIFFERENCE,
    FIGURES,
    columns_in_units,
    difference_table,
    figure_table,
    measured_table,
    without_body_2,
)
from vibroscope.app.page.explore.alone import NUMBERS, AloneView
from vibroscope.app.page.explore.comparison import PinComparison
from vibroscope.app.page.explore.displacement import DisplacementView
from vibroscope.app.page.explore.eta_map import EtaMapView
from vibroscope.app.page.explore.result import Result
from vibroscope.app.page.explore.suggest import Suggester

_SERIES_LABELS = {"diagram": "reference", "front": "found", "comparison": "compared"}  # of figures with one series


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
        if name in _SERIES_LABELS:
            return [Series(_SERIES_LABELS[name], columns[name])]
        if name == "displacement" and _draws_difference(result):
            return difference_table(columns["difference"], setting.coordinate, setting.scale)
        drawn = figure_table(name, columns, setting.scale, located=setting.located == "yes")
        drawn += measured_table(name, columns, setting.scale)
        return without_body_2(drawn) if _at_wall(result) else drawn

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


def _at_wall(result: Result) -> bool:
    return result.setting.bodies == "wall"


def _draws_difference(result: Result) -> bool:
    return result.setting.frame == "difference"
