"""Measurement files: read completely, or refused with line and column."""

import gzip

import hypothesis.strategies as st
import numpy as np
import pytest
from hypothesis import given
from vibroscope.engine import (
    Record,
    Reference,
    System,
    Units,
    measurement_text,
    read_measurement,
    simulate,
    synthetic_measurement,
)
from vibroscope.engine.measurement.measurement_file import FEWEST_SAMPLES, first_outlier, parse_measurement
from vibroscope.engine.measurement.measurement_table import MEASUREMENT_SIZE_LIMIT

UNITS = Units(omega1=5.0, m1=2.0, base_amplitude=0.5)
ROWS = [f"{0.1 * i:.1f},{i},{-i}" for i in range(FEWEST_SAMPLES)]
HEADER = "time [s],x1 [mm],x2 [mm]"


def text(header=HEADER, rows=ROWS, end="\n"):
    return end.join([header, *rows]).encode()


def _semicolons(scale=1):
    """The rows with decimal commas and another unit of time."""
    return [f"{0.1 * scale * i:.3f};{i};{-i}".replace(".", ",") for i in range(FEWEST_SAMPLES)]


def labview(instants, unit="mm"):
    """What LabVIEW writes with no, one or several columns of the instants, and decimal commas."""
    gap = "\t\t" if instants == "Multi" else "\t"

    def tag(name, value):
        return f"{name}\t{gap.join([value] * 2)}\t"

    def row(time, *values):
        if instants == "Multi":
            return f"{time}\t{values[0]}\t{time}\t{values[1]}"
        return "\t".join([time if instants == "One" else "", *values])

    return "\r\n".join(
        [
            "LabVIEW Measurement\t",
            "Writer_Version\t2",
            "Separator\tTab",
            "Decimal_Separator\t,",
            f"X_Columns\t{instants}",
            "Date\t2019/07/22",
            "Time\t17:18:18,938945770263671875",
            "***End_of_Header***\t",
            "\t",
            "Channels\t2\t\t",
            tag("Samples", "16"),
            tag("Date", "2019/07/22"),
            tag("Time", "17:18:18,938945770263671875"),
            tag("Y_Unit_Label", unit),
            tag("X_Dimension", "Time"),
            tag("X0", "7,0000000000000000E+0"),
            tag("Delta_X", "0,100000"),
            "***End_of_Header***\t\t\t",
            "X_Value\tUntitled\t" + "X_Value\t" * (instants == "Multi") + "Untitled 1\tComment",
            *(row(f"{7 + 0.1 * i:.6f}", f"{i:.6f}", f"{-i:.6f}").replace(".", ",") for i in range(FEWEST_SAMPLES)),
            "",
        ]
    ).encode()


OPENSEES = (
    b'<?xml version="1.0"?>\n<OpenSees\nxmlns:xsi="http://www.w3.org/2001/XMLSchema-instance">\n<TimeOutput>\n'
    b"<ResponseType>time</ResponseType>\n</TimeOutput>\n<Data>\n"
    + b"\n".join(row.replace(",", " ").encode() + b" " for row in ROWS)
    + b"\n</Data>\n</OpenSees>\n"
)
CALCULIX = "".join(
    f"\n displacements (vx,vy,vz) for set N1 and time  {0.1 * i:.7E}\n\n         2  {i:.6E}  0.0E+00  0.0E+00\n"
    f"         3  0.0E+00  {-i:.6E}  0.0E+00\n"
    f"\n velocities (vx,vy,vz) for set N1 and time  {0.1 * i:.7E}\n\n         2  1.0E+01  0.0E+00  0.0E+00\n"
    f"         3  0.0E+00 -1.0E+01  0.0E+00\n"
    f"\n total force (fx,fy,fz) for set N1 and time  {0.1 * i:.7E}\n\n        1.0E+00  2.0E+00  3.0E+00\n"
    for i in range(FEWEST_SAMPLES)
)


def with_line(line, row):
    """The rows with another one in that line of the file."""
    return [*ROWS[: line - 2], row, *ROWS[line - 1 :]]


