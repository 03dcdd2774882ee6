"""The directive ``store``: the variables that a study writes, with dimensions, kind and meaning, from a small study."""

import re
from collections.abc import Callable

from docutils import nodes
from docutils.statemachine import StringList
from sphinx.application import Sphinx
from sphinx.util.docutils import SphinxDirective
from vibroscope.engine import (
    BasinStudy,
    EtaStudy,
    Newmark,
    NoSolutionStudy,
    PlaneStudy,
    Reference,
    StepStudy,
    System,
    TimeStepping,
    sweep,
)
from xarray import Dataset

SYSTEM, FEW = System(), {"transient": 20, "sample": 4}
STUDIES: dict[str, Callable[[], Dataset]] = {
    "eta": lambda: sweep(EtaStudy(SYSTEM, Reference(), values=[1.0, 1.1], lyapunov=256, **FEW)),
    "plane": lambda: sweep(PlaneStudy(SYSTEM, Newmark(1, 1, 500), 2.76, K=[1000.0, 2000.0], D=[10.0, 20.0], **FEW)),
    "step": lambda: sweep(StepStudy(SYSTEM, Newmark(12000.0, 18.0, 2000), 2.76, steps=[500, 1000], **FEW)),
    "no-solution": lambda: sweep(
        NoSolutionStudy(
            SYSTEM, TimeStepping(1, 18.0, 1000, status="end"), 2.76, K=[1000.0, 2000.0], steps=[100, 200], **FEW
        )
    ),
    "basin": lambda: sweep(
        BasinStudy.over(SYSTEM, Reference(), 3.2, {"xi2": [-1.0, 1.0], "v2": [-1.0, 1.0]}, transient=200, sample=64)
    ),
}


def rows(found: Dataset) -> list[tuple[str, str, str, str]]:
    """Name, dimensions, dtype and meaning of each variable, those of cells first."""
    names = sorted(found.variables, key=lambda name: (name in found.dims, -len(found[name].dims)))
    return [(name, ", ".join(found[name].dims), found[name].dtype.str[1:], meaning(found[name])) for name in names]


def meaning(variable) -> str:
    """Description, unit and flags; what has no description is a number of its axis."""
    text = variable.attrs.get("long_name", "index")
    if "flag_meanings" in variable.attrs:
        flags = zip(variable.attrs["flag_values"], variable.attrs["flag_meanings"].split(), strict=True)
        text += ": " + ", ".join(f"{number} {name}" for number, name in flags)
    return text


class Store(SphinxDirective):
    """A table of the variables of the study that is the argument."""

    required_arguments = 1

    def run(self) -> list[nodes.Node]:
        """Make the table."""
        lines = [".. list-table::", "   :header-rows: 1", "", "   * - variable", "     - dimensions", "     - dtype"]
        lines.append("     - meaning")
        for name, *kind, text in rows(STUDIES[self.arguments[0]]()):
            lines += [
                f"   * - ``{name}``",
                *(f"     - {one}" for one in kind),
                "     - " + re.sub(r"([\\_*|`])", r"\\\1", text),
            ]
        return self.parse_text_to_nodes(StringList(lines, source="stores"))


def setup(app: Sphinx) -> dict:
    """Register the directive."""
    app.add_directive("store", Store)
    return {"parallel_read_safe": True}
