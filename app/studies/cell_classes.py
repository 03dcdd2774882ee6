"""Classes and colours of the cells of the K–D plane: few, so that the eye can distinguish them. No panel import.

Periods have the same colours in all figures of studies (after Okabe and Ito, Tol); other quantities go from dark to
light (cividis, which looks the same to the colour-blind). All colours stand in one palette that never changes, so that
only the numbers of the classes are sent.
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from vibroscope.app.studies.plane import PartialPlane
from vibroscope.engine import percent
from vibroscope.engine.motions.words import NOT_JUDGED
from vibroscope.engine.sweeps import CellKind

VEIL = "#F5F5F5"  # stripes over what lies below a limit: the classes there are the dark ones
# The first classes of the palette: colours that `theme.js` knows, in light and dark.
UNKNOWN, DIVERGED, NO_NUMBER = 0, 1, 2
SPECIAL = ("#F1F3F5", "#FFFFFF", "#C6CDD4")
_CIVIDIS = ("#00224E", "#35456C", "#666970", "#948E77", "#C8B866", "#FEE838")

PERIODS = (
    ("aperiodic", "#4D4D4D"),
    ("1", "#BBD7EE"),
    ("2", "#009E73"),
    ("3", "#E69F00"),
    ("4", "#CC79A7"),
    ("5 to 8", "#F0E442"),
    ("above 8", "#661100"),
)
PERIOD_EDGES = (1, 2, 3, 4, 5, 9)


# Kinds of motion that do not repeat themselves, as the strip of the bifurcation diagram shows them: name, colour.
KINDS = {
    CellKind.UNKNOWN: (NOT_JUDGED, "#C6CDD4"),
    CellKind.ARTEFACT: ("artefact of the time step", "#EFE7D3"),
    CellKind.QUASI_PERIODIC: ("quasi-periodic", "#56B4E9"),
    CellKind.CHAOTIC: ("chaotic", "#D55E00"),
    CellKind.UNDECIDED: ("kind not decided", PERIODS[0][1]),
    CellKind.ENDED_EARLY: ("ended early", "#FFFFFF"),
}


def period_class(period: np.ndarray) -> np.ndarray:
    """Index into `PERIODS`."""
    return np.digitize(period, PERIOD_EDGES)


class Colouring(NamedTuple):
    """One way to colour the plane: edges between the classes, their names and colours."""

    label: str
    edges: tuple[float, ...]
    classes: tuple[tuple[str, str], ...]
    read: Callable[[PartialPlane, str], np.ndarray]


def _graded(*names: str) -> tuple[tuple[str, str], ...]:
    return tuple(zip(names, _CIVIDIS, strict=False))


COLOURINGS = {
    "error": Colouring(
        "error against reference",
        (0.01, 0.03, 0.1, 0.3, 1.0),
        _graded("below 1 %", "1 to 3 %", "3 to 10 %", "10 to 30 %", "30 to 100 %", "above 100 %"),
        lambda plane, side: plane.shown(side, "error"),
    ),
    "period": Colouring("period", PERIOD_EDGES, PERIODS, lambda plane, side: plane.shown(side, "period")),
    "near_period": Colouring("period without blur", PERIOD_EDGES, PERIODS, PartialPlane.true_period),
    "contact": Colouring(
        "longest contact (steps)",
        (10, 30, 100, 300, 1000),
        _graded("below 10", "10 to 30", "30 to 100", "100 to 300", "300 to 1000", "above 1000"),
        PartialPlane.contact_steps,
    ),
    "impacts": Colouring(
        "impacts per period",
        (1e-9, 1 - 1e-6, 1 + 1e-6, 2 + 1e-6, 4 + 1e-6),
        _graded("none", "below 1", "1", "above 1, to 2", "above 2, to 4", "above 4"),
        lambda plane, side: plane.shown(side, "impacts_per_period"),
    ),
    "without_solution": Colouring(
        "steps without a solution",
        (1, 10, 100, 1000, 10000),
        _graded("none", "1 to 9", "10 to 99", "100 to 999", "1000 to 9999", "10000 and more"),
        PartialPlane.steps_without_solution,
    ),
}

PALETTE = [*SPECIAL, *(colour for _, colour in PERIODS), *_CIVIDIS]
_FIRST_PERIOD = len(SPECIAL)
_FIRST_OTHER = _FIRST_PERIOD + len(PERIODS)


def class_image(plane: PartialPlane, side: str, name: str) -> np.ndarray:
    """Index into `PALETTE` of each cell, (rows over D, columns over K) of uint8."""
    quantity = COLOURINGS[name]
    values = quantity.read(plane, side)
    first = _FIRST_PERIOD if quantity.classes is PERIODS else _FIRST_OTHER
    classes = np.where(np.isfinite(values), first + np.digitize(values, quantity.edges), NO_NUMBER)
    classes = np.where(plane.diverged(side), DIVERGED, classes)
    return np.where(np.isfinite(plane.shown(side, "status")), classes, UNKNOWN).astype(np.uint8)


def most_frequent(image: np.ndarray, name: str) -> str:
    """What the colours show, and their class that most of the known cells have."""
    colouring = COLOURINGS[name]
    first = _FIRST_PERIOD if colouring.classes is PERIODS else _FIRST_OTHER
    counts = np.bincount(image[image >= first].ravel() - first, minlength=len(colouring.classes))
    if not counts.any():
        return colouring.label
    share = percent(float(counts.max() / (image != UNKNOWN).sum()))
    return f"{colouring.label} {colouring.classes[int(counts.argmax())][0]} in {share} of the cells"


def class_of(value: float, name: str) -> int:
    """Index into `PALETTE` of one value of a graded colouring."""
    return _FIRST_OTHER + int(np.digitize(value, COLOURINGS[name].edges))


def sudden_contacts(plane: PartialPlane, side: str, limit: float) -> np.ndarray:
    """Whether the longest contact lasts fewer than ``limit`` steps, the paper's "one sudden impact": uint8, 0 or 1."""
    steps = plane.contact_steps(side)
    return (~plane.diverged(side) & (steps > 0) & (steps < limit)).astype(np.uint8)


def legend(name: str, limit: float | None = None) -> list[list[str]]:
    """Colour, name and pattern of each class, for the key beside the figures."""
    rows = [[colour, text, ""] for text, colour in COLOURINGS[name].classes]
    missing = {"error": "no number", "near_period": NOT_JUDGED, "without_solution": "no time step"}
    rows += [[SPECIAL[NO_NUMBER], missing[name], "missing"]] if name in missing else []
    rows += [[SPECIAL[DIVERGED], "blown up", "cross"]]
    rows += [[VEIL, f"fewer than {limit:g} steps in contact", "veil"]] if limit is not None else []
    return rows
