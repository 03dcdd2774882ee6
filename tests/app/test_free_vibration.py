"""Where nothing drives the bodies, each view says in one sentence what it cannot show, why, and what to do."""

import json
import math
import re

import numpy as np
import pytest
from vibroscope.app.commands.cli import main
from vibroscope.app.explorer.compute import SHOWN_PERIODS, compute_runs
from vibroscope.app.explorer.explanation import describe, explain
from vibroscope.app.explorer.parameters import START_FIELDS
from vibroscope.app.explorer.present import present
from vibroscope.app.explorer.presets import shelf
from vibroscope.app.explorer.state import Setting
from vibroscope.app.export.scripts import as_command
from vibroscope.app.page.bifurcation.tab import Bifurcation
from vibroscope.app.page.explore.figures import MotionView
from vibroscope.app.page.shared.figure import time_label
from vibroscope.app.page.study.basin import Basins
from vibroscope.app.page.study.plane import Plane
from vibroscope.app.page.study.speed import Speed
from vibroscope.app.page.study.time_step import TimeStep
from vibroscope.app.page.tab import Move
from vibroscope.app.studies.your_code import grow_code, question_of
from vibroscope.engine import System, compare_measured, measured_verdict, synthetic_measurement, system_text

from tests.app.fakes import Asked, FakeHost
from tests.app.test_study_tab import opened  # noqa: F401 - a fixture

FREE = shelf()["thrown"].setting
AT_REST = FREE._replace(**dict.fromkeys(START_FIELDS, 0.0))
WORDS = {
    Bifurcation: "no motion belongs to a frequency: let the base or a force move them",
    Plane: "each cell of this plane begins at rest, where nothing moves: let the base",
    Basins: "each start leads to rest: let the base",
    TimeStep: "this study needs a motion that lasts: let the base",
    Speed: "this measurement begins at rest, where nothing moves: let the base",
}


@pytest.mark.parametrize("kind", WORDS)
def test_a_study_says_why_it_has_nothing_to_show_and_computes_nothing(opened, kind):  # noqa: F811
    tab, host = opened(kind)
    (driven,) = Asked.all
    free = AT_REST if kind is Speed else FREE
    tab.show(Move(2, free))
    assert driven.cancelled
    assert len(Asked.all) == 1
    ((head, text),) = tab.panel.statements
    assert (head, WORDS[kind] in text, text.count(".")) == ("Nothing to show", True, 1)
    assert tab.summary(free) == host.summary == text
    assert not any(plot.visible for plot in tab.view.figures.values())
    assert tab.figures() == []
    assert tab.panel.status == {}
    tab.show(Move(3, Setting()))
    assert len(Asked.all) == 2
    assert {plot.visible for plot in tab.view.figures.values()} == {True}
    assert tab.panel.statements == []


def test_the_speed_of_a_free_vibration_is_measured():
    assert Speed(FakeHost()).obstacle(FREE) == ""
    assert "begins at rest" in TimeStep(FakeHost()).obstacle(AT_REST)


def test_a_diagram_over_another_number_needs_an_own_start():
    tab = Bifurcation(FakeHost())
    tab.build()
    tab.view.sweep("restitution")
    assert "this diagram begins at rest" in tab.obstacle(FREE)
    tab.panel.chosen = tab.panel.chosen | {"direction": "own"}
    assert tab.obstacle(FREE) == ""
    assert tab.obstacle(Setting()) == ""


def test_a_measurement_without_its_start_asks_for_it():
    measured = synthetic_measurement(System(), 2.76, periods=4)
    found = compare_measured(FREE.system, FREE.eta, measured, FREE.penalty, periods=60)
    assert measured_verdict(found).startswith(
        "Nothing drives the bodies, and they start at rest, so that nothing moves."
    )
    with pytest.raises(ValueError, match="nothing drives the bodies, so that they come to rest: give what drives them"):
        synthetic_measurement(FREE.system, FREE.eta)


