"""What Explore shows without a figure of Bokeh, as files draw it: the bodies, and what a search has found.

Of the bodies these are the shapes that `bodies.js` has drawn, the penalty solution as an outline.
"""

from collections.abc import Iterator, Sequence

import numpy as np
from vibroscope.app.export.drawing import Call, Drawing
from vibroscope.app.page.shared.figure import BLUE, INK, VERMILLION, file_colour, file_style

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


_FRONT = (360, 200)  # px


def front_drawing(front: dict[str, list[float]], tolerance: float, *, dark: bool) -> Drawing:
    """Error over steps of the settings that a search has found, and the tolerance."""
    ink, blue = (file_colour(colour, dark=dark) for colour in (INK, BLUE))
    line = {"linewidth": 1.0}
    points = np.array(front["steps"], float), np.array(front["error"], float)
    calls = [
        Call("axes", "plot", points, line | {"color": blue, "marker": "o", "label": "settings found"}),
        Call("axes", "axhline", (tolerance,), line | {"color": ink, "linestyle": "--", "label": "tolerance"}),
        Call("axes", "set_xscale", ("log",)),
        Call("axes", "set_yscale", ("log",)),
    ]
    labels = {"x": "steps per period T/Δτ", "y": "error"}
    return Drawing(_FRONT, "Suggestion", labels, calls, file_style(dark=dark))
