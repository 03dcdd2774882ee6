"""Measured data: read completely or refused with line and column; laid over the motion that they show."""

import re

import hypothesis.strategies as st
import numpy as np
import pytest
from hypothesis import given
from vibroscope.engine import (
    Measurement,
    Newmark,
    Record,
    Reference,
    System,
    Units,
    compare_measured,
    measured_verdict,
    measurement_text,
    read_measurement,
    simulate,
    synthetic_measurement,
)
from vibroscope.engine.measurement.alignment import align
from vibroscope.engine.measurement.cycle import reference_cycle
from vibroscope.engine.measurement.measured import FEWEST_SAMPLES, SIZE_LIMIT, parse_measurement
from vibroscope.engine.measurement.recurrence import recurrence, sensor

UNITS = Units(omega1=5.0, m1=2.0, base_amplitude=0.5)
ROWS = [f"{0.1 * i:.1f},{i},{-i}" for i in range(FEWEST_SAMPLES)]
HEADER = "time [s],x1 [mm],x2 [mm]"


def text(header=HEADER, rows=ROWS, end="\n"):
    return end.join([header, *rows]).encode()


def changed(line, row, rows=ROWS):
    """The rows with another one in that line of the file."""
    return [*rows[: line - 2], row, *rows[line - 1 :]]


# ------------------------------------------------------------------------------------------------------- the file


def test_what_is_written_is_read(tmp_path):
    made = synthetic_measurement(System(), 1.08, periods=2, phase=0.3)
    path = tmp_path / "m.csv"
    path.write_text(measurement_text(made, UNITS, "two\nlines"), encoding="utf-8")
    found = read_measurement(path, UNITS)
    assert found.frame == "absolute"
    assert found.time == pytest.approx(made.time, abs=1e-7)
    assert found.displacement == pytest.approx(made.displacement, abs=1e-6)
    assert (found.contact == made.contact).all()
    assert found.contact.any()


@pytest.mark.parametrize(
    "content",
    [
        text(end="\r\n"),
        text(end="\r"),
        text(rows=[f"{0.1 * i - 7:.1f},{i},{-i}" for i in range(FEWEST_SAMPLES)]),
        b"\xef\xbb\xbf" + text(),
        b"# made by hand\n\n" + text() + b"\n\n# the end\n",
        text("time [s]; x1 [mm]; x2 [mm]", [row.replace(",", "; ") for row in ROWS]),
        text("time [s];x1 [mm];x2 [mm]", [row.replace(",", ";").replace(".", ",") for row in ROWS]),
        text("time [s]\tx1 [mm]\tx2 [mm]", [row.replace(",", "\t") for row in ROWS]),
        text("time [ms], x1 [µm], X2 [m]", [f"{100 * i},{1000 * i},{-i / 1000}" for i in range(FEWEST_SAMPLES)]),
        text('"time [s]","x1 [mm]","x2 [mm]"'),
        text("x2 [mm],time [s],x1 [mm]", [",".join(np.roll(row.split(","), 1)) for row in ROWS]),
        text("time,x1,x2 [-]", [f"{0.5 * i},{2 * i},{-2 * i}" for i in range(FEWEST_SAMPLES)]),
    ],
)
def test_every_spelling_of_one_measurement_reads_alike(content):
    found = parse_measurement(content, UNITS)
    steps = np.arange(FEWEST_SAMPLES)
    assert found.time == pytest.approx(0.5 * steps)  # τ = ω₁t
    assert found.displacement == pytest.approx(np.array([2.0 * steps, -2.0 * steps]))  # in base amplitudes
    assert found.contact is None


