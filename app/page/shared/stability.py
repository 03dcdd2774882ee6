"""Words for how stable a periodic motion is: its largest Floquet multiplier, and how fast a run leaves it."""

import math

from vibroscope.app.explorer.closed_orbit import ClosedOrbit
from vibroscope.engine import Point
from vibroscope.engine.motions.floquet import is_stable, may_be_stable
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
