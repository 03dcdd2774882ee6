"""Comparison of a measurement with the reference and a penalty solution."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from vibroscope.engine.measurement.alignment import Alignment, align
from vibroscope.engine.measurement.cycle import SettledRun, free_motion, penalty_cycle, reference_cycle
from vibroscope.engine.measurement.measurement import Measurement
from vibroscope.engine.measurement.reading import Reading, explaining_reading
from vibroscope.engine.measurement.recurrence import Recurrence, free_record, recurrence
from vibroscope.engine.measurement.tolerances import CERTAIN_SIGMAS, PHASE_DRIFT
from vibroscope.engine.methods import Reference, TimeStepping
from vibroscope.engine.model import System, check_eta
from vibroscope.engine.motions.description import describe
from vibroscope.engine.motions.steady import REST
from vibroscope.engine.result import Response
from vibroscope.engine.simulate import LONG


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
    cancelled: Callable[[], bool] | None = None,
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
    if not system.excitation.repeats:
        span = measurement.span
        exact = free_motion(system, eta, reference, span, initial=initial, cancelled=cancelled)
        newmark = free_motion(system, eta, penalty, span, initial=initial, cancelled=cancelled)
        own = free_record(measurement, exact.response.eta)
    else:
        own = recurrence(measurement, eta)
        exact = reference_cycle(system, eta, reference, initial=initial, cancelled=cancelled)
        newmark = penalty_cycle(system, eta, penalty, periods=periods, initial=initial, cancelled=cancelled)
    solved, reading = _solved(measurement, exact), None
    if (
        solved.alignment is not None
        and own.possible
        and exact.cycle.slopes.any()
        and not solved.alignment.is_within(own.noise)
    ):
        reading = explaining_reading(exact.cycle, measurement, solved.alignment.rms, own.noise, cancelled)
    return MeasuredComparison(measurement, own, solved, _solved(measurement, newmark), reading)


def _solved(measurement: Measurement, run: SettledRun) -> Solved:
    response, cycle = run
    if not response.ok:
        return Solved(response, 0, None, None, None)
    period = cycle.periods if cycle is not None and cycle.repeats else 0
    aligned = None if cycle is None else align(cycle, measurement)
    described = describe(response)
    return Solved(response, period, described.impacts_per_period, described.contact_share, aligned)
