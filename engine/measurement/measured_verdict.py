"""What a measurement says of both solutions, in a few plain sentences made from the numbers."""

import math
from collections.abc import Iterator

from ..result import Status
from .alignment import MeasuredComparison, Solved

DRIFT = 0.3  # radians over the whole record: from there on the frequency given is not that of the measurement
WITHIN_NOISE = 1.1  # of the noise: the difference is nothing else
ALIKE = 0.05  # of the measured size: what an eye would call the same
OTHER_FRAME = 0.5  # so much nearer if the columns are read otherwise
SENSOR = 0.2  # of a period's closings


def measured_verdict(found: MeasuredComparison) -> str:
    """Plain words on a comparison: is it this motion at all, and how near is each solution."""
    return " ".join(_sentences(found))


def _sentences(found: MeasuredComparison) -> Iterator[str]:
    told, eta = found.recurrence, found.reference.response.eta
    if told.period == 0:
        yield (
            f"The measurement is not in step with an excitation at eta = {eta:g}; its strongest frequency is "
            f"{told.strongest:.4g}. Check eta, the unit of time and omega1; if they are right, the motion is not "
            "periodic, or noise hides it, and only statistics can be compared."
        )
        return
    drift = abs(told.eta - eta) * found.measurement.span
    if drift > DRIFT:
        yield (
            f"The measurement was excited at eta = {told.eta:.6g}, not {eta:g}: it runs out of step by "
            f"{drift:.2g} rad. Give that eta before anything else is judged."
        )
        return
    yield _one("reference", found.reference, found)
    yield _one("penalty solution", found.penalty, found)
    aligned = found.reference.alignment
    if aligned is not None and aligned.rms > ALIKE and found.other_frame < OTHER_FRAME * aligned.rms:
        names = "xi1, xi2 (relative to the base)" if found.measurement.frame == "absolute" else "x1, x2 (absolute)"
        yield f"If the columns are {names}, the reference is {found.other_frame:.1%} off: name them so."


def _one(name: str, solved: Solved, found: MeasuredComparison) -> str:
    told, aligned = found.recurrence, solved.alignment
    if solved.response.status is not Status.OK:
        return f"The {name} ended early ({solved.response.status})."
    if aligned is None:
        return f"The {name} does not repeat, the measurement does{_after(told.period)}."
    if solved.period != told.period:
        return f"The {name} repeats{_after(solved.period)}, the measurement{_after(told.period)}: another motion."
    deviation = math.sqrt(float((aligned.channels**2).mean()))
    if deviation <= WITHIN_NOISE * told.noise:
        words = f"The {name} agrees within the noise of the measurement ({aligned.rms:.1%})"
    elif aligned.rms <= ALIKE:
        words = f"The {name} follows the measurement to {aligned.rms:.1%}, more than its noise explains"
    else:
        words = f"The {name} is {aligned.rms:.1%} off"
    seen = told.sensor
    if seen is not None and abs(seen.per_period - aligned.sensor.per_period) > SENSOR * max(seen.per_period, 1.0):
        words += (
            f", and would close the sensor {aligned.sensor.per_period:.3g} times a period, not {seen.per_period:.3g}"
        )
    return words + "."


def _after(period: int) -> str:
    return " every period" if period == 1 else f" every {period} periods"
