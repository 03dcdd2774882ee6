"""What is seen in a figure now, in one line: behind the name of the figure in its title.

The title is also the name of the figure for screen readers (`fit.js`), and stands in its files. The line is made of
what is drawn, and printed in the units of the setting.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np
from bokeh.plotting import figure
from vibroscope.app.explorer.state import Setting
from vibroscope.app.explorer.statements import shown_text
from vibroscope.app.page.shared.ranges import extent
from vibroscope.engine.facts import Amount, Statement, stated

_DIGITS = 3  # as many as can be read in a figure
_SOLVERS = ("reference", "penalty")


def say(plot: figure, name: str, seen: str | Statement = "", setting: Setting | None = None) -> None:
    """Name a figure, and say what is seen in it; nothing is said where there is nothing yet."""
    text = shown_text(seen, setting and setting.scale)
    plot.title.text = f"{name}: {text}" if text else name


def amount(value: float, quantity: str, setting: Setting, *, bare: bool = False) -> Amount:
    """A number as it is drawn, in the units of the setting; ``bare`` where its unit stands with a later one."""
    factor = 1.0 if setting.scale is None else setting.scale.factor(quantity)
    return Amount(value / factor, quantity, _DIGITS, bare)


def between(low: float, high: float, quantity: str, setting: Setting) -> Statement:
    """From one number to another, with one unit."""
    return stated("{} to {}", amount(low, quantity, setting, bare=True), amount(high, quantity, setting))


def of_both(words: str, values: Sequence[float | None], quantity: str, setting: Setting) -> str | Statement:
    """``words`` and a number of the reference and of the penalty solution, as far as there are any."""
    known = {solver: value for solver, value in zip(_SOLVERS, values, strict=True) if value is not None}
    if len(known) == 1:
        ((solver, value),) = known.items()
        return stated("{} {} ({})", words, amount(value, quantity, setting), solver)
    if not known:
        return ""
    first, second = values
    numbers = amount(first, quantity, setting, bare=True), amount(second, quantity, setting)
    return stated("{} {}, penalty {}", words, *numbers)


def apart(differences: Iterable[np.ndarray], setting: Setting) -> str | Statement:
    """How far the curves of both solutions are apart at most; one that ended early has none."""
    most = largest(differences)
    return (
        "one solution ended early" if most is None else stated("up to {} apart", amount(most, "displacement", setting))
    )


def largest(columns: Iterable[np.ndarray]) -> float | None:
    """The largest absolute value of some columns; None if they hold none."""
    ends = extent(columns)
    return None if ends is None else max(map(abs, ends))


def amplitude(column: np.ndarray) -> float | None:
    """Half of the distance from the smallest to the largest value; None if there is none."""
    ends = extent([column])
    return None if ends is None else (ends[1] - ends[0]) / 2
