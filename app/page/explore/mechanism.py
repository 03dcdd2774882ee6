"""The pendulums, moved in the browser from data that are there already; and the present phase in every figure."""

from __future__ import annotations

import param
from vibroscope.app.page.files import script, style
from vibroscope.app.page.shared.component import Component


class Mechanism(Component):
    """Sends nothing and is sent nothing, but for what the displacements are relative to."""

    absolute = param.Boolean(
        default=False, doc="Whether the displacements drawn over time are those a fixed sensor sees"
    )

    amplitude = param.Number(default=1.0, doc="The base's, in the units of the displacements")

    _esm = script("shared/dom", "explore/phase", "explore/mechanism")
    _stylesheets = [style("explore/mechanism")]  # noqa: RUF012 - Panel reads it from the class
