"""The animated pendulums, and the marks of the present instant in every figure; both run in the browser alone."""

from __future__ import annotations

import param
from vibroscope.app.page.files import script, style
from vibroscope.app.page.shared.component import Component


class Mechanism(Component):
    """Draws the data that the browser already has; only the reference of the displacements is sent to it."""

    absolute = param.Boolean(default=False, doc="Whether the displacements over time are relative to a fixed sensor")
    amplitude = param.Number(default=1.0, doc="Amplitude of the base, in the units of the displacements")

    _esm = script("shared/dom", "explore/instant", "explore/mechanism")
    _stylesheets = [style("explore/mechanism")]  # noqa: RUF012 - Panel reads it from the class
