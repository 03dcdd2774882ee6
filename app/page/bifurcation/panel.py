"""The choices beside a bifurcation diagram."""

from __future__ import annotations

from vibroscope.app.explorer.link import LINEAR
from vibroscope.app.explorer.parameters import FIELDS, START_FIELDS, bounds_of
from vibroscope.app.page.bifurcation.swept import SWEPT

DIRECTION_NAMES = {
    "rest": "from rest",
    "own": "from an own start",
    "up": "continued upwards",
    "down": "continued downwards",
}
_COORDINATES = {
    f"{letter}{number}": f"{words} {number}"
    for number in (1, 2)
    for letter, words in (("xi", "displacement"), ("v", "velocity"))
}
MOST_VALUES, MOST_TRANSIENT = 2000, 20_000  # that can be typed: with more, a diagram outlasts its time
_BRANCHES = {"off": "not shown", "on": "of the diagram", "both": "reference and penalty"}
_SOLVERS = {"reference": "reference", "exact": "exact penalty", "newmark": "penalty with a time step"}


def panel_spec() -> dict:
    """Switches, numbers, title and hint of the panel, and the line that can be dragged."""
    return {
        "title": "Bifurcation diagram",
        "aligned": ["bifurcation", "bifurcation_strip"],
        "switches": [
            {"name": "over", "label": "Swept", "choices": {name: swept.choice for name, swept in SWEPT.items()}},
            {"name": "solver", "label": "Solver", "choices": _SOLVERS},
            {"name": "direction", "label": "Start", "choices": DIRECTION_NAMES},
            {"name": "coordinate", "label": "Coordinate", "choices": _COORDINATES},
            {"name": "branches", "label": "Branches", "choices": _BRANCHES},
        ],
        "numbers": [
            _number("from", "From", LINEAR, linked=False),
            _number("to", "To", LINEAR, linked=False),
            _number("count", "Values", (2, MOST_VALUES), whole=True),
            _number("transient", "Transient (periods)", (0, MOST_TRANSIENT), whole=True),
            *(_number(name, FIELDS[name].label, bounds_of(name), when={"direction": "own"}) for name in START_FIELDS),
        ],
        "hint": "Drag the line, click, or use the slider to set the swept number. A zoom is computed anew at its "
        "own range. Hollow points are a periodic motion that the time step blurs. In grey, once computed: the other "
        "direction (motions coexist where they differ), or the reference. Branches are solid where they are "
        "stable, dashed where they are not; a click on one opens that motion in Explore.",
        "cursor": {
            "figure": "bifurcation",
            "span": "bifurcation_cursor",
            "label": "bifurcation_label",
            "by": "over",
            "swept": {
                name: {
                    "name": name,
                    "symbol": swept.symbol,
                    "low": swept.bounds[0],
                    "high": swept.bounds[1],
                    "parts": swept.parts,
                }
                for name, swept in SWEPT.items()
            },
        },
    }


def _number(name: str, label: str, bounds: tuple[float, float], *, whole: bool = False, **more) -> dict:
    return {"name": name, "label": label, "low": bounds[0], "high": bounds[1], "whole": whole, **more}
