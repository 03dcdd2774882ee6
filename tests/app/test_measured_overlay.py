"""A measurement on the page: its upload, its errors, its verdict and fit, and where its points lie."""

import gzip
import re
import shlex

import numpy as np
import pytest
from vibroscope.app.commands.cli import main
from vibroscope.app.explorer import measured
from vibroscope.app.explorer.compute import compute_runs
from vibroscope.app.explorer.field_units import shown_text
from vibroscope.app.explorer.measured import LARGEST_FILE, MeasuredFile, fit_rows, own_eta, place
from vibroscope.app.explorer.present import present
from vibroscope.app.explorer.state import Setting
from vibroscope.app.export.formats import as_csv
from vibroscope.app.export.scripts import as_command
from vibroscope.app.export.tables import figure_table
from vibroscope.app.page.explore.measurement import Overlay
from vibroscope.app.runtime.files import ASSETS
from vibroscope.engine import (
    Fit,
    Measurement,
    System,
    Units,
    compare_measured,
    measured_verdict,
    measurement_text,
    parse_measurement,
    read_measurement,
    synthetic_measurement,
)

from tests.app.fakes import Document, QueueingHost, send

EXAMPLE = ASSETS / "example-measurement.csv"
SETTING = Setting(eta=2.76, K=12000.0, D=18.0, steps=2000)


@pytest.fixture
def overlay():
    drawn = []
    made = Overlay(QueueingHost(doc=Document()), lambda: drawn.append(True))
    made.drawn = drawn
    made.follow(SETTING)
    yield made
    made.close()


def upload(overlay, text, name="own.csv", *, wait=True):
    send(overlay.button, {"file": {"name": name, "size": len(text)}})
    for i in range(0, len(text), 3000):
        send(overlay.button, {"part": {"0": text[i : i + 1900], "1": text[i + 1900 : i + 3000]}})
    send(overlay.button, {"end": True})
    if wait:
        overlay.host.catch_up_until(lambda: overlay.panel.content["phase"] != "reading")
    return overlay.panel.content


def test_the_page_says_what_the_command_line_says(overlay):
    content = upload(overlay, EXAMPLE.read_text(encoding="utf-8"))
    measurement = read_measurement(EXAMPLE)
    found = compare_measured(SETTING.system, 2.76, measurement, SETTING.penalty, reference=SETTING.reference)
    assert content["words"] == measured_verdict(found).replace("eta", "η")
    assert content["headline"] == "η = 2.76, 481 samples over 4 periods, absolute displacements"
    assert content["rows"][3][:3] == ["begins at τ", "", "0.6996"]
    assert overlay.panel.visible
    assert overlay.drawn
    assert content["words"] in overlay.words["Measurement own.csv"]
    send(overlay.panel, {"remove": True})
    assert (overlay.panel.visible, overlay.words, overlay.arguments) == (False, {}, ("", "", False))


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (
            "time [s], x1 [mm], x2 [mm]\n0, 1, 2\n1, one, 2\n",
            "Line 3, column 2 (x1): 'one' is no finite number; correct it, or delete the line.",
        ),
        ("time, x1, x2\n0, 1, 2\n", "Line 3: the file ends after 1 samples; give at least 16."),
        ("", "Line 1: the file has no header; begin it with names and units of columns, as time [s], x1 [mm]."),
    ],
)
def test_a_file_that_cannot_be_read_is_refused_with_its_line(overlay, text, words):
    assert upload(overlay, text) == {"phase": "failed", "name": "own.csv", "error": words}
    assert len(overlay.placed(SETTING, {}).phase["x1"]) == 0


@pytest.mark.parametrize("message", [{"file": 5}, {"part": "x"}, {"fit": {"x": 1}}, {"fit": "mass"}, [], None])
def test_a_message_of_another_form_changes_nothing(overlay, message):
    send(overlay.button, message)
    assert overlay.panel.content == {"phase": "idle"}