def test_relative_displacements_and_a_contact_channel_are_told_by_their_names():
    rows = [f"{row},{i % 2}" for i, row in enumerate(ROWS)]
    found = parse_measurement(text("time [s],xi1 [mm],xi2 [mm],contact", rows))
    assert found.frame == "relative"
    assert (found.contact == np.arange(FEWEST_SAMPLES) % 2).all()


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (b"", "line 1: the file has no header"),
        (b"# nothing\n", "line 1: the file has no header"),
        (text("time [s],x1 [mm],y [mm]"), "line 1, column 3: unknown column 'y"),
        (text("time [s],x1 [mm],x1 [mm]"), "line 1, column 3: a second column x1"),
        (text("time [s],x1 [mm],xi2 [mm]"), r"line 1: columns time, x1, xi2; give time and either x1, x2"),
        (text("time [s],x1 [mm]", ["0,1"]), "line 1: columns time, x1; give"),
        (text("time [h],x1 [mm],x2 [mm]"), r"line 1, column 1 \(time\): unknown unit 'h'; known: s, ms"),
        (text("time [s],x1 [inch],x2 [mm]"), r"line 1, column 2 \(x1\): unknown unit 'inch'"),
        (text("time [s],x1 [-],x2 [-]"), "line 1: mixes columns with and without a unit"),
        (text("time,x1 [mm],x2"), "line 1: mixes"),
        (text(rows=changed(4, "0.2,abc,1")), r"line 4, column 2 \(x1\): 'abc' is no finite number"),
        (text(rows=changed(4, "0.2,1,nan")), r"line 4, column 3 \(x2\): 'nan' is no finite number"),
        (text(rows=changed(4, "0.2,1_0,1")), r"line 4, column 2 \(x1\): '1_0' is no finite number"),
        (text(rows=changed(4, "0.2,,1")), r"line 4, column 2 \(x1\): '' is no finite number"),
        (text(rows=changed(4, "0.1,1,1")), r"line 4, column 1 \(time\): '0.1' does not come after"),
        (text(rows=changed(4, "0.2,1")), "line 4: 2 columns, the header has 3; decimal commas need semicolons"),
        (text(rows=changed(4, "0,2,1,5,1,0")), "line 4: 6 columns"),
        (text(rows=changed(4, '0.2,"1,1')), r"line \d+: not CSV"),
        (text(rows=changed(4, "0.2,1e12,1")), r"line 4, column 2 \(x1\): '1e12' is .* in units of the model"),
        (text("time,x1,x2,contact", [f"{row},0.5" for row in ROWS]), r"line 2, column 4 \(contact\): '0.5' is neither"),
        (b"# a\n\n" + text(rows=changed(4, "x,1,1")), r"line 6, column 1 \(time\)"),
        (text("time;x1;x2", ["0;1.000,5;1"]), r"line 2, column 2 \(x1\): '1.000,5' is no"),
        (text(rows=ROWS[:-1]), f"the file ends after {FEWEST_SAMPLES - 1} samples"),
        (text(rows=changed(3, "0.1,\xff,1")).decode().encode("latin-1"), "line 3: not UTF-8"),
        (b"#" * (SIZE_LIMIT + 1), "larger than 16 MiB"),
    ],
)
def test_what_is_wrong_is_told_with_line_and_column(content, words):
    with pytest.raises(ValueError, match=words) as caught:
        parse_measurement(content)
    assert "\n" not in str(caught.value)


def test_a_file_that_cannot_be_read_is_named(tmp_path):
    with pytest.raises(ValueError, match=r"nowhere\.csv: cannot be read: No such file"):
        read_measurement(tmp_path / "nowhere.csv")


CELLS = st.sampled_from(
    ["time", "x1 [mm]", "xi2", "contact", "[s]", "0", "1", "-1e308", "1,5", '"', "\x00", "1e999", "٣", ""]
)
LINES = st.lists(CELLS, max_size=5).flatmap(lambda cells: st.sampled_from(",;\t").map(lambda sign: sign.join(cells)))
FILES = st.lists(LINES, max_size=6).map(lambda lines: "\n".join(lines).encode())
BROKEN = st.tuples(st.integers(0, len(text())), st.binary(max_size=4)).map(
    lambda at: text()[: at[0]] + at[1] + text()[at[0] :]
)


@given(st.one_of(st.binary(max_size=300), FILES, BROKEN))
def test_any_bytes_give_a_measurement_or_a_line(content):
    words = None
    try:
        found = parse_measurement(content)
    except ValueError as problem:
        words = str(problem)
    if words is not None:
        assert words.startswith("line ")
        assert "\n" not in words
    else:
        assert np.isfinite(found.time).all()
        assert np.isfinite(found.displacement).all()
        assert (np.diff(found.time) > 0).all()


# ------------------------------------------------------------------------------------------------------ alignment


@pytest.mark.parametrize("eta", [1.08, 2.76, 3.25])
@pytest.mark.parametrize("frame", ["absolute", "relative"])
def test_the_phase_is_found_again(eta, frame):
    _, cycle = reference_cycle(System(), eta, Reference())
    for phase in np.linspace(0.01, 0.99, 5) * cycle.length:
        made = synthetic_measurement(System(), eta, phase=phase, noise=0.0, frame=frame)
        found = align(cycle, made)
        assert found.phase == pytest.approx(phase, abs=1e-7)
        assert found.rms < 1e-7
        assert found.closing_error < 1 / 200  # a sample
        told = sensor(made.time, made.contact, eta)
        assert found.sensor.per_period == pytest.approx(told.per_period)
        assert found.sensor.share == pytest.approx(told.share)


