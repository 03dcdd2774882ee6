"""A measurement beside both solutions: compared and fitted in worker threads, as columns, as rows and in words.

The command line prints the same rows and words. No panel import.
"""

import math
from collections.abc import Callable
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from vibroscope.app.explorer.compute import SHOWN_PERIODS
from vibroscope.app.explorer.field_units import shown_text
from vibroscope.app.explorer.load_words import words_of_load
from vibroscope.app.explorer.parameters import FIELDS
from vibroscope.app.explorer.present import Columns, convert_units
from vibroscope.app.explorer.state import SOLVERS, Setting
from vibroscope.app.runtime.job import Answer
from vibroscope.app.runtime.number_text import print_number
from vibroscope.app.runtime.workers import background_worker, lower_priority, pool
from vibroscope.engine import (
    FITTED,
    Fit,
    MeasuredComparison,
    Measurement,
    Units,
    compare_measured,
    fit,
    parse_measurement,
    percent,
    written,
)
from vibroscope.engine.arguments import Poll, shown
from vibroscope.engine.facts import Statement, Symbol, equation, joined
from vibroscope.engine.measurement.cycle import Alignment

LARGEST_FILE = 2 * 2**20  # bytes that the page takes, some 50,000 samples; the command line takes more
_MOST_POINTS = 300  # drawn; more would hide the curves
_SLOPE = 1 / 50  # of an excitation period: the time over which a velocity of the measurement is a mean
LEAST_ERROR = 1e-7  # that is written with the decimals of its constant
# Symbol and name of each constant, as the page shows them.
FITTED_NAMES = {
    name: (FIELDS[name].label, FIELDS[name].hint)
    if name in FIELDS
    else ("scale", "of all sensors")
    if name == "scale"
    else (f"zero {name[-1]}", f"of the sensor of body {name[-1]}")
    for name in FITTED
}


_QUANTITIES = {"K": "contact_stiffness", "D": "contact_damping", "zero1": "displacement", "zero2": "displacement"}


class MeasuredFile:
    """The file of one session: it is parsed again where what defines its units or its columns has changed."""

    def __init__(self, name: str, content: bytes) -> None:
        self.name, self._content = name, content
        self.columns: dict[str, str] | None = None  # which column is what, where the header does not say so
        self._parsed: tuple[object, Measurement] | None = None

    def measurement(self, setting: Setting) -> Measurement:
        """The measurement in numbers of the model; raises ValueError with line and column of the first fault."""
        units, physical = Units(setting.omega1, setting.m1, setting.amplitude), setting.scale is not None
        key = units, self.columns, physical
        known = self._parsed is not None and self._parsed[0] == key and self._parsed[1].eta in (None, setting.eta)
        if not known:
            found = parse_measurement(self._content, units, self.columns, setting.eta, LARGEST_FILE, physical)
            self._parsed = key, found
        return self._parsed[1]

    @property
    def in_units(self) -> bool:
        """Whether its numbers have units, as far as it has been read."""
        return self._parsed is None or self._parsed[1].physical


def judge_file(
    question: tuple[MeasuredFile, Setting, tuple[str, ...]], deliver: Callable[[Answer, object], None]
) -> Answer:
    """Compare a file with both solutions of a setting or, where constants are named, fit these to it.

    ``deliver(job, comparison, fit or exception)`` is called in a worker thread.
    """
    threads = pool("fit", 1, lower_priority) if question[2] else background_worker()
    return Answer(question, _judge, deliver, threads, "measurement")


def _judge(
    question: tuple[MeasuredFile, Setting, tuple[str, ...]], cancelled: Poll, _: Callable
) -> MeasuredComparison | Fit | ValueError:
    file, setting, names = question
    options = {"cancelled": cancelled, "initial": setting.initial}
    try:
        measurement = file.measurement(setting)
        if names:
            return fit(setting.system, setting.eta, measurement, names=names, **options)
        options |= {"reference": setting.reference}
        return compare_measured(setting.system, setting.eta, measurement, setting.penalty, **options)
    except ValueError as error:  # an answer, since its text may quote the file, which belongs into no log
        return error


# ---- in words -------------------------------------------------------------------------------------------------------


