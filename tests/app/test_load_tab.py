"""The view Pulse or record: its numbers are those of the engine, in any unit; a file, a wall, what is refused."""

import numpy as np
import pytest
from vibroscope.app.explorer.load_words import words_of_difference
from vibroscope.app.explorer.state import Setting
from vibroscope.app.export.scripts import load_command
from vibroscope.app.page.study.load import LoadTab
from vibroscope.app.page.tab import Move
from vibroscope.app.studies.load import LoadQuestion, Pulse
from vibroscope.engine import ExactPenalty, Load, Newmark, transient, transient_difference, written

from tests.app.fakes import QueueingHost, send

SETTING = Setting(eta=2.0, K=2500.0, D=8.0, steps=500)
METHOD = Newmark(2500.0, 8.0, 1000)  # the same time step in a natural period of body 1
RECORD = b"time [s], a [g]\n0, 0\n0.1, 0.2\n0.3, -0.1\n0.5, 0\n"


@pytest.fixture
def shown():
    """A function from a setting and choices to the view, once all is known."""
    tabs = []

    def show(setting, **chosen):
        tab = LoadTab(QueueingHost())
        tab.build()
        tabs.append(tab)
        tab.show(Move(1, setting))
        if chosen:
            send(tab.panel, {"choose": chosen})
        if not tab.obstacle(setting):
            tab.host.catch_up_until(lambda: is_complete(tab, setting))
        return tab

    yield show
    for tab in tabs:
        tab.close()


def is_complete(tab, setting):
    return tab.result is not None and tab.result.question == tab.question(setting) and tab.result.share == 1


def peaks_in(tab):
    return {cells[0]["text"]: cells[1:] for cells in (row["cells"] for row in tab.list.near["rows"])}


def test_numbers_are_those_of_the_engine_with_the_step_that_is_set(shown):
    tab = shown(SETTING, kind="trapezoid", size="2", duration="4", rise="1")
    load = Load.trapezoid(2.0, 4.0, 1.0)
    wanted = transient_difference(SETTING.system, load, METHOD, SETTING.reference, free=25.0)
    table = {series.label: series.columns for series in tab.table("load_peaks")}
    for solver in ("reference", "penalty"):
        np.testing.assert_equal({n: c[0] for n, c in table[solver].items()}, getattr(wanted, solver).peaks)
    assert words_of_difference(wanted.difference) in tab.words()["Do they agree?"]
    motion = {series.label: series.columns for series in tab.table("load_motion")}["penalty"]
    np.testing.assert_array_equal(motion["displacement2"], wanted.penalty.response.trajectory.displacement[1])
    assert tab.view.figures["load_course"].title.text == "Load: at most 2"


def test_units_are_those_that_are_shown(shown):
    setting = SETTING._replace(units="si", omega1=10.0, m1=2.0)
    tab = shown(setting, size="1 g", duration="300 ms")
    assert tab.panel.chosen["duration"] == pytest.approx(3.0)
    (course,) = tab.table("load_course")
    assert course.columns["load [m/s²]"].max() == pytest.approx(9.80665)
    assert course.columns["tau [s]"][-1] == pytest.approx(2.8)
    assert "contact force / N" in peaks_in(tab)
    assert "peak 9.807 m/s²; it ends at 300 ms, the run at 2.8 s" in tab.words()["Load"]


def test_a_file_is_the_load_that_its_columns_hold(shown):
    tab = shown(SETTING, kind="record")
    assert "Choose the file" in tab.words()["Nothing to show"]
    send(tab.panel, {"file": {"name": "quake.csv", "size": len(RECORD)}})
    send(tab.panel, {"part": {"0": RECORD.decode()}, "end": True})
    tab.host.catch_up_until(lambda: tab.result is not None and tab.result.share == 1)
    assert tab.panel.file == "quake.csv"
    assert "--base-record quake.csv" in tab.command(SETTING)
    run = transient(SETTING.system, tab.result.load, SETTING.reference, free=25.0)
    np.testing.assert_equal(tab.result.runs["reference"].peaks, run.peaks)
    send(tab.panel, {"file": {"name": "bad.csv", "size": 9}})
    send(tab.panel, {"part": {"0": "x\n1, 2\n"}, "end": True})
    tab.host.catch_up_until(lambda: "bad.csv" in str(tab.panel.file) and "Nothing to show" in tab.words())
    send(tab.panel, {"file": {"name": "large.csv", "size": 1e9}})
    assert "MiB" in tab.words()["Nothing to show"]


