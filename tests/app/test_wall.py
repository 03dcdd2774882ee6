"""A body beside a wall: figures, files, words and fields are of the body; the wall has none."""

import numpy as np
import pytest
from vibroscope.app.explorer.compute import compute_runs
from vibroscope.app.explorer.parameters import START_FIELDS
from vibroscope.app.explorer.reading import read_setting
from vibroscope.app.explorer.state import Setting
from vibroscope.app.page.bifurcation.tab import Bifurcation
from vibroscope.app.page.controls.controls import Controls
from vibroscope.app.page.explore.tab import Explore
from vibroscope.app.page.study.time_step import statements
from vibroscope.app.page.tab import Move
from vibroscope.app.studies import time_step
from vibroscope.app.studies.time_step import PartialStep, StepQuestion
from vibroscope.engine import ComparisonQuestion, Newmark, motion, repetition, verdict
from vibroscope.engine import compare as compare_solutions
from vibroscope.engine.sweeps import StepStudy, kind_words

from tests.app.fakes import Document, QueueingHost
from tests.app.test_study_tab import opened  # noqa: F401 - a fixture

WALL = Setting(bodies="wall", clearance=0.5, eta=2.2, K=2000.0, D=1.0, steps=100, coordinate="xi1")


def explore(setting):
    tab = Explore(QueueingHost(doc=Document()))
    page = tab.build()
    compute_runs(setting)
    assert tab.show_if_ready(Move(1, setting))
    tab.host.catch_up_until(lambda: tab.figures())
    return tab, page


@pytest.fixture(scope="module")
def beside_a_wall():
    tab, page = explore(WALL)
    yield tab, page
    tab.close()


def test_the_phase_plot_of_the_body_takes_the_place_of_both(beside_a_wall):
    tab, page = beside_a_wall
    panes = {
        pane.object.name: pane.object.visible for pane in page if hasattr(getattr(pane, "object", None), "x_range")
    }
    assert not panes.pop("phase2")
    assert all(panes.values())
    assert "at-wall" in page.css_classes
    assert "phase2" not in [figure.name for figure in tab.figures()]
    assert tab.motion.figures["displacement"].yaxis[0].axis_label == "displacement ξ₁ / base amplitude"


def test_files_have_no_columns_of_the_wall(beside_a_wall):
    tab, _ = beside_a_wall
    table = tab.table("displacement")
    assert len(table) == 2
    for series in table:
        assert list(series.columns) == ["time", "xi1"]
        assert np.isfinite(series.columns["xi1"]).all()


def test_scatter_is_told_of_the_body():
    found = motion(WALL.system, WALL.eta, WALL.penalty)
    assert found.scatter == pytest.approx(found.section[:, 0].std(), rel=1e-9)
    assert f"blurred by the time step (±{found.scatter:.2g} in ξ₁)" in repetition(found)
    words = verdict(compare_solutions(ComparisonQuestion(WALL.system, WALL.eta, WALL.penalty))).headline
    assert "ξ₂" not in words
    section = found.section + np.random.default_rng(1).normal(0, 0.1, found.section.shape) * [1, 1, 0, 0]
    assert "in ξ₁)" in kind_words(-1, 0, 1, section, WALL.system.observed_body)


def test_a_step_study_shows_the_body(monkeypatch):
    monkeypatch.setattr(time_step, "STEPS", (100, 200))
    question = StepQuestion(WALL.system, WALL.eta, Newmark(WALL.K, WALL.D, 100))
    study = StepStudy(
        question.system, Newmark(WALL.K, WALL.D, 100), WALL.eta, transient=60, sample=20, steps=(100, 200)
    )
    result = PartialStep(question, study, study.compute())
    assert list(result.orbit(0, "fixed")) == list(result.section(0, "fixed")) == ["xi1", "v1"]
    section = result.section(0, "fixed")["xi1"]
    assert result.of_scheme("spread", "fixed")[0] == pytest.approx(section.std(), rel=1e-9)
    assert section.std() > 1e-3
    assert "ξ₁ by ±" in statements(WALL, result)[0][1]


def test_a_diagram_offers_neither_coordinate_nor_start_of_the_wall(opened):  # noqa: F811
    tab, _ = opened(Bifurcation)
    tab.panel.chosen = tab.panel.chosen | {"direction": "own", "start_xi1": 0.25, "start_xi2": 3.0}
    assert tab.question(WALL).initial == (0.25, 0.0, 0.0, 0.0)
    tab.show(Move(2, WALL))
    assert tab.panel.chosen["coordinate"] == "xi1"
    assert tab.away(WALL) == {"coordinate": ["xi2", "v2"], "start_xi2": ["start_xi2"], "start_v2": ["start_v2"]}
    assert tab.away(Setting()) == {}


def test_the_panel_has_no_start_of_the_wall():
    controls = Controls()
    controls.show_setting(WALL)
    assert set(START_FIELDS) & controls.shown["numbers"].keys() == {"start_xi1", "start_v1"}
    controls.show_setting(read_setting({}, Setting()))
    assert set(START_FIELDS) <= controls.shown["numbers"].keys()
