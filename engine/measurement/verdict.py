"""The comparison with a measurement in a few sentences, made from its numbers."""

from collections.abc import Iterator

import numpy as np
from vibroscope.engine.facts import ETA, OMEGA1, Statement, equation, joined, stated
from vibroscope.engine.measurement.comparison import MeasuredComparison, Solved
from vibroscope.engine.measurement.tolerances import HARDLY_VISIBLE, SENSOR
from vibroscope.engine.result import Status
from vibroscope.engine.wording import every, percent


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