def test_a_written_file_is_read_back(tmp_path):
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
        gzip.compress(text()),
        text("time [ms], x1 [µm], x2 [m]", [f"{100 * i},{1000 * i},{-i / 1000}" for i in range(FEWEST_SAMPLES)])
        .decode()
        .encode("utf-16"),
        text().decode().encode("utf-16-le"),
        text("time [ms], x1 [µm], x2 [m]", [f"{100 * i},{1000 * i},{-i / 1000}" for i in range(FEWEST_SAMPLES)])
        .decode()
        .encode("utf-16-be"),
        text("time_s,x1_mm,X2_mm"),
        text("t [sec],x1 [mm],x2 [mm]"),
        text("Time_ms,x1_um,x2_m", [f"{100 * i},{1000 * i},{-i / 1000}" for i in range(FEWEST_SAMPLES)]),
        text("time [ms], x1 [µm], x2 [m]", [f"{100 * i},{1000 * i},{-i / 1000}" for i in range(FEWEST_SAMPLES)])
        .decode()
        .encode("latin-1"),
        text("time [s]  x1 [mm]  x2 [mm]", [row.replace(",", "   ") for row in ROWS]),
        text("time [s], x1 [mm], x2 [mm]", [row.replace(",", " ") for row in ROWS]),
        b"# of an oscilloscope\n# time [s] x1 [mm] x2 [mm]\n" + text("", [row.replace(",", " ") for row in ROWS]),
        b"% Model: drop\n% time [s]  x1 [mm]  x2 [mm]\n" + text("", [row.replace(",", " ") for row in ROWS]),
    ],
)
def test_every_format_of_the_same_measurement_is_read_alike(content):
    found = parse_measurement(content, UNITS)
    steps = np.arange(FEWEST_SAMPLES)
    assert found.time == pytest.approx(0.5 * steps)  # τ = ω₁t
    assert found.displacement == pytest.approx(np.array([2.0 * steps, -2.0 * steps]))  # in base amplitudes
    assert found.contact is None


@pytest.mark.parametrize(
    ("content", "columns"),
    [
        (b"sep=;\n" + text("time [s];x1 [mm];x2 [mm]", [row.replace(",", ";") for row in ROWS]), None),
        (text("time [s],x1 [mm],x2 [mm],", [f"{row}," for row in ROWS]), None),
        (text("time,x1,x2", ["(s),(mm),(mm)", *ROWS]), None),
        (text("time (s),x1 (mm),x2/mm"), None),
        (text("no,x1 [mm],time [s],F [N],x2 [mm]", [f"{i},{i},{0.1 * i},9,{-i}" for i in range(FEWEST_SAMPLES)]), None),
        (text("time_s,disp_mm,displacement_mm"), {"x1": "disp_mm", "x2": "3", "time": "time"}),
        (text("Zeit [s],Weg,Weg 2 [mm]"), {"time": "Zeit", "x1": "2 [mm]", "x2": "Weg 2 [mm]"}),
        (
            b"\n".join(row.replace(",", "   ").encode() + b" " for row in ROWS),
            {"time": "1 [s]", "x1": "2 [mm]", "x2": "3 [mm]"},
        ),
        (  # PicoScope
            text("Time;Channel A;Channel B", ["(ms);(mV);(V)", "", *_semicolons(scale=1000)]),
            {"time": "Time", "x1": "Channel A [mm]", "x2": "Channel B [mm]"},
        ),
        *(
            (labview(instants), {"time": "time", "x1": "Untitled", "x2": "Untitled 1"})
            for instants in ("No", "One", "Multi")
        ),
        (labview("One", "Volts"), {"time": "1", "x1": "2 [mm]", "x2": "3 [mm]"}),
        (OPENSEES, {"time": "1 [s]", "x1": "2 [mm]", "x2": "3 [mm]"}),
        (CALCULIX.encode(), {"time": "time [s]", "x1": "vx 2 [mm]", "x2": "vy 3 [mm]"}),
    ],
)
def test_what_instruments_write_is_read(content, columns):
    found = parse_measurement(content, UNITS, columns)
    steps = np.arange(FEWEST_SAMPLES)
    assert found.time == pytest.approx(0.5 * steps)
    assert found.displacement == pytest.approx(np.array([2.0 * steps, -2.0 * steps]))


def test_instants_that_labview_has_written_are_not_those_of_its_even_step():
    last = f"{7 + 0.1 * (FEWEST_SAMPLES - 1):.6f}".replace(".", ",").encode()
    columns = {"time": "time", "x1": "Untitled", "x2": "Untitled 1"}
    found = parse_measurement(labview("One").replace(last, b"9,500000"), UNITS, columns)
    since = found.time - found.time[0]
    assert since[-1] / since[1] == pytest.approx(25)


def test_one_body_is_enough_and_other_columns_are_named_as_left_out():
    found = parse_measurement(text("time [s],xi1 [mm],Temp [C]"), UNITS)
    assert found.displacement.shape == (1, FEWEST_SAMPLES)
    assert found.left_out == ("Temp [C]",)