@pytest.mark.parametrize(
    "command",
    ["simulate --solver reference", "motion --solver reference", "compare --K 1e4 --D 20 --steps 2000"],
)
def test_a_drop_needs_no_frequency(capsys, tmp_path, command):
    path = tmp_path / "drop.toml"
    path.write_text("[physical]\nmass1_kg = 2.0\nwall = true\nclearance_mm = 500.0\nconstant1_N = 19.62\n")
    assert main([*command.split(), "--system", str(path), "--initial=-0.5,0,0,0"]) == 0
    assert "eta = 1" in capsys.readouterr().out


def test_the_command_fits_the_restitution_to_a_drop(capsys, tmp_path):
    """A mass falls 1 m on a floor; its rebounds follow from the restitution 0.7."""
    (tmp_path / "drop.toml").write_text(
        "[physical]\nmass1_kg = 1.0\nstiffness1_N_per_m = 1e-4\nwall = true\nclearance_mm = 1000.0\n"
        "length_mm = 1000.0\nconstant1_N = 9.81\nfrequency_Hz = 1.0\nrestitution = 0.5\n"
    )
    (tmp_path / "drop.csv").write_text(
        "\n".join(["time [s],xi1 [m]", *(f"{t},{fallen(t)}" for t in range_of(0.01, 2))])
    )
    options = ["--K", "1e5 N/m", "--D", "0", "--steps", "3000", "--initial", "0,0,0,0", "--fit", "restitution"]
    files = ["--system", str(tmp_path / "drop.toml"), "--measured", str(tmp_path / "drop.csv")]
    assert main(["compare", *options, *files]) == 0
    said = capsys.readouterr().out
    assert "from the start, since nothing drives the bodies" in said
    assert float(said.partition("restitution")[2].split()[0]) == pytest.approx(0.7, abs=1e-5)
    assert "The reference follows the measurement to 0.0" in said


def range_of(step, end):
    return [round(step * i, 6) for i in range(round(end / step) + 1)]


def fallen(time, height=1.0, gravity=9.81, restitution=0.7):
    """The way down of a mass that is let go, in closed form."""
    touch, speed = math.sqrt(2 * height / gravity), restitution * math.sqrt(2 * height * gravity)
    if time < touch:
        return gravity * time**2 / 2
    time -= touch
    while time > 2 * speed / gravity:
        time -= 2 * speed / gravity
        speed *= restitution
    return height - speed * time + gravity * time**2 / 2


@pytest.mark.parametrize(("load", "words"), [(0, "nothing drives the bodies"), (0.5, "only constant forces act")])
def test_a_weight_is_named_where_it_is_all_that_acts(capsys, tmp_path, load, words):
    file = tmp_path / "free.toml"
    file.write_text(f"[excitation]\nbase = 0\nconstant1 = {load}\n")
    simulated = ["simulate", "--solver", "reference", "--eta", "1", "--periods", "2", "--system", str(file)]
    assert main(simulated) == 0
    assert words in capsys.readouterr().err


THROWN_FROM_AFAR = """[physical]
mass1_kg = 2
stiffness1_N_per_m = 1e6
damping1_Ns_per_m = 20
mass2_kg = 0.3
stiffness2_N_per_m = 0
restitution = 0.6
clearance_mm = 50
"""


