"""The animated system, and the marks of the present instant in every figure; both run in the browser alone."""

import math
from collections.abc import Callable

import param
from vibroscope.app.explorer.compute import SHOWN_PERIODS, shown_periods
from vibroscope.app.explorer.drawing import drawing, drawing_in_words
from vibroscope.app.explorer.present import unit_factor
from vibroscope.app.explorer.state import Setting
from vibroscope.app.page.shared.component import Component
from vibroscope.engine.simulate import LONGEST_FLIGHT


class Mechanism(Component):
    """Draws the data that the browser already has; only the reference of the displacements is sent to it.

    Attributes
    ----------
    on_hold : callable
        Called whenever the user holds the motion at another phase, or lets it go on.
    """

    held = param.Number(
        default=None, bounds=(0, LONGEST_FLIGHT), doc="Phase τ/T at which the motion is held; None: it goes on"
    )
    window = param.Integer(default=SHOWN_PERIODS, doc="Periods that the figures show")
    absolute = param.Boolean(default=False, doc="Whether the displacements over time are relative to a fixed sensor")
    amplitude = param.Number(default=1.0, doc="The unit of length, in the units of the displacements")
    system = param.Dict(default=drawing(Setting()), doc="The system to scale, see `app.explorer.drawing`")
    words = param.String(default=drawing_in_words(Setting()), doc="The same in words")

    script = "explore/mechanism"
    sheets = ("shared/bodies",)

    def __init__(self, **params) -> None:
        super().__init__(**params)
        self.on_hold: Callable[[], None] = lambda: None
        self.listen(held=(int | float | None, self._hold_at))

    def follow(self, setting: Setting) -> None:
        """Draw the system of the setting."""
        self.param.update(
            window=shown_periods(setting),
            absolute=setting.frame == "absolute",
            amplitude=unit_factor("displacement", setting),
            system=drawing(setting),
            words=drawing_in_words(setting),
        )

    def _hold_at(self, held: float | None) -> None:
        """Hold the motion at a phase; None: let it go on."""
        if held is None or (type(held) in (int, float) and math.isfinite(held) and 0 <= held <= self.window):
            self.held = held if held is None else round(held, 3)
            self.on_hold()
