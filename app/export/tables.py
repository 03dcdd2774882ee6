"""The figures of the tab Explore: their titles and captions, and their data as tables. No panel import."""

from collections.abc import Mapping

import numpy as np
from vibroscope.app.explorer.parameters import FIELD_QUANTITIES
from vibroscope.app.explorer.present import Columns, quantity_of
from vibroscope.app.explorer.state import SOLVERS
from vibroscope.app.export.formats import Figure, Series
from vibroscope.engine import Units

FIGURES = {
    figure.name: figure
    for figure in (
        Figure("mechanism", "Bodies", "The bodies at one phase, the penalty solution outlined.", tabled=False),
        Figure("phase1", "Phase plot 1", "Phase plot of body 1 with its Poincaré section (τ ≡ 0 mod T)."),
        Figure("phase2", "Phase plot 2", "Phase plot of body 2 with its Poincaré section."),
        Figure("displacement", "Displacements", "Displacements over the last two excitation periods."),
        Figure("strip", "Contact strip", "Intervals in contact; an impact of the reference has no length."),
        Figure("force", "Contact force", "Contact force, the mean of contacts too short to sample, and impulses."),
        Figure("diagram", "Map over η", "Bifurcation diagram of the reference; the line marks η."),
        Figure("alone_K", "Difference over K", "What is left of the difference if K alone is changed."),
        Figure("alone_D", "Difference over D", "What is left of the difference if D alone is changed."),
        Figure("alone_steps", "Difference over the step", "What is left of the difference with other time steps."),
        Figure("front", "Suggestion", "Error over steps per period of the settings found; the line is the tolerance."),
        Figure("comparison", "Comparison of pins", "The present setting, then the pinned ones.", drawn=False),
    )
}
DIFFERENCE = Figure("displacement", "Difference in parts", "Penalty less reference over the periods shown, in parts.")

_LONG = {"t": "time", "total": "difference"}  # columns of the difference: their names in a file
# The series of each figure: label, name of the source, and its columns by their names in a file.
_SERIES: dict[str, list[tuple[str, str, dict[str, str]]]] = {
    "displacement": [
        *((s, "displacements", {"time": "t", "xi1": f"{s}1", "xi2": f"{s}2"}) for s in SOLVERS),
        ("measured", "measured displacements", {"time": "t", "xi1": "x1", "xi2": "x2"}),
    ],
    "strip": [(s, f"strip_{s}", {"contact_begin": "left", "contact_end": "right"}) for s in SOLVERS],
    "force": [
        *((s, f"force_{s}", {"time": "t", "force": "force"}) for s in SOLVERS),
        *((f"{s} impulse", f"impulse_{s}", {"time": "t", "impulse": "impulse"}) for s in SOLVERS),
    ],
} | {
    f"phase{n}": [
        (label, source, {f"xi{n}": f"x{n}", f"velocity{n}": f"v{n}"})
        for label, source in (
            *((s, f"phase_{s}") for s in SOLVERS),
            *((f"{s} section", f"section_{s}") for s in SOLVERS),
            ("measured", "measured phase"),
        )
    ]
    for n in (1, 2)
}


def figure_table(
    figure: str,
    columns: Mapping[str, Columns],
    scale: Units | None = None,
    *,
    located: bool = False,
    wall: bool = False,
) -> list[Series]:
    """The data of one figure, a series for each curve, and for the points of a measurement, ``measured``, if any.

    Times are counted from the beginning of the last two excitation periods, in periods. With a ``scale``, the columns
    must be in its units already, and the name of each column in the file holds its unit. With ``located`` steps the
    force of a contact that is too short to sample is its mean, and the column says so. A ``wall`` does not move, and
    has no column.
    """

    def title(name: str, column: str, source: str) -> str:
        mean = located and source == "force_penalty" and name == "force"
        return column_title("force_or_mean" if mean else name, column, scale)

    known = {**columns, **{f"measured {name}": each for name, each in columns.get("measured", {}).items()}}
    found = []
    for label, source, chosen in _SERIES[figure]:
        moving = {name: column for name, column in chosen.items() if not (wall and name == "xi2")}
        if source in known:
            data = {title(name, column, source): known[source][column] for name, column in moving.items()}
            found.append(Series(label, data))
    return found


def difference_table(columns: Columns, coordinate: str, scale: Units | None = None) -> list[Series]:
    """The data of `DIFFERENCE`, like `figure_table`."""
    found = {column_title(_LONG.get(n, n), n, scale): column for n, column in columns.items()}
    return [Series(coordinate, found)]


# Columns of studies and fields of the setting: quantity, and name with units.
_TITLES = {"eta": "f", "D": "2D"}
_MODEL_COLUMNS = {
    f"{end}{name}": (quantity, f"{end}{_TITLES.get(name, name)}")
    for name, quantity in FIELD_QUANTITIES.items()
    for end in ("", "from_", "to_")
} | {
    **{f"xi{k}": ("displacement", f"x{k}") for k in (1, 2)},
    **{f"v{k}": ("velocity", f"velocity{k}") for k in (1, 2)},
    **{name: ("displacement", name) for name in ("spread", "scatter")},
    "longest_contact": ("time", "longest_contact"),
    "tau": ("time", "time"),
    "force": ("force", "force"),
}


def table_in_units(table: list[Series], scale: Units | None) -> list[Series]:
    """A table of numbers of the model with its columns in units, which their names hold."""
    return [each._replace(columns=columns_in_units(each.columns, scale)) for each in table]


def columns_in_units(columns: Columns, scale: Units | None, quantities: Mapping[str, str] | None = None) -> Columns:
    """Columns of numbers of the model in units, which their names hold; columns with a unit already stay.

    A column may be a table of columns; a column of texts, or of no number, stays as it is. ``quantities`` says what
    other columns are than those of studies and fields.
    """
    if scale is None:
        return columns
    found = {}
    known = _MODEL_COLUMNS if quantities is None else {name: (each, name) for name, each in quantities.items()}
    for name, column in columns.items():
        quantity, title = known.get(name, ("", name))
        if isinstance(column, Mapping):
            found[name] = columns_in_units(column, scale, quantities)
        elif quantity:
            numbers = np.asarray(column)
            shown = scale.factor(quantity) * numbers if numbers.dtype.kind in "fiu" else column
            found[f"{title} [{scale.unit(quantity)}]"] = shown
        else:
            found[name] = column
    return found


def column_title(name: str, column: str, scale: Units | None) -> str:
    """Name of a column of a source in a file, with its unit."""
    quantity = quantity_of(column)
    return f"{name} [{scale.unit(quantity)}]" if scale and quantity else name