def test_a_throw_from_afar_is_compared_where_the_bodies_meet(capsys, tmp_path):
    """Two periods of 8.9 ms are over before a hammer at 1 m/s has passed its 50 mm."""
    file = tmp_path / "thrown.toml"
    file.write_text(THROWN_FROM_AFAR)
    thrown = ["--system", str(file), "--initial", "0,0,0,-1 m/s"]
    contact = ["--K", "1e7 N/m", "--D", "40 N s/m", "--steps", "2000"]
    assert main(["compare", *thrown, *contact, "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["total"] > 0.01
    assert main(["peaks", *thrown, *contact]) == 0
    out = capsys.readouterr().out
    assert "Over periods 6 to 7;" in out
    assert re.search(r"closing speed +1 +1 .* m/s", out)  # the closing speed: nothing has slowed it down
    assert main(["simulate", "--solver", "reference", *thrown]) == 0
    out = capsys.readouterr().out
    assert "impacts           1 in 50 periods" in out
    assert "Nothing touches" not in out
    assert main(["motion", "--solver", "reference", *thrown]) == 0
    out = capsys.readouterr().out
    assert "they part, and do not meet again" in out
    assert "Nothing touches" not in out
    assert "not known" not in out
    assert main(["compare", "--system", str(file), "--initial", "0,0,0,1 m/s", *contact]) == 0
    assert "nothing touches in the first 2 periods T of this free vibration" in capsys.readouterr().out


def test_explore_shows_the_periods_in_which_a_throw_from_afar_meets():
    setting = FREE._replace(spring1=0.0, clearance=50.0)
    runs = compute_runs(setting)
    assert runs.reference.response.periods > runs.reference.response.keep == runs.penalty.response.keep == 2
    assert len(runs.reference.response.impacts) == 1
    assert time_label(setting) == "time t / s in periods 11 to 12"
    assert describe(runs).reference[0].startswith("Free vibration. 1 impact in 2 periods T, ")


def test_contacts_that_the_window_cuts_are_counted_and_named():
    """The thrown body touches at the start; after two periods of η = 1.8 another contact has just begun."""
    for eta, contacts in (
        (1.8, "3 contacts (one from the start on, one until the end)"),
        (3.0, "2 contacts (one from"),
    ):
        runs = compute_runs(FREE._replace(eta=eta, units="none"))
        described, figures = describe(runs), MotionView()
        assert f"Free vibration. {contacts}" in described.penalty[0]
        for source, columns in present(runs).items():
            figures.write(source, columns)
        figures.update(runs.setting, fresh=True)
        title = figures.figures["strip"].title.text
        for solver, text in (("reference", described.reference[0]), ("penalty", described.penalty[0])):
            number = re.search(r"Free vibration\. (.*) in 2 periods T, in contact (.* %)", text)
            assert f"{solver} {number[1]}, {number[2]} of the time" in title


def test_a_search_without_a_drive_points_to_one_contact(capsys, tmp_path):
    file = tmp_path / "thrown.toml"
    file.write_text(THROWN_FROM_AFAR)
    assert main(["recommend", "--system", str(file)]) == 2
    assert (
        "find K, D and the step of its contacts with vibroscope impact --system FILE --initial"
        in capsys.readouterr().err
    )


def test_a_ball_needs_no_unit_of_time_and_meets_the_floor_as_it_falls(capsys, tmp_path):
    file = tmp_path / "ball.toml"
    file.write_text("[physical]\nmass1_kg = 0.1\nwall = true\nrestitution = 0.7\nconstant1_N = 0.981\n")
    dropped = ["--system", str(file), "--initial", "-300 mm,0,0,0"]
    contact = ["--K", "1e6 N/m", "--restitution", "0.7", "--time-step", "10 us"]
    assert main(["impact", *dropped, *contact, "--json"]) == 0
    asked = json.loads(capsys.readouterr().out)["asked"]
    assert asked["speed_m_per_s"] == pytest.approx(math.sqrt(2 * 9.81 * 0.3), rel=1e-9)
    assert main(["compare", *dropped, "--K", "1e6 N/m", "--D", "3 N s/m", "--steps", "10 us"]) == 0
    assert "in the last 7 of 10 periods T" in capsys.readouterr().out
    assert main(["impact", "--system", str(file), *contact]) == 2
    assert "no bodies collide: give --initial, or --speed" in capsys.readouterr().err
    assert main(["impact", "--initial", "-300 mm,0,0,0", *contact]) == 2
    assert "--initial says how the bodies of a system meet: give --system" in capsys.readouterr().err


def test_the_damper_that_the_restitution_asks_for_is_named_for_a_drop(capsys, tmp_path):
    """c = 71.3 N s/m gives 0.7 in closed form: ζ of e = 0.7 is 0.113, of 0.1 kg on 1e6 N/m."""
    file = tmp_path / "ball.toml"
    file.write_text("[physical]\nmass1_kg = 0.1\nwall = true\nrestitution = 0.7\nconstant1_N = 0.981\n")
    asked = ["compare", "--system", str(file), "--initial", "-300 mm,0,0,0", "--K", "1e6 N/m", "--steps", "10 us"]
    assert main([*asked, "--D", "3 N s/m", "--units"]) == 0
    said = " ".join(capsys.readouterr().out.split())
    assert "D is to blame, since the contact rebounds with 0.98 of its speed in place of 0.7: 2D = 71.31 N·s/m" in said
    ratio = -math.log(0.7) / math.hypot(math.pi, math.log(0.7))
    assert 2 * ratio * math.sqrt(0.1 * 1e6) == pytest.approx(71.3, rel=1e-3)
    assert main([*asked, "--D", "71.31 N s/m"]) == 0
    said = " ".join(capsys.readouterr().out.split())
    assert "differ by 2.1 % (rms)" in said
    assert "blame" not in said


def test_a_drop_whose_periods_are_short_is_compared_up_to_its_second_contact(capsys, tmp_path):
    file = tmp_path / "drop.toml"
    fall = "mass1_kg = 2.0\nstiffness1_N_per_m = 0\nconstant1_N = 19.62\nwall = true\nclearance_mm = 50\n"
    file.write_text(f"[physical]\n{fall}restitution = 0.7\nfrequency_Hz = 2000\n")
    contact = ["--K", "1e6 N/m", "--D", "200 N s/m", "--steps", "0.01 ms", "--initial", "0,0,0,0", "--json"]
    assert main(["compare", "--system", str(file), *contact]) == 0
    found = json.loads(capsys.readouterr().out)
    touch = math.sqrt(2 * 0.05 / 9.81)
    last = math.ceil((1 + 2 * 0.7) * touch * 2000)
    assert f"in the last {last - math.floor(touch * 2000)} of {last} periods T" in found["verdict"]
    assert 20 < float(re.search(r"differ by ([\d.]+) %", found["verdict"])[1]) < 80  # its rebound is 0.80, not 0.7


def test_the_page_compares_a_free_vibration_over_as_many_periods_as_the_command(capsys, tmp_path):
    """Where a period is short beside a flight two of them hold one contact at most: the figures show them all."""
    short = FREE._replace(eta=4 * FREE.eta)
    runs = compute_runs(short)
    found = explain(runs)
    words = re.search(r"in the first (\d+) periods T .* differ by (\S+ %)", str(found.headline))
    assert int(words[1]) > SHOWN_PERIODS
    (tmp_path / "free.toml").write_text(system_text(short.system))
    *_, command = as_command(short._replace(units="none")).splitlines()
    assert main(re.sub(r"--system \S+", f"--system {tmp_path / 'free.toml'}", command).split()[1:]) == 0
    said = " ".join(capsys.readouterr().out.split())
    assert f"in the first {words[1]} periods T" in said
    assert f"differ by {words[2]} (rms)" in said
    shown = runs.penalty.trace, runs.reference.trace
    apart = np.interp(shown[0].time, shown[1].time, shown[1].displacement[0]) - shown[0].displacement[0]
    of_tab = next(partial for partial in grow_code(question_of(short), None, lambda: False) if partial.judged)
    assert of_tab.judged[0].outcome.total == pytest.approx(found.parts["total"])  # what is set, among the rules
    drawn = found.series["total"][0]
    assert np.abs(drawn).max() == pytest.approx(np.abs(apart).max(), rel=0.05)
    assert f"in {words[1]} periods T" in str(found.kinds["reference"])
    columns = present(runs)
    assert columns["displacements"]["t"][-1] == pytest.approx(int(words[1]) * short.period)
    assert len(columns["strip_penalty"]["left"]) >= 2
    assert time_label(short) == f"time t / s in the first {words[1]} periods"
