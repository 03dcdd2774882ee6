"""The bodies at one instant as a file shows them: the reference filled, the penalty solution as an outline over it.

Places and sizes are those of `bodies.js`, in px, as complex numbers: downwards from the top is the imaginary part.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence

import numpy as np
from vibroscope.app.explorer.drawing import drawing
from vibroscope.app.explorer.present import WINDOW, unit_factor
from vibroscope.app.explorer.state import Setting
from vibroscope.app.export.drawing import Call, Drawing
from vibroscope.app.page.shared.figure import BLUE, INK, VERMILLION, file_colour, file_style

_WIDE, _HIGH, _LOW = 260.0, 190.0, 46.0
_PIVOT, _ROD, _BOB = 26.0, 136.0, 15.0
_FLOOR, _POST, _EDGE, _WALL = 132.0, 6.0, 10.0, 14.0
_SIDES = (22.0, 44.0)
_REACH = {"pendulums": 92.0, "two": 46.0, "wall": 60.0}
_CIRCLE = np.exp(1j * np.linspace(0, 2 * np.pi, 72, endpoint=False))


def body_drawing(setting: Setting, columns: Mapping[str, np.ndarray], time: float, *, dark: bool) -> Drawing:
    """The system and both solutions.

    Parameters
    ----------
    setting : Setting
    columns : mapping of str to ndarray
        The displacements that are drawn: ``reference1``, ``penalty2`` and so on, over two periods.
    time : float
        In periods, from 0 to `WINDOW`.
    dark : bool
        Whether it has the colours of the dark page.
    """
    bodies, low = _Bodies(setting, columns, time), 0.0 if setting.bodies == "pendulums" else _LOW
    ends = {"set_xlim": (0.0, _WIDE), "set_ylim": (_HIGH, low), "set_aspect": ("equal",), "set_axis_off": ()}
    calls = [*bodies.draw(dark), *(Call("axes", name, given) for name, given in ends.items())]
    return Drawing((_WIDE, _HIGH - low), "", {}, calls, file_style(dark=dark))


class _Bodies:
    """Lengths in px at an instant."""

    def __init__(self, setting: Setting, columns: Mapping[str, np.ndarray], time: float) -> None:
        system, factor = drawing(setting), unit_factor("displacement", setting)
        self.kind, self.share, count = system["kind"], system["share"], 1 if system["kind"] == "wall" else 2
        second = system["clearance2"]
        play = math.inf if second is None else factor * (system["clearance"] + second)
        base = factor * system["base"]
        rest = factor * np.array(_rest_places(system))
        gap = factor * system["clearance"] + rest[1] - rest[0]
        names = {solver: [f"{solver}{body}" for body in (1, 2)][:count] for solver in ("reference", "penalty")}
        moved = {s: np.array([columns[each] for each in known]) - rest[:count, None] for s, known in names.items()}
        reach = max([abs(base), *(np.nanmax(abs(each)) for each in moved.values() if np.isfinite(each).any())])
        shown = abs(base) if setting.frame == "absolute" else 0.0
        scale = _REACH[self.kind] / (reach + shown + (play if play < math.inf else gap / 2) + abs(base) or 1.0)
        now = base * math.cos(2 * math.pi * time + system["phase"])
        self.shift, self.half, self.play = now * scale, gap * scale / 2, play * scale
        self.places = {
            solver: scale * (each[:, round(time / WINDOW * (each.shape[1] - 1))] - (now if shown else 0.0))
            for solver, each in moved.items()
        }
        room = abs(base) * scale + _EDGE
        self.ends = room + self.shift, _WIDE - room - (_WALL if count == 1 else 0.0) + self.shift
        mass = system["mass"]
        self.sides = [np.clip(_SIDES[1] * np.cbrt(each), *_SIDES) for each in (min(1, 1 / mass), min(1, mass))]

    def draw(self, dark: bool) -> Iterator[Call]:
        """All shapes."""
        ink, line, paper = (file_colour(colour, dark=dark) for colour in (INK, "#C6CDD4", "#FFFFFF"))
        hung = self.kind == "pendulums"
        height = _PIVOT - 20 if hung else _FLOOR + 14
        yield _path([[4 + 1j * height, _WIDE - 4 + 1j * height]], line, 1.5)
        left, right = self.ends
        if hung:
            out, middle = self.half + _BOB, _WIDE / 2 + self.shift
            plate = max(70.0, out + 12)
            yield _shape(_rect(middle - plate, _PIVOT - 16, 2 * plate, 10), facecolor=line)
            yield from (_shape(middle + x + 1j * _PIVOT + 3.5 * _CIRCLE, facecolor=ink) for x in (-out, out))
        else:
            yield _shape(_rect(left - _POST, _FLOOR, right - left + 2 * _POST, 6), facecolor=line)
            yield _path([*_hatched(left, _FLOOR, -1), *_hatched(right, _FLOOR, 1)], ink, 1)
        for solver, colour, filled in (("reference", BLUE, True), ("penalty", VERMILLION, False)):
            if np.isfinite(self.places[solver]).all():
                own = file_colour(colour, dark=dark)
                outlines, springs, stop = (self._hang if hung else self._slide)(self.places[solver])
                yield _path(springs[0 if self.share else 1 :], own, 1.8 if filled else 1)
                if self.play < math.inf:
                    yield _path(stop, ink if filled else own, 1.2)
                for number, outline in enumerate(outlines, 1):
                    yield _shape(outline, facecolor=own if filled else "none", edgecolor=own, linewidth=1.6)
                    at = outline.mean()
                    look = {"color": paper, "ha": "center", "va": "center", "weight": "bold", "zorder": 4}
                    yield from [Call("axes", "text", (float(at.real), float(at.imag), str(number)), look)] * filled

    def _hang(self, places: np.ndarray) -> tuple[list, list, list]:
        """Outlines of the bodies, lines of their rods, and of the second stop."""
        pivots = _WIDE / 2 + self.shift + (self.half + _BOB) * np.array([-1, 1]) + 1j * _PIVOT
        one, two = bobs = pivots + places + 1j * np.sqrt(np.maximum(_ROD**2 - places**2, 0.0))
        top, stop = two - 1j * _BOB, two.real - 3 * _BOB - self.play
        hook = [top, top - 7j, stop + 1j * (top.imag - 7), stop + 1j * (one.imag + _BOB)]
        return [bob + _BOB * _CIRCLE for bob in bobs], list(zip(pivots, bobs, strict=True)), [hook]

    def _slide(self, places: np.ndarray) -> tuple[list, list, list]:
        """The same of bodies on a floor: body 1 ends at its right face, body 2, or the wall, begins at its left one."""
        walled = len(places) == 1
        middle = self.ends[1] - self.half if walled else _WIDE / 2 + self.shift
        faces = middle - self.half + places[0], middle + self.half + (0.0 if walled else places[1])
        (one, two), (begin, end) = self.sides, self.ends
        outlines = [_rect(faces[0] - one, _FLOOR - one, one, one), _rect(faces[1], _FLOOR - two, two, two)]
        springs = [_spring(begin, faces[0] - one), _spring(faces[1] + two, end)]
        stop, low, high = faces[1] - self.play - one, 1j * (_FLOOR - 14), 1j * (_FLOOR - _SIDES[1] - 6)
        hook = [faces[1] + two / 2 + 1j * (_FLOOR - two), faces[1] + two / 2 + high, stop + high, stop + low]
        return outlines[: len(places)], springs[: len(places)], _hatched(stop, low.imag, -1) if walled else [hook]


def _rest_places(system: Mapping) -> tuple[float, float]:
    """Where the bodies rest: of an overlap of the relaxed springs at either stop, each takes up its share."""
    clearance, second, (one, two) = system["clearance"], system["clearance2"], system["separate"]
    gap = clearance + two - one
    held = min(max(gap, 0.0), math.inf if second is None else clearance + second)
    if gap == held:
        return one, two
    first = clearance - held if system["kind"] == "wall" else one + system["share"] * (gap - held)
    return first, 0.0 if system["kind"] == "wall" else first - clearance + held


def _rect(x: float, y: float, wide: float, high: float) -> np.ndarray:
    return x + 1j * y + np.array([0, wide, wide + 1j * high, 1j * high])


def _spring(begin: float, end: float) -> np.ndarray:
    x = [begin, *np.linspace(begin + 5, end - 5, 13), end]
    return np.array(x) + 1j * (np.array([0, 0, *[-6, 0, 6, 0] * 3, 0]) + _FLOOR - _SIDES[0] / 2)


def _hatched(x: float, bottom: float, out: int) -> list[list[complex]]:
    """A wall whose hatch lies on the side ``out``."""
    top = _FLOOR - 56
    hatch = ([x + 1j * y, x + 7 * out + 1j * (y - 7)] for y in np.arange(top + 6, bottom + 1, 9.0))
    return [[x + 1j * top, x + 1j * bottom], *hatch]


def _path(lines: Sequence[Sequence[complex]], colour: str, width: float) -> Call:
    """Some lines of one look."""
    points = np.concatenate([[*line, complex(np.nan, np.nan)] for line in lines])
    return Call("axes", "plot", (points.real, points.imag), {"color": colour, "linewidth": width})


def _shape(outline: np.ndarray, **look: object) -> Call:
    return Call("axes", "fill", (outline.real, outline.imag), {"zorder": 3, **look})
