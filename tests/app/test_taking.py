"""On every tab what is offered can be taken, nothing else, and the scripts give the numbers of the page."""

import csv
import io
import json
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import xarray
from vibroscope.app.explorer.compute import frame_of
from vibroscope.app.explorer.state import Explorer, print_address
from vibroscope.app.page.study import tab as study
from vibroscope.app.page.tabs import TABS, Move
from vibroscope.app.page.taking import offers, take
from vibroscope.app.paper import CLAIMS
from vibroscope.app.studies import bifurcation, plane, speed
from vibroscope.app.studies.live import KEPT

from .test_study_tab import Asked, Desk

SETTING = Explorer().setting()._replace(eta=2.76, K=12000.0, D=18.0, steps=200, kappa=2.4)
SETTING_KINDS = ("toml", "python", "command")
PAPER = ("3", "6A", "9A", "12")  # a picture of each kind
ADDRESS = f"?{print_address(SETTING)}"


@pytest.fixture(scope="module")
def filled():
    """A function from the key of a tab to one with data of a first stage in it."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(study, "Live", Asked)
        patch.setattr(speed, "ROUNDS", (1,))
        kept = {}

        def fill(key):
            if key not in kept:
                kept[key] = _filled(TABS[key](Desk()))
            return kept[key]

        yield fill


def _filled(tab):
    tab.build()
    if tab.key == "paper":
        for key in PAPER:
            tab.show_result(key, CLAIMS[key].find())
        assert len({type(found.picture) for found in tab._findings.values()}) == len(PAPER)
        return tab
    if tab.key == "explore":
        tab.desk.doc = _Document()
        frame_of(SETTING)
        assert tab.at_once(Move(1, SETTING))
        return tab
    tab.show(Move(1, SETTING))
    if isinstance(tab, study.StudyTab):
        asked = Asked.all[-1]
        for stage in asked.refine(asked.question, None, lambda: False):
            asked.deliver(asked, stage)
            if tab.key != "bifurcation" or stage.share == 1:
                break
    return tab


class _Document:
    def add_timeout_callback(self, *_):
        pass


@pytest.mark.parametrize("key", TABS)
def test_what_is_offered_comes_in_its_format(filled, key):
    tab = filled(key)
    for kind in SETTING_KINDS:
        assert take(tab, kind, SETTING, ADDRESS)()["text"]
    offered = offers(tab)
    assert bool(offered) == (key != "help")
    for name, title, drawn, tabled in offered:
        assert drawn or tabled
        if not tabled:
            assert take(tab, f"csv:{name}", SETTING, ADDRESS) is None
            continue
        table = take(tab, f"csv:{name}", SETTING, ADDRESS)()
        assert table["name"] == f"vibroscope-{name}.csv"
        rows = list(csv.reader(io.StringIO(table["text"])))
        assert rows[0][0] == "series"
        assert len(rows[0]) > 1
        assert len(rows) > 1, title
        assert {len(row) for row in rows} == {len(rows[0])}
    if offered:
        found = json.loads(take(tab, "json", SETTING, ADDRESS)()["text"])
        assert found["address"] == ADDRESS
        assert found["data"]
        assert found.get("setting", SETTING._asdict()) == SETTING._asdict()
        report = take(tab, "report", SETTING, ADDRESS)()["text"]
        assert report.count("data-figure=") == sum(drawn for _, _, drawn, _ in offered)
        assert f"<h1>Vibroscope report: {tab.title}</h1>" in report


@pytest.mark.parametrize("key", TABS)
def test_what_is_not_offered_does_not_come(key):
    tab = TABS[key](Desk())
    tab.build()
    assert offers(tab) == []
    for what in ("json", "report", "csv:displacement", "csv:plane_exact", "csv:", "", "x" * 4000, "png:phase1"):
        assert take(tab, what, SETTING, ADDRESS) is None


@pytest.mark.parametrize("key", ["explore", "bifurcation", "plane", "step", "speed"])
def test_until_the_next_picture_comes_all_that_is_taken_is_of_the_last(filled, key):
    tab, other = filled(key), SETTING._replace(eta=2.0, K=500.0, D=3.0, steps=400, kappa=2.3)
    kinds = ["json", "report", "python", "command", *(f"csv:{name}" for name, *_, tabled in offers(tab) if tabled)]

    def texts(setting):
        found = {kind: take(tab, kind, setting, ADDRESS)()["text"] for kind in kinds}
        return found | {"report": found["report"].rpartition("<p>")[0]}  # below stands the time

    before = texts(SETTING)
    if isinstance(tab, study.StudyTab):
        tab.show(Move(2, other))
        tab.show(Move(3, other._replace(K=501.0)))
    after = texts(other)
    if isinstance(tab, study.StudyTab):
        tab.show(Move(4, SETTING))
    assert before == after
    assert "eta = 2\n" in take(tab, "toml", other, ADDRESS)()["text"]


def test_a_mark_that_is_moved_is_that_of_what_is_taken(filled):
    tab = filled("plane")
    tab.show(Move(2, SETTING._replace(K=2000.0)))
    taken = json.loads(take(tab, "json", SETTING, ADDRESS)()["text"])
    tab.show(Move(3, SETTING))
    assert taken["setting"]["K"] == 2000
    assert taken["words"].keys() != json.loads(take(tab, "json", SETTING, ADDRESS)()["text"])["words"].keys()


def test_the_script_of_a_bifurcation_diagram_finds_its_points(filled, capsys):
    tab = filled("bifurcation")
    space = {}
    exec(tab.python(SETTING), space)
    found, stage = space["diagram"], tab._stage
    np.testing.assert_array_equal(found["eta"], stage.question.axis)
    np.testing.assert_array_equal(found["period"], stage.period)
    for name, column in bifurcation.COORDINATES.items():
        np.testing.assert_array_equal(found[name], stage.section[:, :, column].astype(found[name].dtype))


def test_the_script_of_a_plane_finds_its_cells(filled, monkeypatch, capsys):
    tab = filled("plane")
    monkeypatch.setattr("vibroscope.app.page.plane.tab.COUNT", 6)
    monkeypatch.setattr(plane, "COUNT", 6)
    question = tab.question(SETTING)
    space = {}
    exec(tab.python(SETTING), space)
    for name in ("K", "D"):
        np.testing.assert_allclose(space["exact"][name], question.axis(name), rtol=1e-14)
    # The last digit of K is enough for another chaotic motion: the page's own cells at exactly the script's K and D.
    K, D = np.meshgrid(space["exact"]["K"], space["exact"]["D"])
    cells = plane._run(question, K.ravel(), D.ravel(), lambda: False)
    for side in plane.SIDES:
        for name in ("status", "period", "near_period", "impacts_per_period"):
            found = space[side][name].transpose("D", "K").values
            np.testing.assert_array_equal(found.ravel(), cells[side][name])


def test_the_script_of_the_time_step_study_finds_its_motions(filled, capsys):
    tab = filled("step")
    space = {}
    exec(tab.python(SETTING).replace("8000, 16000, 32000", "8000"), space)
    stage = tab._stage
    shown = space["study"].isel(steps=slice(len(stage.steps)))
    for name in ("period", "spread", "error_time_step", "xi2_section"):
        np.testing.assert_array_equal(shown[name].values, stage.found[name].values)


def test_the_script_of_speed_and_error_finds_its_errors(filled, capsys):
    tab = filled("speed")
    space = {}
    exec(tab.python(SETTING), space)
    assert space["found"].errors == tab._stage.errors


def test_the_script_of_the_paper_checks_the_claims(monkeypatch, capsys):
    monkeypatch.setattr("vibroscope.app.paper.CLAIMS", {"4C": CLAIMS["4C"]})
    exec(TABS["paper"](Desk()).python(SETTING), {})
    assert "Figure 4 [C]" in capsys.readouterr().out


@pytest.mark.parametrize("key", ["bifurcation", "plane", "step"])
def test_the_commands_of_a_study_are_understood_and_make_it(filled, key, tmp_path, monkeypatch):
    monkeypatch.setattr("vibroscope.app.page.plane.tab.COUNT", 3)
    monkeypatch.setattr(plane, "COUNT", 3)
    monkeypatch.setattr("vibroscope.app.page.bifurcation.tab.COUNT", 3)
    monkeypatch.setattr("vibroscope.app.page.time_step.tab.STEPS", (500, 1000))
    commands = filled(key).command(SETTING)
    assert "kappa = 2.4" in commands
    path = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
    done = subprocess.run(
        ["sh", "-e"], input=commands, cwd=tmp_path, env=os.environ | {"PATH": path}, capture_output=True, text=True
    )
    assert done.stderr == ""
    kept = sorted(path.name for path in tmp_path.glob("*.zarr"))
    assert kept == {"plane": ["plane1.zarr", "plane2.zarr"]}.get(
        key, [f"{ {'bifurcation': 'eta'}.get(key, key) }.zarr"]
    )
    for name in kept:
        found = xarray.open_zarr(tmp_path / name)
        assert found.attrs["failed"] == 0
        assert found.sizes[{"bifurcation": "eta", "plane": "K", "step": "steps"}[key]] == {"step": 2}.get(key, 3)


def test_a_diagram_gives_also_what_it_is_compared_with(filled, monkeypatch):
    tab = filled("bifurcation")
    asked = tab._stage.question
    up, down = (asked._replace(direction=direction) for direction in ("up", "down"))
    stage = type(tab._stage)(up, *list(vars(tab._stage).values())[1:])
    other = type(tab._stage)(down, *list(vars(tab._stage).values())[1:])
    monkeypatch.setattr(tab, "_stage", stage)
    KEPT.put(down, other)
    assert [series.label for series in tab.table("bifurcation")] == [
        "Reference continued upwards",
        "Reference continued downwards",
    ]