def test_titles_above_the_header_and_words_below_the_data_are_left_out_by_line():
    found = parse_measurement(b"Test 12\nof a bearing\n\n" + text() + b"\n\nEnd of measurement\n", UNITS)
    assert len(found) == FEWEST_SAMPLES
    assert found.left_out == ("Test 12 … (lines 1 to 2)", "End of measurement (line 22)")


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (gzip.compress(b" " * (MEASUREMENT_SIZE_LIMIT + 1), mtime=0), "larger than 16 MiB"),
        (gzip.compress(text(), mtime=0)[:40], "line 1: the gzip file is damaged"),
        (text().replace(b"x1", b"x\0001"), "line 1: a byte 0, so that this is no text"),
        (b"PK\x03\x04\n\0\0", "line 2: a byte 0, so that this is no text; save the file as CSV"),
        (text(rows=["(furlong),(mm),(mm)", *ROWS]).replace(b" [mm]", b"").replace(b" [s]", b""), "unit 'furlong'"),
        (text(rows=["Uhr,links,rechts", *ROWS]), r"line 2, column 1 \(time\): 'Uhr' is no finite number"),
        (text(rows=with_line(4, "0.2,∞,-∞")), r"line 4, column 2 \(x1\): '∞' is no finite number; .*delete the line"),
        (
            CALCULIX.replace("1.0000000E-01", "0.0000000E+00").encode(),
            "line 18: a second value of node 2 at the time 0",
        ),
    ],
)
def test_what_cannot_be_read_of_an_instrument_is_refused(content, words):
    with pytest.raises(ValueError, match=words):
        parse_measurement(content, UNITS)


def test_the_bodies_are_in_contact_while_the_force_is_a_share_of_its_largest():
    force = [0, 0, 3, 60, 2, 0] * 3
    found = parse_measurement(text("time [s],x1 [mm],force [N]", [f"{i},0,{f}" for i, f in enumerate(force)]))
    assert (np.flatnonzero(found.contact) == [3, 9, 15]).all()


@pytest.mark.parametrize(
    ("columns", "words"),
    [
        ({"time": "1", "x3": "2"}, "unknown column name 'x3'; known: time, x1"),
        ({"time": "1", "x1": "4"}, "no column '4' for x1: give its number, 1 to 3, or one of 'time"),
        ({"x1": "2"}, "give time and either"),
    ],
)
def test_columns_that_are_chosen_wrongly_are_named(columns, words):
    with pytest.raises(ValueError, match=words):
        parse_measurement(text(), UNITS, columns)


def test_columns_of_a_file_without_header_need_units():
    """As those of a record: they were taken for numbers without dimension."""
    content = b"\n".join(row.encode() for row in ROWS)
    with pytest.raises(ValueError, match=r"line 1 \(no header\): nothing says .* or give each column its unit"):
        parse_measurement(content, UNITS, {"time": "1", "x1": "2"})
    assert len(parse_measurement(content, UNITS, {"time": "1 [-]", "x1": "2 [-]"}))


def test_a_file_of_the_page_is_read_with_its_time_in_periods():
    rows = [f"{name},{i / 8},{i}" for name in ("reference", "penalty") for i in range(20)]
    content = text("series,time,xi1", rows)
    found = parse_measurement(content, eta=2.0, physical=True)
    assert found.time == pytest.approx(np.arange(20) * np.pi / 8)
    assert found.left_out == ("other curves than reference",)
    with pytest.raises(ValueError, match="time in periods and accelerations need the excitation frequency: give eta"):
        parse_measurement(content)


@pytest.mark.parametrize("spike", [9999.0, -9999.0, 40.0])
def test_an_outlier_is_refused_with_its_line(spike):
    made = synthetic_measurement(System(), 2.76, noise=0.02)
    lines = measurement_text(made, UNITS, "x").splitlines()
    cells = lines[200].split(", ")
    lines[200] = ", ".join([cells[0], cells[1], f"{spike:g}", cells[3]])
    with pytest.raises(ValueError, match=r"^line 201, column 3 \(x2\): an outlier, .* delete the line"):
        parse_measurement("\n".join(lines).encode(), UNITS)


@pytest.mark.parametrize(("eta", "per_period"), [(1.08, 200), (1.08, 2000), (2.76, 12), (2.76, 2000), (1.7, 100)])
def test_impacts_are_no_outliers(eta, per_period):
    run = simulate(System(), eta, Reference(), periods=200, keep=20, record=Record(20, per_period)).trajectory
    for noise in (0.0, 0.05):
        for each in run.displacement + noise * np.random.default_rng(1).standard_normal(run.displacement.shape):
            assert first_outlier(run.time, each) is None


def test_a_short_pulse_in_a_long_rest_is_no_outlier():
    time = np.linspace(0, 100, 5000)
    noise = 0.001 * np.random.default_rng(1).standard_normal(len(time))
    assert first_outlier(time, np.exp(-(((time - 50) / 0.2) ** 2)) + noise) is None


@pytest.mark.parametrize(("at", "offset"), [(0, 0.0), (1, 0.0), (2500, 0.0), (4999, 0.0), (2500, 1000.0)])
def test_sentinels_of_a_sensor_are_outliers_wherever_they_stand(at, offset):
    time = np.linspace(0, 100, 5000)
    values = np.sin(time) + offset
    values[at : at + 3] = -999.0
    assert first_outlier(time, values)[0] == at


