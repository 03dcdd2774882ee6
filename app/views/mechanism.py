"""The pendulums, moved in the browser from data that are there already; and the present phase in every figure."""

from __future__ import annotations

import panel as pn
import param

from app.files import script, style
from app.views.lean import Lean


class Mechanism(Lean, pn.custom.JSComponent):
    """Sends nothing and is sent nothing, but for what the displacements are relative to."""

    absolute = param.Boolean(
        default=False, doc="Whether the displacements drawn over time are those a fixed sensor sees"
    )

    amplitude = param.Number(default=1.0, doc="The base's, in the units of the displacements")

    _esm = script("dom", "phase", "mechanism")
    _stylesheets = [style("mechanism")]  # noqa: RUF012 - Panel reads it from the class
