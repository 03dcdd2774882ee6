"""Comparison of a measurement with the reference and a penalty solution, and a few sentences made from its numbers.

A difference from the reference may lie in the file alone: in its zeros, units, signs, order, or frame. So the columns
are aligned with the reference again: in either frame, with the bodies exchanged, with either sign, in the unit in which
they are about as large as the reference, with and without zeros of the sensors. Among the readings that leave hardly
more than the best one, that with the fewest changes is proposed, if it leaves so little that it explains the
difference.
"""

import itertools
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from vibroscope.engine.arguments import Poll
from vibroscope.engine.divergence.grid import rms
from vibroscope.engine.facts import ETA, OMEGA1, Amount, Statement, equation, joined, sentence, stated
from vibroscope.engine.measurement.cycle import (
    Alignment,
    Cycle,
    SettledRun,
    align,
    best_phase,
    free_motion,
    held_words,
    penalty_cycle,
    reference_cycle,
)
from vibroscope.engine.measurement.measurement import Measurement
from vibroscope.engine.measurement.measurement_columns import PAIRS
from vibroscope.engine.measurement.recurrence import Recurrence, free_record, recurrence
from vibroscope.engine.measurement.tolerances import (
    CERTAIN_SIGMAS,
    EXPLAINS,
    HARDLY_MORE,
    HARDLY_VISIBLE,
    PHASE_DRIFT,
    SAME_SIZE,
    SENSOR,
    WITHIN_NOISE,
)
from vibroscope.engine.methods import Reference, TimeStepping
from vibroscope.engine.model import System, check_eta
from vibroscope.engine.motions.description import describe
from vibroscope.engine.motions.steady import REST
from vibroscope.engine.result import Response, Status, check_cancelled
from vibroscope.engine.simulate import LONG
from vibroscope.engine.units import written
from vibroscope.engine.wording import every, percent

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
    cycle: Cycle, measurement: Measurement, off: float, noise: float, cancelled: Poll | None = None
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
    thin, grid = measurement.thinned(_SAMPLES), cycle.phases(measurement)
    noise = WITHIN_NOISE * noise / max(rms(thin.displacement), 1e-300)
    found: list[Reading] = []
    bodies = len(thin.displacement)
    for swapped in (False, True)[:bodies]:
        for frame, signs in itertools.product(cycle.frames, itertools.product((1.0, -1.0), repeat=bodies)):
            check_cancelled(cancelled)
            found += _readings(cycle, thin, grid, swapped, frame, np.array(signs))
    enough = max(HARDLY_MORE * min(reading.rms for reading in found), noise)
    best = min((reading for reading in found if reading.rms <= enough), key=lambda one: (one.changes, one.rms))
    explains = best.rms <= max(EXPLAINS * off, min(noise, off / 2))
    return best if best.changes and explains else None


def _readings(
    cycle: Cycle, thin: Measurement, grid: np.ndarray, swapped: bool, frame: str, signs: np.ndarray
) -> Iterator[Reading]:
    """The readings in this order, frame and with these signs: as large as the file says or about as the reference."""
    given = signs[:, None] * (thin.displacement[::-1] if swapped else thin.displacement)
    sizes = (values.std(axis=1) for values in (cycle.displacement(thin.time, frame)[: len(given)], given))
    ratio = np.divide(*(np.maximum(size, 1e-300) for size in sizes))
    units = np.array([min(_UNITS, key=lambda unit: abs(np.log(unit / one))) for one in ratio])
    known = np.abs(np.log(units / ratio)) < np.log(SAME_SIZE)
    shown = replace(thin, displacement=np.where(known, units, ratio)[:, None] * given, frame=frame, mean_known=False)
    phase = best_phase(cycle, shown, frame, grid)
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


@dataclass(frozen=True)
class Solved:
    """One solution beside the measurement.

    Attributes
    ----------
    response : Response
    period : int
        Excitation periods until it repeats itself, where scatter is ignored; 0 if it does not.
    impacts_per_period, contact_share : float or None
        Of the solution itself; None if it ended early.
    alignment : Alignment or None
        None if it does not repeat itself.
    """

    response: Response
    period: int
    impacts_per_period: float | None
    contact_share: float | None
    alignment: Alignment | None