def test_column_names_mark_relative_displacements_and_the_contact_sensor():
    rows = [f"{row},{i % 2}" for i, row in enumerate(ROWS)]
    found = parse_measurement(text("time [s],xi1 [mm],xi2 [mm],contact", rows))
    assert found.frame == "relative"
    assert (found.contact == np.arange(FEWEST_SAMPLES) % 2).all()


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (b"", "line 1: the file has no header"),
        (b"# nothing\n", "line 1: the file has no header"),
        (b",,,", "line 1: the header names no column; begin the file with: time"),
        (text("t [s],Disp [mm],other"), r"line 1: columns 't \[s\]', 'Disp \[mm\]', 'other'; give time and"),
        (b"\n".join(row.encode() for row in ROWS), r"line 1 \(no header\): nothing says what its numbers are"),
        (text("time [s],x1 [mm],x1 [mm]"), "line 1, column 3: a second column x1"),
        (
            text("time [s],x1 [mm],xi2 [mm]"),
            r"line 1: columns 'time \[s\]', 'x1 \[mm\]', .*; give time and either x1, x2",
        ),
        (text("time [s],x2 [mm]", ["0,1"]), "line 1: columns .*; give"),
        (text("time [h],x1 [mm],x2 [mm]"), r"line 1, column 1 \(time\): unknown unit 'h'; known: s, ms"),
        (text("time [s],x1 [furlong],x2 [mm]"), r"line 1, column 2 \(x1\): unknown unit 'furlong'"),
        (text("time [s],x1 [-],x2 [-]"), "line 1: mixes columns with and without a unit"),
        (text("time,x1 [mm],x2"), "line 1: mixes"),
        (text(rows=with_line(4, "0.2,abc,1")), r"line 4, column 2 \(x1\): 'abc' is no finite number"),
        (text(rows=with_line(4, "0.2,1,nan")), r"line 4, column 3 \(x2\): 'nan' is no finite number"),
        (text(rows=with_line(4, "0.2,1_0,1")), r"line 4, column 2 \(x1\): '1_0' is no finite number"),
        (text(rows=with_line(4, "0.2,,1")), r"line 4, column 2 \(x1\): '' is no finite number"),
        (
            text(rows=with_line(4, "0.1,1,1")),
            r"line 4, column 1 \(time\): '0.1' is the time of the sample before it, too; keep one",
        ),
        (text(rows=with_line(4, "0.2,1")), "line 4: 2 columns, the header has 3; complete the row, or delete it"),
        (text(rows=with_line(4, "0.05,1,1")), r"line 4, column 1 \(time\): '0.05' comes before .*; sort by time"),
        (text(rows=with_line(4, "End of test")), "line 4: 'End of test' is no row of 3 numbers; delete such lines"),
        (text(rows=with_line(4, "0,2,1,5,1,0")), "line 4: 6 columns, the header has 3; decimal commas need semicolons"),
        (text(rows=with_line(4, '0.2,"1,1')), r"line \d+: not CSV"),
        (text(rows=with_line(4, "0.2,1e12,1")), r"line 4, column 2 \(x1\): '1e12' is .* in units of the model"),
        (text("time,x1,x2,contact", [f"{row},0.5" for row in ROWS]), r"line 2, column 4 \(contact\): '0.5' is neither"),
        (b"# a\n\n" + text(rows=with_line(4, "x,1,1")), r"line 6, column 1 \(time\)"),
        (text("time;x1;x2", ["0;1.000,5;1"]), r"line 2, column 2 \(x1\): '1.000,5' is no"),
        (text(rows=ROWS[:-1]), f"the file ends after {FEWEST_SAMPLES - 1} samples"),
        (text(rows=with_line(3, "0.1,\xff,1")).decode().encode("latin-1"), r"line 3, column 2 \(x1\): 'ÿ' is no"),
        (b"#" * (MEASUREMENT_SIZE_LIMIT + 1), "larger than 16 MiB"),
    ],
)
def test_a_faulty_file_is_refused_with_line_and_column(content, words):
    with pytest.raises(ValueError, match=words) as caught:
        parse_measurement(content)
    assert "\n" not in str(caught.value)


def test_a_file_that_cannot_be_read_is_named_in_the_error(tmp_path):
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
def test_any_bytes_give_a_valid_measurement_or_an_error_of_one_line(content):
    found, message = None, ""
    try:
        found = parse_measurement(content)
    except ValueError as problem:
        message = str(problem)
    if found is None:
        assert message.startswith("line ")
        assert "\n" not in message
    else:
        assert np.isfinite(found.time).all()
        assert np.isfinite(found.displacement).all()
        assert (np.diff(found.time) > 0).all()
