"""What can be typed and swept in the bifurcation diagram, and that the scripts of it compute the same."""

import numpy as np
import pytest
from bokeh.events import Tap
from vibroscope.app.commands.cli import main
from vibroscope.app.explorer import shipped
from vibroscope.app.explorer.state import Setting, slider_range
from vibroscope.app.page import asker
from vibroscope.app.page.bifurcation.panel import SWEPT
from vibroscope.app.page.bifurcation.tab import Bifurcation
from vibroscope.app.page.tab import Move
from vibroscope.app.studies.bifurcation import DiagramQuestion, grow_diagram
from vibroscope.engine import CompileProgress, EtaStudy, Reference, System, simulate

from tests.app.fakes import Asked, FakeHost

SETTING = Setting(eta=2.76, K=12000.0, D=18.0, steps=2000)


@pytest.fixture
def tab(monkeypatch):
    monkeypatch.setattr(asker, "StudyJob", Asked)
    tab = Bifurcation(FakeHost())
    tab.build()
    tab.show(Move(1, SETTING))
    return tab


def choose(tab, **wanted):
    tab.panel.receive({"choose": wanted})
    return tab.question(SETTING)


def test_range_resolution_and_transient_are_typed(tab):
    choose(tab, **{"from": "2.7"})
    question = choose(tab, to="2,9", count="1 001", transient="2,000")
    assert question.span == (2.7, 2.9)
    assert (question.count, question.transient, len(question.axis)) == (1001, 2000, 1001)
    assert tab.view.ranges["eta"].ends == (2.7, 2.9)
    assert (tab.panel.chosen["from"], tab.panel.chosen["to"]) == (2.7, 2.9)
    texts = tab.view_texts()
    assert "eta:2.7,2.9" in texts["zoom"]  # the range stands in the address as a zoom
    assert texts["choice"] == "count:1001;transient:2000"
    again = Bifurcation(FakeHost())
    again.build()
    again.restore(Bifurcation.read_view(*texts.values()))
    assert again.question(SETTING) == question


@pytest.mark.parametrize("wanted", [{"count": "many"}, {"count": "1"}, {"to": "0.1"}, {"transient": "-3"}, {"to": "x"}])
def test_what_cannot_be_taken_is_refused_in_words(tab, wanted):
    before = tab.question(SETTING)
    assert choose(tab, **wanted) == before
    assert "must" in tab.panel.refused
    choose(tab, count="100")
    assert tab.panel.refused == ""


def test_the_line_is_dragged_to_round_values_within_what_can_be_set():
    assert [SWEPT["eta"].rounded(value) for value in (2.34567, -1.0, 1e9)] == [2.3457, *SWEPT["eta"].field.bounds]


@pytest.mark.parametrize("over", SWEPT)
def test_any_number_is_swept_by_a_solver_that_has_it_and_moving_it_asks_nothing(tab, over):
    question = choose(tab, over=over)
    assert question.over == over
    assert question.span == slider_range(over, System())
    assert tab.panel.chosen["solver"] in SWEPT[over].solvers
    named = (
        "frequency η = Ω/ω₁, base displacement held"
        if over == "eta"
        else f"{SWEPT[over].choice} {SWEPT[over].field.label}"
    )
    assert named in tab.view.hover.tooltips[0][0]
    assert question.study().cells == len(question.axis)  # the engine takes it
    moved = SETTING._replace(**{over: {"eta": 2.0, "restitution": 0.7}.get(over, 3000)})
    assert tab.question(moved) == question
    tab.on_tap(Tap(None, x=1234.56789, y=0.5))
    assert [*tab.host.settings[-1]] == [over]


def test_a_solver_without_the_swept_number_returns_to_eta(tab):
    choose(tab, over="K")
    assert choose(tab, solver="reference").over == "eta"
    assert tab.view.span == slider_range("eta", System())


def test_an_own_start_is_that_of_each_value():
    start = (0.3, 0.0, 1.2, -0.5)
    question = DiagramQuestion(System(), Reference(), "rest", (2.7, 2.9), count=3, transient=5, initial=start)
    *_, result = grow_diagram(question, None, lambda: False)
    run = simulate(System(), 2.8, Reference(), periods=53, keep=48, initial=start)
    np.testing.assert_allclose(result.section("xi2")[1], run.section[:, 2], atol=1e-9)


def test_an_own_start_on_the_command_line(tmp_path):
    out = str(tmp_path / "own.zarr")
    sweep = ["sweep", "eta", "--solver", "reference", "--from", "2.7", "--to", "2.9", "--count", "3", "--out", out]
    assert main([*sweep, "--transient", "5", "--initial", "0.3,0,1.2,-0.5"]) == 0
    with pytest.raises(ValueError, match="own start"):
        sweep(EtaStudy(System(), Reference(), values=[2.7, 2.9], initial=(0, 0, 1, 0), direction="up"))


def test_while_the_solvers_are_compiled_the_shipped_diagram_is_shown(tab, monkeypatch):
    diagram = shipped.load_diagram("table").result()
    monkeypatch.setattr(shipped.compilation, "progress", CompileProgress(0.2, "reference"))
    tab.show(Move(2, SETTING))
    drawn = tab.view.sources["bifurcation_reference"].data
    assert tab.view.figure.title.text.startswith("Shipped result: ")
    assert set(drawn["eta"]) == set(diagram.eta.astype(np.float32))
    assert np.isin(drawn["value"], diagram.displacement[1]).all()
    choose(tab, coordinate="v2")  # which is not shipped
    assert not len(tab.view.sources["bifurcation_reference"].data["eta"])
    choose(tab, coordinate="xi1")
    assert np.isin(tab.view.sources["bifurcation_reference"].data["value"], diagram.displacement[0]).all()
    choose(tab, direction="up")
    assert not len(tab.view.sources["bifurcation_reference"].data["eta"])
    assert tab.view.figure.title.text == "Being computed …"
