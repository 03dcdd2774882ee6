"""Another reading of the columns that explains a difference: other zeros, units, signs, order, or frame.

A difference from the reference may lie in the file alone. So the columns are aligned with the reference again: in
either frame, with the bodies exchanged, with either sign, in the unit in which they are about as large as the
reference, with and without zeros of the sensors. Among the readings that leave hardly more than the best one, that with
the fewest changes is proposed, if it leaves so little that it explains the difference.
"""

import itertools
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

import numpy as np
from vibroscope.engine.divergence.grid import rms
from vibroscope.engine.facts import Amount, Statement, joined, stated
from vibroscope.engine.measurement.alignment import best_phase
from vibroscope.engine.measurement.cycle import Cycle
from vibroscope.engine.measurement.measurement import Measurement
from vibroscope.engine.measurement.measurement_columns import PAIRS
from vibroscope.engine.measurement.tolerances import EXPLAINS, HARDLY_MORE, SAME_SIZE, WITHIN_NOISE
from vibroscope.engine.result import check_cancelled
from vibroscope.engine.units import written
from vibroscope.engine.wording import percent

_SAMPLES = 1000  # are enough to tell readings apart
_UNITS = {
    1.0: "",
    1e3: "m in place of mm",
    1e-3: "mm in place of m",
    1e6: "m in place of µm",
    1e-6: "µm in place of m",
    25.4: "in in place of mm",
    1 / 25.4: "mm in place of in",
}


@dataclass(frozen=True)
class Reading:
    """How the columns may be meant.

    Attributes
    ----------
    swapped : bool
        The first column belongs to body 2.
    frame : {"absolute", "relative"}
    other_frame : bool
        Whether that is another frame than the file names.
    factors : (2,) or (1,) ndarray
        Of the displacements, signs included.
    zeros : (2,) or (1,) ndarray
        What the sensors show at rest, in base amplitudes; 0 where none is needed.
    rms : float
        What remains of the difference from the reference, relative to the displacements.
    """

    swapped: bool
    frame: str
    other_frame: bool
    factors: np.ndarray
    zeros: np.ndarray
    rms: float

    @property
    def changes(self) -> int:
        """How many things differ from what the file says."""
        scaled = (np.abs(self.factors) != 1).any()
        return sum(map(int, (self.swapped, self.other_frame, (self.factors < 0).any(), scaled, self.zeros.any())))

    @property
    def sentence(self) -> Statement:
        """Propose the reading."""
        advice = "correct the columns"
        if self.changes == 1:
            fitted = ", ".join(f"zero{body}" for body in np.flatnonzero(self.zeros) + 1)
            advice = "name them so" if self.other_frame else f"fit {fitted}" if fitted else advice
        changes = joined(" and ", self._changes())
        return stated("If {}, the reference is {} off: {}.", changes, percent(self.rms), advice)

    def _changes(self) -> Iterator[str | Statement]:
        names = PAIRS[self.frame]
        if self.swapped:
            yield "the columns of body 1 and body 2 are exchanged"
        if self.other_frame:
            meant = "relative to the base" if self.frame == "relative" else "absolute"
            yield f"the columns are {', '.join(names)} ({meant})"
        turned = [name for name, factor in zip(names, self.factors, strict=False) if factor < 0]
        if turned:
            yield f"{' and '.join(turned)} {'have' if len(turned) > 1 else 'has'} the opposite sign"
        for factor in dict.fromkeys(np.abs(self.factors).tolist()):
            scaled = [name for name, own in zip(names, self.factors, strict=False) if abs(own) == factor]
            if factor != 1:
                times = f"{written(factor, 3)} times as large" + (f" ({_UNITS[factor]})" if factor in _UNITS else "")
                yield f"{' and '.join(scaled)} {'are' if len(scaled) > 1 else 'is'} {times}"
        for name, zero in zip(names, self.zeros.tolist(), strict=False):
            if zero:
                yield stated("the sensor of {} shows {} at rest", name, Amount(zero, "displacement", 3))


def explaining_reading(
    cycle: Cycle, measurement: Measurement, off: float, noise: float, cancelled: Callable[[], bool] | None = None
) -> Reading | None:
    """Find the reading with which the reference agrees; None if the file's own does, or none explains the difference.

    Parameters
    ----------
    cycle : Cycle
        Of the reference.
    measurement : Measurement
    off : float
        Difference from the reference, relative to the displacements.
    noise : float
        Of the measurement, in base amplitudes.

    Raises
    ------
    Cancelled
        If ``cancelled`` returned true.
    """
    thin = measurement.thinned(_SAMPLES)
    noise = WITHIN_NOISE * noise / max(rms(thin.displacement), 1e-300)
    found: list[Reading] = []
    bodies = len(thin.displacement)
    for swapped in (False, True)[:bodies]:
        for frame, signs in itertools.product(cycle.frames, itertools.product((1.0, -1.0), repeat=bodies)):
            check_cancelled(cancelled)
            found += _readings(cycle, thin, swapped, frame, np.array(signs))
    enough = max(HARDLY_MORE * min(reading.rms for reading in found), noise)
    best = min((reading for reading in found if reading.rms <= enough), key=lambda one: (one.changes, one.rms))
    explains = best.rms <= max(EXPLAINS * off, min(noise, off / 2))
    return best if best.changes and explains else None


def _readings(cycle: Cycle, thin: Measurement, swapped: bool, frame: str, signs: np.ndarray) -> Iterator[Reading]:
    """The readings in this order, frame and with these signs: as large as the file says or about as the reference."""
    given = signs[:, None] * (thin.displacement[::-1] if swapped else thin.displacement)
    sizes = (values.std(axis=1) for values in (cycle.displacement(thin.time, frame)[: len(given)], given))
    ratio = np.divide(*(np.maximum(size, 1e-300) for size in sizes))
    units = np.array([min(_UNITS, key=lambda unit: abs(np.log(unit / one))) for one in ratio])
    known = np.abs(np.log(units / ratio)) < np.log(SAME_SIZE)
    shown = replace(thin, displacement=np.where(known, units, ratio)[:, None] * given, frame=frame, mean_known=False)
    phase = best_phase(cycle, shown, frame)
    solution = cycle.displacement(thin.time + phase, frame)[: len(given)]
    centred, wanted = (values - values.mean(axis=1, keepdims=True) for values in (given, solution))
    fitted = np.sum(centred * wanted, axis=1) / np.maximum(np.sum(centred**2, axis=1), 1e-300)
    factors = np.where(known, units, np.abs(fitted))
    difference = factors[:, None] * given - solution
    zeros = difference.mean(axis=1)
    zeros = np.where(np.abs(zeros) < EXPLAINS * np.abs(zeros).max(), 0.0, zeros)
    size = max(rms(factors[:, None] * given), 1e-300)
    for each in (0 * zeros, zeros) if thin.mean_known else (0 * zeros,):
        remaining = (
            difference - each[:, None] if thin.mean_known else difference - difference.mean(axis=1, keepdims=True)
        )
        yield Reading(swapped, frame, frame != thin.frame, signs * factors, each, rms(remaining) / size)