def headline(comparison: MeasuredComparison) -> Statement:
    """How many samples there are, over how many periods, of which bodies in which frame, and what was left out."""
    measurement = comparison.measurement
    eta = equation("eta", comparison.reference.response.eta)
    bodies = "displacements" if len(measurement.displacement) > 1 else "displacement of body 1"
    bodies += "" if measurement.mean_known else " without their mean, from accelerations"
    left_out = f"; left out: {', '.join(map(shown, measurement.left_out))}" if measurement.left_out else ""
    if load := comparison.reference.response.system.excitation.load:
        samples = f"; {len(measurement)} samples, {measurement.frame} {bodies}, from the start"
        return joined("", (words_of_load(load, load.length), samples, left_out))
    text = f", {len(measurement)} samples over {comparison.periods:.3g} periods, {measurement.frame} {bodies}"
    text += ", from the start, since nothing drives the bodies" if comparison.is_free else ""
    return eta + text + left_out


def comparison_rows(comparison: MeasuredComparison, scale: Units | None = None) -> list[list[str | Statement]]:
    """A table of the measurement beside both solutions, its heads first; "-" for what is not known."""
    recurrence, sensor = comparison.recurrence, comparison.recurrence.sensor
    solved = comparison.reference, comparison.penalty

    def shown(quantity: str, value: float, digits: int) -> str:
        return _shown(quantity, value, digits, scale)

    def both(text: Callable) -> list[str]:
        return ["-" if each.alignment is None else text(each.alignment) for each in solved]

    def of_sensor(text: Callable) -> list[str]:
        return [text(sensor) if sensor else "-", *both(lambda a: text(a.sensor))]

    def closings(alignment) -> str:
        return "-" if alignment.closing_error is None else f"{percent(alignment.closing_error)} of T"

    repeats = [" or ".join(map(str, recurrence.possible or (0,))), *(str(each.period) for each in solved)]
    repeats = ["-"] * 3 if comparison.is_free else repeats
    contacts, periods = ("contacts", comparison.periods) if comparison.is_free else ("contacts per period", 1)
    begins = "begins at" if scale else Statement("begins at ", Symbol("tau"))
    return [
        ["", "measured", *SOLVERS],
        ["repeats after", *repeats],
        ["difference (rms)", _noise("{} noise", recurrence.noise, scale), *both(lambda a: percent(a.rms))],
        [begins, "", *both(lambda a: shown("time", a.phase, 4))],
        [contacts, *of_sensor(lambda one: f"{one.per_period * periods:.3g}")],
        ["time in contact, by samples", *of_sensor(lambda one: percent(one.share))],
        ["contact start error", "", *both(closings)],
        ["mean differs by", "", *both(lambda a: ", ".join(shown("displacement", value, 2) for value in a.offset))],
    ]


def _shown(quantity: str, value: float, digits: int, scale: Units | None) -> str:
    return written(value, digits) if scale is None else scale.text(quantity, value, digits)


def _noise(words: str, value: float, scale: Units | None) -> str:
    return words.format(_shown("displacement", value, 3, scale)) if value else "no noise beyond rounding"


def _with_error(value: float, error: float) -> str:
    """A constant to the second digit of its standard error, both with the same decimals."""
    if not math.isfinite(error):
        return f"{value:.6g}"
    if error < LEAST_ERROR:
        return f"{value:.8g} +- {error:.1g}"
    decimals = max(0, 1 - math.floor(math.log10(error)))
    return f"{value:.{decimals}f} +- {error:.{decimals}f}"


def fit_rows(fitted: Fit, scale: Units | None = None) -> list[list[str]]:
    """Each fitted constant with its standard error, and the residual beside the measurement's own noise."""
    rows = []
    for name, value in fitted.values.items():
        quantity, text = _QUANTITIES.get(name), _with_error(value, fitted.errors[name])
        if scale and quantity:
            values = (scale.physical(quantity, each) for each in (value, fitted.errors[name]))
            text = f"{_with_error(*values)} {scale.unit(quantity)}"
        if not math.isfinite(fitted.errors[name]):
            text += ", not shown by the motion"
        rows.append(["2D" if scale and name == "D" else name, text])
    agreeing = f"{fitted.agreeing} of {fitted.starts} starts agree"
    residual = _shown("displacement", fitted.deviation, 3, scale)
    rows.append(["residual", f"{residual}, {_noise('noise {}', fitted.noise, scale)}; {agreeing}"])
    return rows


def fit_content(fitted: Fit, scale: Units | None = None) -> dict:
    """The content of the page for a fit: ``rows``, ``remarks``, and ``use``: the constants as texts that can be set."""
    rows = [
        [FITTED_NAMES[name][0] if name in FITTED_NAMES else name, text.replace("+-", "±")]
        for name, text in fit_rows(fitted, scale)
    ]
    use = {name: print_number(float(f"{value:.6g}")) for name, value in fitted.values.items() if name in FIELDS}
    remarks = [f"Note: {shown_text(remark, scale)}." for remark in fitted.remarks]
    return {"rows": rows, "remarks": remarks, "use": use}


