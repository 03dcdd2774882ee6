"""The figures of Explore as tables, and what they show in words for the menu and the report. No panel import."""

from __future__ import annotations

from collections.abc import Mapping

from vibroscope.app.explorer.present import Columns, quantity_of
from vibroscope.app.export.formats import Figure, Series
from vibroscope.engine import Units

FIGURES = {
    figure.name: figure
    for figure in (
        Figure("mechanism", "Pendulums", "The pendulums at one phase, the penalty solution outlined.", tabled=False),
        Figure("phase1", "Phase plot 1", "Phase plot of pendulum 1 with its Poincaré section (τ ≡ 0 mod T)."),
        Figure("phase2", "Phase plot 2", "Phase plot of pendulum 2 with its Poincaré section."),
        Figure("displacement", "Displacements", "Displacements over the last two excitation periods."),
        Figure("strip", "Contact strip", "Intervals in contact; an impact of the reference has no length."),
        Figure("force", "Contact force", "Contact force, and the impulse of each impact."),
        Figure("diagram", "Map over η", "Bifurcation diagram of the reference; the line marks η."),
        Figure("front", "Suggestion", "Error over steps a period of the settings found; the line marks the tolerance."),
    )
}
DIFFERENCE = Figure("displacement", "Difference in parts", "Penalty less reference over two periods, in parts.")

_LONG = {"t": "time", "total": "difference"}  # columns of the difference, as a file calls them
_SOLVERS = ("reference", "penalty")
# The series of each figure: what a row is called, the source, and its columns under the names the file gives them.
_SERIES: dict[str, list[tuple[str, str, dict[str, str]]]] = {
    "displacement": [(s, "displacements", {"time": "t", "xi1": f"{s}1", "xi2": f"{s}2"}) for s in _SOLVERS],
    "strip": [(s, f"strip_{s}", {"contact_begin": "left", "contact_end": "right"}) for s in _SOLVERS],
    "force": [
        *((s, f"force_{s}", {"time": "t", "force": "force"}) for s in _SOLVERS),
        *((f"{s} impulse", f"impulse_{s}", {"time": "t", "impulse": "impulse"}) for s in _SOLVERS),
    ],
} | {
    f"phase{n}": [
        (f"{s}{kind}", f"{source}_{s}", {f"xi{n}": f"x{n}", f"velocity{n}": f"v{n}"})
        for source, kind in (("phase", ""), ("section", " section"))
        for s in _SOLVERS
    ]
    for n in (1, 2)
}


def table_of(figure: str, columns: Mapping[str, Columns], scale: Units | None = None) -> list[Series]:
    """The data of one figure, a series for each curve.

    Times are counted from the beginning of the last two excitation periods, in periods. With a ``scale``, which the
    columns must be in already, their names say the unit of each.
    """
    return [
        Series(label, {named(name, column, scale): columns[source][column] for name, column in chosen.items()})
        for label, source, chosen in _SERIES[figure]
    ]


def difference_of(columns: Columns, coordinate: str, scale: Units | None = None) -> list[Series]:
    """The data of `DIFFERENCE`, as `table_of` gives those of a figure."""
    return [Series(coordinate, {named(_LONG.get(n, n), n, scale): column for n, column in columns.items()})]


def named(name: str, column: str, scale: Units | None) -> str:
    """What a file calls a column of a source."""
    quantity = quantity_of(column)
    return f"{name} [{scale.unit(quantity)}]" if scale and quantity else name
