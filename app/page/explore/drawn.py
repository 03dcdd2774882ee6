"""The figures of Explore as they are drawn, for files: which there are, and their columns.

The bodies as a file shows them: the shapes that `bodies.js` has drawn, the penalty solution as an outline.
"""

from collections.abc import Callable, Iterator, Sequence

import numpy as np
from vibroscope.app.explorer.measured import Placed
from vibroscope.app.export.drawing import Call, Drawing
from vibroscope.app.export.formats import Figure, Series
from vibroscope.app.export.tables import DIFFERENCE, FIGURES, columns_in_units, difference_table, figure_table
from vibroscope.app.page.explore.alone import NUMBERS, AloneView
from vibroscope.app.page.explore.comparison import PinComparison
from vibroscope.app.page.explore.eta_map import EtaMapView
from vibroscope.app.page.explore.figures import MotionView
from vibroscope.app.page.explore.result import Result
from vibroscope.app.page.explore.suggest import Suggester
from vibroscope.app.page.shared.declared import declared
from vibroscope.app.page.shared.figure import BLUE, INK, VERMILLION, file_colour, file_style
from vibroscope.app.page.tab import Look

_EDGE = "#C6CDD4"
_LOOKS = {  # by owner and name: a line has a colour, an area one inside and perhaps one outside
    "base.rail": {"color": _EDGE, "linewidth": 1.5},
    "base.post": {"color": INK, "linewidth": 1.0},
    "base.plate": {"facecolor": _EDGE},
    "base.pivot": {"facecolor": INK},
    "reference.rod": {"color": BLUE, "linewidth": 1.8},
    "reference.stop": {"color": INK, "linewidth": 1.2},
    "reference.bob": {"facecolor": BLUE, "edgecolor": BLUE, "linewidth": 1.6},
    "penalty.rod": {"color": VERMILLION, "linewidth": 1.0},
    "penalty.stop": {"color": VERMILLION, "linewidth": 1.2},
    "penalty.bob": {"facecolor": None, "edgecolor": VERMILLION, "linewidth": 1.6},
}
_CIRCLE = np.exp(1j * np.linspace(0, 2 * np.pi, 72, endpoint=False))
_VIEW = (0.0, 0.0, 260.0, 190.0)  # px, where the browser says none
_FARTHEST = 1e3  # px: no shape of the page is farther away


def body_drawing(outlines: str, *, dark: bool) -> Drawing:
    """The system and both solutions.

    Parameters
    ----------
    outlines : str
        What the browser has drawn, as ``outlines`` of `bodies.js` writes it. What is none is left out.
    dark : bool
        Whether it has the colours of the dark page.
    """
    shapes = [(name, _numbers(texts)) for name, *texts in (text.split("_") for text in outlines.split("*"))]
    views = (numbers for name, numbers in shapes if name == "view" and len(numbers) == 4 and min(numbers[2:]) > 0)
    left, top, wide, high = next(views, _VIEW)
    ends = {"set_xlim": (left, left + wide), "set_ylim": (top + high, top)}
    ends |= {"set_aspect": ("equal",), "set_axis_off": ()}
    calls = [*_calls(shapes, dark), *(Call("axes", name, given) for name, given in ends.items())]
    return Drawing((wide, high), "", {}, calls, file_style(dark=dark))


def _numbers(texts: Sequence[str]) -> list[float]:
    """The numbers of a shape; none if they are none of the page's."""
    try:
        found = [float(text) for text in texts]
    except ValueError:
        return []
    return found if all(abs(number) < _FARTHEST for number in found) else []


def _calls(shapes: Sequence[tuple[str, list[float]]], dark: bool) -> Iterator[Call]:
    bodies = 0
    for name, numbers in shapes:
        if name not in _LOOKS or not (len(numbers) == 3 or (len(numbers) >= 4 and len(numbers) % 2 == 0)):
            continue
        if len(numbers) == 3:
            points = complex(*numbers[:2]) + numbers[2] * _CIRCLE
        else:
            points = np.array(numbers[::2]) + 1j * np.array(numbers[1::2])
        look = {key: file_colour(part, dark=dark) if "color" in key else part for key, part in _LOOKS[name].items()}
        line = "color" in look
        yield Call("axes", "plot" if line else "fill", (points.real, points.imag), look | {"zorder": 2 if line else 3})
        if name == "reference.bob":
            bodies += 1
            text = {"color": file_colour("#FFFFFF", dark=dark), "ha": "center", "va": "center", "weight": "bold"}
            at = float(points.real.mean()), float(points.imag.mean())
            yield Call("axes", "text", (*at, str(bodies)), text | {"zorder": 4})


_SINGLE = {"diagram": "reference", "front": "found", "comparison": "compared"}  # figures with one series: its label
_FRONT = (360, 200)  # px
_ALONE = "alone_"  # and the number that a curve is over


class DrawnFigures:
    """Figures, tables and columns of a result, taken from the parts of the tab that draw them."""

    def __init__(
        self,
        motion: MotionView,
        comparison: PinComparison,
        suggester: Suggester,
        eta_map: EtaMapView,
        alone: AloneView,
    ) -> None:
        self._motion, self._comparison = motion, comparison
        self._suggester, self._eta_map, self._alone = suggester, eta_map, alone

    def figures(self, result: Result) -> list[Figure]:
        """All figures; the map once it is loaded, a suggestion and curves over numbers once they are found."""
        figures = FIGURES | ({"displacement": DIFFERENCE} if _draws_difference(result) else {})
        ready = {"diagram": self._eta_map.ready, "front": bool(self._suggester.front)}
        ready |= {f"{_ALONE}{number}": number in self._alone.numbers for number in NUMBERS}
        ready |= {"comparison": bool(self._comparison.rows), "phase2": not _at_wall(result)}
        return [figure for figure in figures.values() if ready.get(figure.name, True)]

    def table(self, name: str, result: Result, placed: Placed) -> list[Series]:
        """The columns of a figure, in the units of the setting."""
        setting, columns = result.setting, self.data(result, placed)
        if name.startswith(_ALONE):
            return self._alone.table(name.removeprefix(_ALONE))
        if name in _SINGLE:
            return [Series(_SINGLE[name], columns[name])]
        if name == "displacement" and _draws_difference(result):
            return difference_table(columns["difference"], setting.coordinate, setting.scale)
        return figure_table(name, columns, setting.scale, located=setting.located == "yes", wall=_at_wall(result))

    def drawing(self, name: str, result: Result, look: Look) -> Callable[[], Drawing] | None:
        """A function that gives a figure that the page has not among its figures of Bokeh; None for others."""
        if name == "mechanism":
            return lambda: body_drawing(look.bodies, dark=look.dark)
        if name.startswith(_ALONE):
            alone = declared(self._alone.figures[name.removeprefix(_ALONE)], dark=look.dark)
            return lambda: alone
        front, tolerance = self._suggester.front, self._suggester.tolerance
        return (lambda: _front(front, tolerance, look)) if name == "front" else None

    def data(self, result: Result, placed: Placed) -> dict[str, object]:
        """The columns of all sources, of the difference, the map, a suggestion and a measurement."""
        scale, front = result.setting.scale, self._suggester.front
        more = {"difference": dict(self._motion.sources["difference"].data)} if _draws_difference(result) else {}
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