def own_eta(comparison: MeasuredComparison) -> str:
    """The excitation frequency of the measurement as a text, if it is another than that of the setting."""
    found = comparison.other_eta
    return "" if found is None else print_number(float(f"{found:.6g}"))


# ---- in figures -----------------------------------------------------------------------------------------------------


class Placed(NamedTuple):
    """Columns of the measured points in the figures, empty where they have no place; nan of a body not measured."""

    displacements: Columns
    phase: Columns


_TIME, _PHASE = ("t", "x1", "x2"), ("x1", "v1", "x2", "v2")
NOWHERE = Placed(*({name: np.empty(0, np.float32) for name in names} for names in (_TIME, _PHASE)))


def place(comparison: MeasuredComparison, setting: Setting, drawn: Columns) -> Placed:
    """Place the samples on the time axis of the figures by the phase at which the measurement begins.

    The phase is the reference's or, where that does not repeat itself, the penalty solution's. Samples of all periods
    are drawn over each other. There are none where the measurement is not in step with the excitation. ``drawn`` is the
    source "displacements" of the figures: where a motion repeats itself after several periods, it says with which of
    them the figures begin.
    """
    own, eta = comparison.recurrence, setting.eta
    solver = next((name for name in SOLVERS if getattr(comparison, name).alignment), "")
    if not solver or own.period == 0 or comparison.other_eta is not None:
        return NOWHERE
    solved = getattr(comparison, solver)
    shown = _at_mean(comparison.measurement, solved.alignment)
    turns, values, velocity = _folded(shown, eta, solved.alignment.phase, solved.period, own.period)
    drive = setting.system.excitation
    turned = 2 * math.pi * turns + drive.base_phase
    base = drive.base_amplitude(eta) * np.array([np.cos(turned), -eta * np.sin(turned)])
    if comparison.measurement.frame == "absolute":
        values, velocity = values - base[0], velocity - base[1]
    phase = dict(zip(_PHASE, (values[0], velocity[0], values[1], velocity[1]), strict=True))
    shown = values + base[0] if setting.frame == "absolute" else values
    found = [convert_units(_in_window(turns + shift, shown, solved.period), setting) for shift in range(solved.period)]
    best = min(found, key=lambda columns: _distance(columns, drawn, solver))
    columns = (
        NOWHERE.displacements if setting.frame == "difference" else best,
        convert_units(phase, setting),
    )
    return Placed(*({name: np.asarray(each, np.float32) for name, each in one.items()} for one in columns))


def _at_mean(measurement: Measurement, aligned: Alignment) -> Measurement:
    """The measurement; displacements without their mean are placed about that of the solution."""
    if measurement.mean_known:
        return measurement
    return replace(measurement, displacement=measurement.displacement - aligned.offset[:, None])


def _folded(measurement: Measurement, eta: float, phase: float, *periods: int):
    """Excitation periods since the beginning of the cycle, displacements and velocities of evenly chosen samples.

    Neighbours in the folded order give the velocity, so that all periods take part in it.
    """
    length = 2 * math.pi / eta
    time = np.mod(measurement.time + phase, length * math.lcm(*periods))
    order = np.argsort(time, kind="stable")
    folded = Measurement(time[order], measurement.displacement[:, order], None, measurement.frame)
    chosen = np.unique(np.linspace(0, len(time) - 1, min(_MOST_POINTS, len(time))).astype(int))
    both = np.full((2, 2, len(chosen)), np.nan)  # displacements and velocities of both bodies, nan if not measured
    both[0, : len(folded.displacement)] = folded.displacement[:, chosen]
    both[1, : len(folded.displacement)] = folded.velocity(_SLOPE * length)[:, chosen]
    return folded.time[chosen] / length, *both


def _in_window(turns: np.ndarray, values: np.ndarray, period: int) -> Columns:
    """Samples at these excitation periods, folded into the window of the figures, each of them once."""
    time = np.mod(turns, period) + period * (np.arange(len(turns)) % max(1, SHOWN_PERIODS // period))
    order = np.argsort(time, kind="stable")
    order = order[time[order] <= SHOWN_PERIODS]
    return {"t": time[order], "x1": values[0, order], "x2": values[1, order]}


def _distance(columns: Columns, drawn: Columns, solver: str) -> float:
    return sum(
        float(np.nansum((columns[f"x{k}"] - np.interp(columns["t"], drawn["t"], drawn[f"{solver}{k}"])) ** 2))
        for k in (1, 2)
    ) / max(len(columns["t"]), 1)