def test_a_load_out_of_range_says_why(shown):
    tab = shown(SETTING._replace(units="si", omega1=10.0), kind="trapezoid", duration="0.2", rise="0.15")
    assert tab.words()["Nothing to show"] == ("A rise of 0.15 s is more than half of the duration: give at most 0.1 s.")


@pytest.mark.parametrize(("on", "option"), [("base", "base-"), ("force1", "force-"), ("force2", "force-")])
def test_the_command_names_what_the_load_is(on, option):
    source = Pulse("half_sine", on, (2.0, 3.0))
    asked = LoadQuestion(SETTING.system, source, SETTING.reference, SETTING.penalty, 25.0, None)
    words = load_command(SETTING, asked).split()
    assert words[2] == f"--{option}half-sine=2,3"
    assert ("--body" in words and words[words.index("--body") + 1]) == (on != "base" and on[-1])


def test_a_wall_has_no_body_2(shown):
    tab = shown(SETTING._replace(bodies="wall", clearance=0.5), on="force2", size="0.5")
    assert tab.away(SETTING._replace(bodies="wall"))["on"] == ["force2"]
    assert tab.result.load.on == "force1"
    assert not [name for name in peaks_in(tab) if "body" in name]
    assert not tab.result.response  # that to a motion of the base
    assert "load_shock" not in [figure.name for figure in tab.figures()]


def test_the_shock_response_is_that_of_the_engine_and_stands_in_its_figure(shown):
    tab = shown(SETTING)
    (found,) = tab.table("load_shock")
    assert len(found.columns["ratio"]) == 41
    assert (found.columns["acceleration_without"] > 0).all()
    assert tab.view.figures["load_shock"].title.text.startswith("Shock response: ")


def test_what_the_time_step_makes_of_the_contact_force_is_said(shown):
    """A coarse step, and the peaks of the same K and D without one."""
    setting = SETTING._replace(steps=200)
    tab = shown(setting, kind="trapezoid", size="2", duration="4", rise="1")
    stepped, exact = (
        transient(setting.system, Load.trapezoid(2.0, 4.0, 1.0), method, free=25.0).peaks
        for method in (Newmark(2500.0, 8.0, 400), ExactPenalty(2500.0, 8.0))
    )
    assert stepped["contact_force"] > 1.05 * exact["contact_force"]
    force, acceleration = (
        [written(each[name]) for each in (stepped, exact)] for name in ("contact_force", "acceleration1")
    )
    said = tab.words()["Largest contact force"]
    assert said.startswith("{}, without a time step {}; ".format(*force))
    assert said.endswith("{}, without {}.".format(*acceleration))


def test_a_shock_response_that_goes_out_of_range_says_where(shown):
    tab = shown(SETTING._replace(bodies="two", kappa=0.005, mass_ratio=1.0))
    assert 30 <= len(tab.result.response["ratio"]) < 41
    assert "of body 1: kappa = " in tab.words()["Shock response"]


def test_a_penalty_solution_with_too_many_steps_leaves_the_reference_and_says_why(shown):
    tab = shown(SETTING._replace(steps=10**6), on="force1", duration="1e4", free="0")
    assert "take fewer steps" in tab.words()["Do they agree?"]
    assert list(tab.result.runs) == ["reference"]
    tab = shown(SETTING._replace(steps=10**7))
    assert "Steps = 20000000 is outside" in tab.words()["Nothing to show"]


def test_a_penalty_solution_that_blows_up_leaves_the_reference_and_says_why(shown):
    tab = shown(SETTING._replace(integrator="central-difference", K=1e5, steps=60))
    assert "the gap passed" in tab.words()["Do they agree?"]
    assert [solver for solver, _ in tab.result.whole()] == ["reference"]
    assert {solver for solver, _ in tab.result.curves} == {"load", "reference"}