def test_a_file_of_unknown_columns_asks_which_is_what_and_reads_them(overlay):
    lines = EXAMPLE.read_text(encoding="utf-8").replace("time [s], x1 [mm], x2 [mm]", "Zeit, Weg 1, Weg 2").splitlines()
    content = upload(overlay, "\n".join(lines))
    assert content["phase"] == "columns"
    assert content["header"] == ["Zeit", "Weg 1", "Weg 2", "contact"]
    send(overlay.panel, {"columns": {"time": "1 [s]", "x1": "2 [mm]", "x2": "2 [furlong]"}})
    overlay.host.catch_up_until(lambda: overlay.panel.content["phase"] != "reading")
    assert "unknown unit 'furlong'" in overlay.panel.content["error"]
    assert overlay.panel.content["phase"] == "columns"  # to choose again
    send(overlay.panel, {"columns": {"time": "1 [s]", "x1": "2 [mm]", "x2": "3 [mm]"}})
    overlay.host.catch_up_until(lambda: overlay.panel.content["phase"] != "reading")
    assert overlay.panel.content["words"].startswith("The reference agrees within the noise")
    last = as_command(SETTING, *overlay.arguments).splitlines()[-1]
    assert last.endswith("--measured own.csv --columns 'time=1 [s], x1=2 [mm], x2=3 [mm]'")


def test_a_move_of_eta_reads_a_file_again_only_where_its_numbers_depend_on_it(monkeypatch):
    parsed = []
    monkeypatch.setattr(measured, "parse_measurement", lambda *how: parsed.append(how) or parse_measurement(*how))
    plain = MeasuredFile("own.csv", EXAMPLE.read_bytes())
    assert plain.measurement(SETTING) is plain.measurement(SETTING._replace(eta=2.8))
    assert len(parsed) == 1
    of_page = MeasuredFile(
        "page.csv", b"series,time,xi1\n" + b"".join(b"penalty,%f,%d\n" % (i / 8, i) for i in range(20))
    )
    spans = [of_page.measurement(SETTING._replace(eta=eta)).span for eta in (1.0, 2.0, 2.0)]
    assert spans[0] == pytest.approx(2 * spans[1])
    assert len(parsed) == 3


def test_a_file_without_units_is_numbers_of_the_model_while_the_page_shows_no_units():
    plain = MeasuredFile("own.csv", b"time,xi1\n" + b"".join(b"%f,%d\n" % (i / 8, i) for i in range(20)))
    assert plain.measurement(SETTING).span == pytest.approx(19 / 8)
    with pytest.raises(ValueError, match=r"no column has a unit, .* as time \[s\], x1 \[mm\], or \[-\]"):
        plain.measurement(SETTING._replace(units="si"))


@pytest.mark.parametrize("header", ["time,xi1", "time [-],xi1 [-]", "time [s],xi1 [mm]"])
@pytest.mark.parametrize("units", ["none", "mm-t-s"])
def test_the_command_of_a_file_that_the_page_takes_runs(overlay, capsys, tmp_path, monkeypatch, header, units):
    """Own ω₁ convert columns with units, and do not ask for any."""
    setting = SETTING._replace(omega1=50.0, units=units)
    overlay.follow(setting)
    text = "\n".join([header, *(f"{i / 8},{np.sin(2.76 * i / 8)}" for i in range(400))])
    content = upload(overlay, text)
    monkeypatch.chdir(tmp_path)
    (tmp_path / "own.csv").write_text(text)
    *written, command = as_command(setting, *overlay.arguments).splitlines()
    if "--system system.toml" in command:
        (tmp_path / "system.toml").write_text("\n".join(written[1 : written.index("END")]))
    if content["phase"] == "failed":  # no unit where numbers have some
        assert (header, units) == ("time,xi1", "mm-t-s")
        return
    assert main(shlex.split(command)[1:]) == 0
    headline = capsys.readouterr().out
    assert re.search(r"(\d+ samples over \S+ periods)", content["headline"])[1] in headline


def test_a_wall_is_offered_what_it_has_and_one_body_is_drawn(overlay):
    setting = Setting(bodies="wall", eta=0.8, K=500.0, D=2.0, steps=500, d1=0.05, clearance=0.5, restitution=0.6)
    overlay.follow(setting)
    units = Units(setting.omega1, setting.m1, setting.amplitude)
    content = upload(overlay, measurement_text(synthetic_measurement(setting.system, 0.8), units, "synthetic"))
    assert content["names"] == ["restitution", "d1", "zero1"]
    assert "displacement of body 1" in content["headline"]
    points = overlay.placed(setting, present(compute_runs(setting))["displacements"])
    assert np.isfinite(points.displacements["x1"]).all()
    assert np.isnan(points.displacements["x2"]).all()