@dataclass(frozen=True)
class MeasuredComparison:
    """A measurement beside both solvers.

    Attributes
    ----------
    measurement : Measurement
    recurrence : Recurrence
    reference, penalty : Solved
    reading : Reading or None
        Another reading of the columns, with which the reference agrees; None if nothing of the kind explains the
        difference.
    """

    measurement: Measurement
    recurrence: Recurrence
    reference: Solved
    penalty: Solved
    reading: Reading | None

    @property
    def periods(self) -> float:
        """Excitation periods that the measurement covers."""
        return self.measurement.span / self.reference.response.period

    @property
    def is_free(self) -> bool:
        """Whether nothing that repeats drives the bodies, so that the motions are compared from their start."""
        return not self.reference.response.system.excitation.repeats

    @property
    def drift(self) -> float:
        """Radians by which the measurement runs out of step with the given η; nan if it is not in step with any."""
        return abs(self.recurrence.eta - self.reference.response.eta) * self.measurement.span

    @property
    def other_eta(self) -> float | None:
        """The excitation frequency of the measurement if it is certainly not the given one."""
        own = self.recurrence
        certain = abs(own.eta - self.reference.response.eta) > CERTAIN_SIGMAS * own.eta_error
        return own.eta if certain and self.drift > PHASE_DRIFT else None


def compare_measured(
    system: System,
    eta: float,
    measurement: Measurement,
    penalty: TimeStepping,
    *,
    reference: Reference | None = None,
    periods: int = LONG,
    initial: Sequence[float] | None = REST,
    cancelled: Poll | None = None,
) -> MeasuredComparison:
    """Compare a measurement with both solutions, both from one start and each aligned by its own phase.

    Where nothing drives the bodies, or a load that is no harmonic, the measurement is compared from that start, and the
    phase is the time since then. Under such a load ``steps`` are those in 2π/ω₁, a natural period of body 1.

    Parameters
    ----------
    system : System
    eta : float
        Excitation frequency η = Ω/ω₁ of the measurement; of no use under a load that is no harmonic.
    measurement : Measurement
    penalty : TimeStepping
    reference : Reference, optional
    periods : int
        Excitation periods that Newmark runs.
    initial : (4,) sequence, optional
        ξ₁, ξ₁′, ξ₂, ξ₂′ at τ = 0, by default rest.
    cancelled : callable, optional
        Polled many times a second; when it returns true the comparison is cancelled.

    Returns
    -------
    MeasuredComparison

    Raises
    ------
    ValueError
        If a number is out of range, or the measurement covers less than an excitation period.
    Cancelled
        If ``cancelled`` returned true.

    Examples
    --------
    >>> from vibroscope.engine import Newmark, System, compare_measured, measured_verdict, synthetic_measurement
    >>> made = synthetic_measurement(System(), 2.76, noise=0.01)
    >>> compared = compare_measured(System(), 2.76, made, Newmark(12000, 18, 8000, located=True))
    >>> measured_verdict(compared).partition(" (")[0]
    'The reference agrees within the noise of the measurement'
    """
    eta, measurement = check_eta(eta), measurement.of(system)
    reference = reference or Reference()
    options = {"initial": initial, "cancelled": cancelled}
    if not system.excitation.repeats:
        exact, newmark = (free_motion(system, eta, one, measurement, **options) for one in (reference, penalty))
        own = free_record(measurement, exact.response.eta)
    else:
        own = recurrence(measurement, eta)
        exact = reference_cycle(system, eta, reference, **options)
        newmark = penalty_cycle(system, eta, penalty, periods, **options)
    solved, other = (_solved(measurement, run) for run in (exact, newmark))
    if not system.excitation.repeats:
        solved, other = _from_one_start(measurement, (solved, other), (exact, newmark))
    reading = None
    off = solved.alignment is not None and not solved.alignment.is_within(own.noise)
    if off and own.possible and exact.cycle.slopes.any():
        reading = explaining_reading(exact.cycle, measurement, solved.alignment.rms, own.noise, cancelled)
    return MeasuredComparison(measurement, own, solved, other, reading)


def _solved(measurement: Measurement, run: SettledRun) -> Solved:
    response, cycle = run
    if not response.ok:
        return Solved(response, 0, None, None, None)
    period = cycle.periods if cycle is not None and cycle.repeats else 0
    aligned = None if cycle is None else align(cycle, measurement)
    described = describe(response)
    return Solved(response, period, described.impacts_per_period, described.contact_share, aligned)


def _from_one_start(
    measurement: Measurement, solved: Sequence[Solved], runs: Sequence[SettledRun]
) -> tuple[Solved, ...]:
    """Both solutions with the start of the record at which the nearer one fits: a sensor has one trigger."""
    aligned = [each.alignment for each in solved]
    if None in aligned:
        return tuple(solved)
    phase = min(aligned, key=lambda one: one.rms).phase
    moved = (align(run.cycle, measurement, phase) for run in runs)
    return tuple(replace(each, alignment=one) for each, one in zip(solved, moved, strict=True))