def test_the_cycle_is_the_motion_between_its_samples():
    # the section of the steady motion, marched on by a run with five times the samples
    _, cycle = reference_cycle(System(), 1.08, Reference())
    start = cycle.response.section[-1]
    run = simulate(System(), 1.08, Reference(), periods=2, keep=1, initial=start, record=Record(1, 10_000))
    time = run.trajectory.time - run.window[0]
    assert cycle.displacement(time[:-1]) == pytest.approx(run.trajectory.displacement[:, :-1], abs=1e-6)
    struck = np.abs(time[:, None] - cycle.closings).min(axis=1) < 1e-6
    smooth = ~struck & (time > 0) & (time < cycle.length)
    assert cycle.velocity(time[smooth]) == pytest.approx(run.trajectory.velocity[:, smooth], abs=1e-4)


def test_noise_is_measured_and_a_double_period_is_seen():
    for eta, noise, period in ((1.08, 0.05, 1), (2.76, 0.05, 1), (3.25, 0.05, 2), (3.25, 0.2, 2)):
        found = recurrence(synthetic_measurement(System(), eta, noise=noise, periods=12, seed=3), eta)
        assert found.period == period
        assert found.noise == pytest.approx(noise, rel=0.1)
        assert found.eta == pytest.approx(eta, rel=1e-3)


def test_samples_need_not_be_evenly_spaced():
    made = synthetic_measurement(System(), 2.76, noise=0.01, per_period=400, phase=1.0)
    some = np.sort(np.random.default_rng(5).choice(len(made), 900, replace=False))
    thin = Measurement(made.time[some], made.displacement[:, some], None, made.frame)
    _, cycle = reference_cycle(System(), 2.76, Reference())
    assert align(cycle, thin).phase == pytest.approx(1.0, abs=1e-3)
    assert recurrence(thin, 2.76).period == 1


# --------------------------------------------------------------------------------------------------- the comparison

FINE = Newmark(12000, 18, 8000)
WRONG = Newmark(100, 50, 2000)


def verdict(eta, measurement, penalty=FINE, system=None):
    return measured_verdict(compare_measured(system or System(), eta, measurement, penalty, periods=300))


def test_both_solvers_are_judged():
    made = synthetic_measurement(System(), 2.76, noise=0.02)
    found = compare_measured(System(), 2.76, made, FINE, periods=300)
    assert found.reference.alignment.rms < found.penalty.alignment.rms < 0.05
    assert found.reference.impacts_per_period == 1
    assert measured_verdict(found).startswith("The reference agrees within the noise of the measurement (0.7%).")
    assert "penalty solution follows the measurement to" in measured_verdict(found)


def test_a_wrong_penalty_is_told():
    made = synthetic_measurement(System(), 1.08, noise=0.02)
    found = compare_measured(System(), 1.08, made, WRONG)
    assert found.penalty.alignment.rms > 0.1
    words = measured_verdict(found)
    assert f"The penalty solution is {found.penalty.alignment.rms:.1%} off" in words
    assert "would close the sensor 1 times a period" in words


def test_other_motion_is_told():
    assert "not in step with an excitation at eta = 2.76; its strongest frequency is 1.08" in verdict(
        2.76, synthetic_measurement(System(), 1.08, periods=12)
    )
    assert "was excited at eta = 2.76" in verdict(2.80, synthetic_measurement(System(), 2.76))
    assert "the measurement every 2 periods: another motion" in verdict(
        3.25, synthetic_measurement(System(), 3.25), system=System(restitution=0.1, d1=0.2, d2=0.2)
    )
    assert re.match(
        r"The reference is \d\.\d% off\.", verdict(2.76, synthetic_measurement(System(restitution=0.7), 2.76))
    )


def test_columns_in_the_wrong_frame_are_told():
    made = synthetic_measurement(System(), 1.08, noise=0.01)
    misread = Measurement(made.time, made.displacement, made.contact, "relative")
    assert "If the columns are x1, x2 (absolute), the reference is 0.5% off: name them so." in verdict(1.08, misread)


def test_too_short_a_measurement_is_refused():
    made = synthetic_measurement(System(), 2.76, periods=1)
    short = Measurement(made.time[:100], made.displacement[:, :100], None, made.frame)
    with pytest.raises(ValueError, match=r"covers 0\.495 periods"):
        compare_measured(System(), 2.76, short, FINE)


def test_a_solution_that_blows_up_is_told():
    made = synthetic_measurement(System(), 2.76)
    found = compare_measured(System(), 2.76, made, Newmark(60000, 1, 100), periods=300)
    assert found.penalty.alignment is None
    assert "The penalty solution ended early (diverged)." in measured_verdict(found)