def test_the_csv_file_of_the_page_can_be_dropped_on_it(overlay):
    columns = present(compute_runs(SETTING))
    text = as_csv(figure_table("displacement", columns))
    content = upload(overlay, text)
    assert content["headline"].endswith("relative displacements; left out: 'other curves than reference'")
    assert content["words"].startswith("The reference agrees within the noise of the measurement")


def test_a_packed_file_is_read_and_refused_if_it_holds_too_much(overlay):
    packed = gzip.compress(EXAMPLE.read_bytes()).decode("latin-1")  # the browser sends a character for each byte
    assert "481 samples" in upload(overlay, packed)["headline"]
    packed = gzip.compress(b"0" * (LARGEST_FILE + 1)).decode("latin-1")
    assert upload(overlay, packed)["error"].startswith("Larger than 2 MiB")


def test_a_file_that_is_too_large_is_refused_before_it_is_sent(overlay):
    send(overlay.button, {"file": {"name": "long.csv", "size": LARGEST_FILE + 1}})
    assert "the page takes 2" in overlay.panel.content["error"]
    assert overlay.button.largest == LARGEST_FILE


def test_a_file_that_proves_larger_than_the_browser_says_is_refused(overlay):
    """What came after the limit was taken for the whole file."""
    send(overlay.button, {"file": {"name": "long.csv", "size": 5}})
    for _ in range(LARGEST_FILE // 120_000 + 2):
        send(overlay.button, {"part": {str(i): "1" * 1900 for i in range(64)}})
    send(overlay.button, {"end": True})
    assert overlay.panel.content["error"].startswith("The file has 2.2 MiB, and the page takes 2")


def test_a_move_of_the_sliders_keeps_the_points_that_the_reference_places(overlay):
    upload(overlay, EXAMPLE.read_text(encoding="utf-8"))
    drawn = present(compute_runs(SETTING))["displacements"]
    points = overlay.placed(SETTING, drawn)
    assert len(points.phase["x1"]) == 300
    softer = SETTING._replace(K=6000.0)
    overlay.follow(softer)
    assert overlay.panel.content["pending"]
    assert overlay.placed(softer, drawn) is points
    assert len(overlay.placed(SETTING._replace(eta=2.7), drawn).phase["x1"]) == 0


def test_a_fit_finds_the_constants_and_offers_them(overlay):
    upload(overlay, EXAMPLE.read_text(encoding="utf-8"))
    send(overlay.panel, {"fit": "restitution"})
    assert overlay.panel.content["fit"] == {"phase": "running"}
    overlay.host.catch_up_until(lambda: overlay.panel.content["fit"]["phase"] != "running")
    found = overlay.panel.content["fit"]
    assert float(found["use"]["restitution"]) == pytest.approx(0.5, abs=0.01)
    assert found["rows"][0][0] == "e"
    assert "±" in found["rows"][0][1]
    plain = re.match(r"(\S+), noise (\S+);", found["rows"][-1][1])
    overlay.follow(SETTING._replace(units="mm-t-s"))
    physical = re.match(r"(\S+) mm, noise (\S+) mm;", overlay.panel.content["fit"]["rows"][-1][1])
    for one, other in zip(plain.groups(), physical.groups(), strict=True):
        assert float(other) == pytest.approx(SETTING.amplitude * float(one), rel=0.01)
    overlay.follow(SETTING)
    overlay.follow(SETTING._replace(restitution=float(found["use"]["restitution"])))  # it is used
    assert overlay.panel.content["fit"] == {"phase": "idle"}


@pytest.mark.parametrize(
    ("error", "text"), [(0.0123, "0.500 +- 0.012"), (12.3, "0 +- 12"), (0.0, "0.5 +- 0"), (np.inf, "0.5, not shown")]
)
def test_a_constant_is_written_to_the_second_digit_of_its_error(error, text):
    numbers = {"phase": 0.0, "deviation": 0.0, "noise": 0.0, "agreeing": 1, "starts": 1, "remarks": ()}
    fitted = Fit(System(), {"restitution": 0.5}, {"restitution": error}, np.eye(1), **numbers)
    assert fit_rows(fitted)[0][1].startswith(text)


def placed(setting, eta, **made):
    units = Units(setting.omega1, setting.m1, setting.amplitude)
    text = measurement_text(synthetic_measurement(setting.system, eta, **made), units, "synthetic")
    measurement = MeasuredFile("x", text.encode()).measurement(setting)
    found = compare_measured(setting.system, setting.eta, measurement, setting.penalty, reference=setting.reference)
    columns = present(compute_runs(setting))
    return found, place(found, setting, columns["displacements"]), columns


@pytest.mark.parametrize(("phase", "frame"), [(0.4, "relative"), (2.6, "absolute")])
def test_points_lie_on_the_curve_they_were_sampled_from(phase, frame):
    """At η = 3.25 a cycle has two periods: the points must begin with the period that the figures begin with."""
    setting = Setting(eta=3.25, K=5000.0, D=15.0, steps=500, frame=frame, units="mm-t-s", omega1=20.0, amplitude=2.0)
    other = {"relative": "absolute", "absolute": "relative"}[frame]
    found, points, columns = placed(setting, 3.25, noise=0.0, phase=phase, frame=other)
    assert found.reference.period == 2
    times, drawn = points.displacements["t"], columns["displacements"]
    assert 0 <= times.min() < times.max() <= 2 * setting.period
    for k in "12":
        curve = np.interp(times, drawn["t"], drawn[f"reference{k}"])
        assert np.abs(points.displacements[f"x{k}"] - curve).max() < 0.02 * np.ptp(curve)
        orbit = columns["phase_reference"]
        assert np.ptp(points.phase[f"v{k}"]) == pytest.approx(float(np.ptp(orbit[f"v{k}"])), rel=0.1)
        off = [(orbit[n] - points.phase[n][:, None]) / np.ptp(orbit[n]) for n in (f"x{k}", f"v{k}")]
        assert np.median(np.hypot(*off).min(axis=1)) < 0.02


def test_points_begin_with_the_period_that_the_figures_begin_with():
    setting = Setting(eta=3.25, K=5000.0, D=15.0, steps=500)
    found, points, columns = placed(setting, 3.25, noise=0.0, phase=0.4)
    drawn = columns["displacements"]
    later = {name: drawn[name] if name == "t" else np.roll(drawn[name][:-1], 200) for name in drawn}
    later = {name: column[:400] for name, column in later.items()}  # the same cycle from its second period on
    moved = place(found, setting, later)
    curve = np.interp(moved.displacements["t"], later["t"], later["reference1"])
    inside = moved.displacements["t"] < 1.99
    assert np.abs(moved.displacements["x1"] - curve)[inside].max() < 0.02 * np.ptp(curve)
    assert not np.allclose(moved.displacements["x1"], points.displacements["x1"])


def test_a_measurement_of_another_frequency_has_no_place_and_its_own_is_offered():
    setting = SETTING._replace(eta=2.8)
    found, points, _ = placed(setting, 2.76, periods=8)
    assert float(own_eta(found)) == pytest.approx(2.76, abs=1e-3)
    assert len(points.phase["x1"]) == len(points.displacements["t"]) == 0
    words = shown_text(measured_verdict(found), Units(2 * np.pi, system="si"))  # η counts hertz
    assert words.startswith("The measurement was excited at f = 2.76 Hz, not at f = 2.8 Hz")


def test_the_velocity_of_a_sine_is_its_slope():
    time = np.sort(np.random.default_rng(1).uniform(0, 20, 2000))
    found = Measurement(time, np.stack([np.sin(time), np.cos(2 * time)]), None, "relative").velocity(0.1)
    assert np.abs(found - [np.cos(time), -2 * np.sin(2 * time)])[:, 20:-20].max() < 0.1


def test_files_to_take_away_hold_the_measurement():
    points = {"measured": {"displacements": {"t": [0.1], "x1": [1.0], "x2": [2.0]}, "phase": {}}}
    (series,) = figure_table("displacement", points)
    assert (series.label, dict(series.columns)) == ("measured", {"time": [0.1], "xi1": [1.0], "xi2": [2.0]})
    assert figure_table("force", points) == figure_table("displacement", {}) == []
    assert as_command(SETTING, "my run.csv").splitlines()[-1].endswith("--measured 'my run.csv'")
