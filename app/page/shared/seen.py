"""What is seen in a figure now, in one line: behind the name of the figure in its title.

The title is also the name of the figure for screen readers (`fit.js`), and stands in its files. The line is made of
what is drawn, and printed in the units of the setting.

Words for how stable a periodic motion is: its largest Floquet multiplier, and how fast a run leaves it.
"""

import math
from collections.abc import Iterable, Sequence

import numpy as np
from bokeh.plotting import figure
from vibroscope.app.explorer.closed_orbit import ClosedOrbit
from vibroscope.app.explorer.field_units import shown_text
from vibroscope.app.explorer.state import SOLVERS, Setting
from vibroscope.app.page.shared.ranges import extent
from vibroscope.engine import Point
from vibroscope.engine.facts import Amount, Statement, stated
from vibroscope.engine.motions.poincare_map import is_stable, may_be_stable
from vibroscope.engine.wording import every

_NEAR_ONE = 5e-4  # a modulus nearer to 1 takes more digits than four, which would show no difference
_ROUNDING = 1e-9  # of the numbers of a state: a smaller overlap is none
_OVERLAPS = (
    " At τ = 0 the bodies overlap in it, as a penalty contact allows; a run of both solvers begins where they touch, "
    "beside this motion."
)
_EXACT = 1e-12  # size of the errors with which a run begins, in displacements: what an unstable motion enlarges


def multiplier_words(multiplier: complex, digits: int = 4) -> str:
    """A Floquet multiplier; of a pair, both."""
    if not math.isfinite(abs(multiplier)):
        return "∞"
    real = f"{multiplier.real:.{digits}g}".replace("-", "−")
    return real if abs(multiplier.imag) < 1e-9 else f"{real} ± {abs(multiplier.imag):.{digits}g}i"


def point_multiplier(point: Point) -> str:
    """The multiplier of a point: the critical one where one passes the unit circle, else the largest."""
    return f"{'critical' if point.is_crossing else 'largest'} {multiplier_words(point.critical_multiplier)}"


def orbit_words(orbit: ClosedOrbit, largest: complex | None) -> str:
    """What to know of a motion of a branch that is open in Explore; ``largest``: its multiplier, if it has one."""
    stability = "." if largest is None else f", {stability_words(largest, orbit.period)}"
    overlaps = orbit.system.overlap_of(orbit.start) > _ROUNDING * max(1.0, *(abs(number) for number in orbit.start))
    return (
        f"From a branch: the {orbit.solver} repeats {every(orbit.period)}{stability} The dotted curve in the phase "
        f"plots is this motion.{_OVERLAPS if overlaps else ''}"
    )


def stability_words(largest: complex, period: int) -> str:
    """Whether a motion is stable by its largest multiplier, and how fast a run leaves it."""
    size = abs(largest)
    if math.isnan(size):
        return "of unknown stability."
    digits = 4 if abs(size - 1) > _NEAR_ONE else 8
    shown = multiplier_words(largest, digits)
    if not math.isfinite(size):
        return "at the edge of an impact, where a small deviation has no bounded effect (multiplier ∞)."
    if is_stable(largest):
        return f"stable (largest multiplier {shown})."
    if may_be_stable(largest):
        return f"at the edge of its stability (largest multiplier {shown})."
    periods = max(period, round(-math.log(_EXACT) / math.log(size) * period))
    left = f"after about {periods:,} excitation periods" if periods < 2000 else "very slowly"
    grows = f"a small deviation grows {size:.{digits}g}-fold {every(period)}"
    return f"unstable (largest multiplier {shown}): {grows}, and a run that begins on it leaves it {left}."


_DIGITS = 3  # as many as can be read in a figure


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
    known = {solver: value for solver, value in zip(SOLVERS, values, strict=True) if value is not None}
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