def measured_verdict(compared: MeasuredComparison) -> Statement:
    """Say whether a measurement shows this motion at all, and how close each solution is to it."""
    return joined(" ", _sentences(compared))


def _sentences(compared: MeasuredComparison) -> Iterator[str | Statement]:
    own, eta = compared.recurrence, compared.reference.response.eta
    if compared.is_free and not np.any(compared.reference.response.trajectory.velocity):
        yield (
            "Nothing drives the bodies, and they start at rest, so that nothing moves. Give the start that was "
            "measured: initial, displacement and velocity of body 1 and of body 2."
        )
        return
    if not own.possible:
        yield stated(
            "The measurement is not in step with an excitation at {}; its strongest frequency is {}. Check {}, the "
            "unit of time and {}; if they are right, the motion is not periodic, or noise hides it, and only "
            "statistics can be compared.",
            equation("eta", eta),
            equation("eta", own.strongest, 4),
            ETA,
            OMEGA1,
        )
        return
    if compared.other_eta is not None:
        error = own.eta_error * compared.measurement.span
        yield stated(
            "The measurement was excited at {}, not at {}: it runs out of step by {} rad. Give that {} before anything "
            "else is judged.",
            equation("eta", own.eta),
            equation("eta", eta),
            f"{compared.drift:.2g} +- {error:.1g}",
            ETA,
        )
        return
    if len(own.possible) > 1:
        yield _undecided_sentence(compared)
    yield _solution_sentence("reference", compared.reference, compared)
    yield _solution_sentence("penalty solution", compared.penalty, compared)
    if nearer := _nearer_sentence(compared):
        yield nearer
    held = next((a for a in (compared.reference.alignment, compared.penalty.alignment) if a and a.held), None)
    if held is not None:
        yield sentence(held_words(held.phase))
    if compared.reading is not None:
        yield compared.reading.sentence


def _solution_sentence(name: str, solved: Solved, compared: MeasuredComparison) -> str:
    own, aligned = compared.recurrence, solved.alignment
    if solved.response.status is not Status.OK:
        return f"The {name} ended early ({solved.response.status})."
    if aligned is None:
        measured = " or ".join(every(period) for period in own.possible)
        return f"The {name} does not repeat, the measurement does {measured}."
    if solved.period not in own.possible:
        measured = " or ".join(every(period) for period in own.possible)
        return f"The {name} repeats {every(solved.period)}, the measurement {measured}: another motion."
    if aligned.is_within(compared.recurrence.noise):
        sentence = f"The {name} agrees within the noise of the measurement ({percent(aligned.rms)})"
    elif aligned.rms <= HARDLY_VISIBLE:
        sentence = f"The {name} follows the measurement to {percent(aligned.rms)}, more than its noise explains"
    else:
        sentence = f"The {name} is {percent(aligned.rms)} off"
    measured = own.sensor
    if measured is not None:
        solution = aligned.sensor.per_period
        if abs(measured.per_period - solution) > SENSOR * max(measured.per_period, 1.0):
            of, times = (" a period", 1) if not compared.is_free else ("", compared.periods)
            sentence += f", and would close the sensor {times * solution:.3g} times{of}, not "
            sentence += f"{times * measured.per_period:.3g}"
    return sentence + "."


def _undecided_sentence(compared: MeasuredComparison) -> str:
    """Say between which periods the samples do not decide."""
    first, *others = (every(period) for period in compared.recurrence.possible)
    rate = (len(compared.measurement) - 1) / compared.periods
    return (
        f"With {rate:.3g} samples a period over {compared.periods:.3g} periods, the measurement does not show whether "
        f"it repeats {first} or {' or '.join(others)}; give more samples a period, or more periods."
    )


def _nearer_sentence(compared: MeasuredComparison) -> str:
    """Say which solution is nearer to the measurement; empty where only one of them can be compared with it."""
    solutions = {"reference": compared.reference, "penalty solution": compared.penalty}
    off = {
        name: solved.alignment
        for name, solved in solutions.items()
        if solved.alignment is not None and solved.period in compared.recurrence.possible
    }
    if len(off) < len(solutions):
        return ""
    if all(aligned.is_within(compared.recurrence.noise) for aligned in off.values()):
        return "Its noise hides which of the two is nearer."
    (near, least), (_, other) = sorted(((name, aligned.rms) for name, aligned in off.items()), key=lambda one: one[1])
    if percent(least) == percent(other):
        return "Both are equally near."
    return f"The {near} is nearer: {percent(least)} off against {percent(other)}."
