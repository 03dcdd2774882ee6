"""The directive ``store``: the variables that a study writes, with dimensions, kind and meaning, from a small study."""

import re
from collections.abc import Callable

from docutils import nodes
from docutils.statemachine import StringList
from sphinx.application import Sphinx
from sphinx.util.docutils import SphinxDirective
from vibroscope.engine import (
    Reference,
    System,
    sweep_basin,
    sweep_eta,
    sweep_no_solution,
    sweep_plane,
    sweep_step,
)
from xarray import Dataset

SYSTEM, FEW = System(), {"transient": 20, "sample": 4}
STUDIES: dict[str, Callable[[], Dataset]] = {
    "eta": lambda: sweep_eta(SYSTEM, Reference(), [1.0, 1.1], lyapunov=256, **FEW),
    "plane": lambda: sweep_plane(SYSTEM, 2.76, [1000.0, 2000.0], [10.0, 20.0], steps=500, **FEW),
    "step": lambda: sweep_step(SYSTEM, 2.76, 12000.0, 18.0, [500, 1000], **FEW),
    "no-solution": lambda: sweep_no_solution(SYSTEM, 2.76, [1000.0, 2000.0], 18.0, [100, 200], **FEW),
    "basin": lambda: sweep_basin(SYSTEM, 3.2, Reference(), [-1.0, 1.0], [-1.0, 1.0], transient=200, sample=64),
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
