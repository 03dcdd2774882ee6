"""The curves of bifurcations over the cells of the K–D plane: searched for, drawn, listed and taken away."""

import re

import numpy as np
import pytest
from vibroscope.app.explorer.link import View
from vibroscope.app.explorer.state import Setting
from vibroscope.app.page import asker
from vibroscope.app.page.study.plane import Plane, PlaneCurves, PlaneView
from vibroscope.app.page.tab import Move
from vibroscope.app.studies import plane_curves as study
from vibroscope.app.studies.plane_curves import CurvesQuestion, PartialCurves, grow_curves
from vibroscope.engine import Cancelled, PointCurve, PointCurves, System

from tests.app.fakes import FakeHost, send
from tests.few_seeds import few_seeds

QUESTION = CurvesQuestion(System(), 2.78, (6000.0, 30_000.0), (15.0, 22.0))


def never():
    return False


def curve(kind, *values, meetings=()):
    """A curve with these vertices."""
    return PointCurve(kind, "K", "D", 1, np.array(values), meetings, ("K leaves the range", "D leaves the range"))


CURVES = (
    curve("fold", (3000.0, 17.0), (5000.0, 18.0), (9000.0, 20.0), meetings=(("cusp", 3500.0, 17.5),)),
    curve("grazing", (4000.0, 17.0), (6000.0, 20.0)),
)


class Job:
    """Stands for `StudyJob`."""

    def __init__(self, question, grow, deliver):
        self.question, self.deliver, self.cancelled, self.out_of_time = question, deliver, False, False
        Job.last = self

    def cancel(self):
        self.cancelled = True


@pytest.fixture
def shown(monkeypatch):
    """The curves in two figures, with their host."""
    monkeypatch.setattr(asker, "StudyJob", Job)
    monkeypatch.setattr(asker.RESULTS, "get", lambda question: None)
    figures = PlaneView()
    return PlaneCurves(host := FakeHost(), figures, lambda: None), figures, host


def test_each_point_of_a_branch_lies_on_a_curve_that_is_followed_once(monkeypatch):
    monkeypatch.setattr(study, "SEARCH", {"max_period": 1, "most_orbits": 200})
    with few_seeds():
        *_, last = grow_curves(QUESTION, None, never)
    assert last.share == 1
    assert last.words() == "1 curve: 1 of period doublings"  # though every row has a point on it
    table = last.table()
    assert set(table["kind"]) == {"period doubling"}
    np.testing.assert_allclose(sorted(table["D"][[0, -1]]), QUESTION.D, rtol=1e-12)


def test_a_search_that_is_cancelled_or_out_of_time_says_so(monkeypatch):
    with pytest.raises(Cancelled):
        list(grow_curves(QUESTION, None, lambda: True))
    monkeypatch.setattr(study, "SECONDS", -1.0)
    *_, last = grow_curves(QUESTION, None, never)
    assert (last.curves, last.share) == ((), 1)
    assert last.cut.startswith("The search ended after -1 s")


def test_points_that_cannot_be_followed_are_counted(monkeypatch):
    monkeypatch.setattr(study, "SEARCH", {"max_period": 1, "most_orbits": 200})
    monkeypatch.setattr(PointCurves, "follow", lambda *_: (_ for _ in ()).throw(ValueError("lost")))
    with few_seeds():
        *_, last = grow_curves(QUESTION, None, never)
    assert re.fullmatch(r"\d+ points of branches could not be followed\.", last.cut)


def test_curves_are_drawn_over_both_planes_and_listed(shown):
    made, figures, host = shown
    made.ask(QUESTION)
    Job.last.deliver(Job.last, PartialCurves(QUESTION, CURVES, 0.5))
    made.draw(["A note."], Setting())
    assert made.view.visible
    assert made.view.status["running"]
    assert made.view.status["text"] == "Exact penalty: 2 curves: 1 of folds, 1 of grazing; searching …"
    np.testing.assert_array_equal(figures.sources["plane_curves_fold"].data["K"][:3], [3000, 5000, 9000])
    for plot in figures.figures.values():
        items = {item.label.value: item.visible for item in plot.legend[0].items[2:]}
        assert items == {"folds": True, "period doublings": False, "grazing": True, "contacts that open": False}
    assert figures.sources["plane_curves_meetings"].data["other"] == ["cusp"]
    first = made.view.points["rows"][0]
    assert [cell["text"] for cell in first["cells"]] == ["fold", "1", "3000 to 9000", "17 to 20", "cusp"]
    send(made.view, {"open": first["cells"][0]["open"]})
    assert host.visits[-1][:2] == ("explore", {"K": "5000", "D": "18"})
    made.draw([], Setting(units="si", omega1=20.0, m1=3.0))
    assert made.view.points["heads"] == ["kind", "period", "K [N/m]", "2D [N·s/m]", "meets"]
    cells = made.view.points["rows"][0]["cells"]
    assert [cell["text"] for cell in cells[2:4]] == ["3600000 to 1.08e7", "2040 to 2400"]
    send(made.view, {"open": "99999"})
    send(made.view, {"open": 3})


def test_a_search_is_stopped_goes_on_and_ends_with_its_question(shown):
    made, _, _ = shown
    made.ask(QUESTION)
    first = Job.last
    send(made.view, {"stop": True})
    assert first.cancelled
    made.ask(QUESTION)
    assert Job.last is first
    send(made.view, {"stop": False})
    assert Job.last is not first
    Job.last.deliver(Job.last, ValueError("K = -1 is out of range"))
    made.draw([], Setting())
    assert "ended early" in made.view.status["notes"][0]
    made.clear()
    assert not made.view.visible
    assert made.result is None


def test_the_script_finds_the_same_curves_and_the_commands_are_those_of_the_rows(shown):
    made, _, _ = shown
    made.ask(QUESTION)
    Job.last.deliver(Job.last, PartialCurves(QUESTION, CURVES, 1.0))
    assert f"CurvesQuestion(system, 2.78, {QUESTION.K!r}, {QUESTION.D!r})" in made.python()
    lines = made.command().splitlines()
    assert len([line for line in lines if line.startswith("vibroscope branch")]) == 12
    assert made.words() == [["Curves of bifurcations", "2 curves: 1 of folds, 1 of grazing."]]


def test_the_switch_of_the_tab_asks_for_the_curves_of_what_is_in_view(monkeypatch):
    monkeypatch.setattr(asker, "StudyJob", Job)
    monkeypatch.setattr(asker.RESULTS, "get", lambda question: None)
    tab = Plane(FakeHost())
    tab.build()
    tab.show(Move(1, Setting(eta=2.76)))
    assert not tab.searches.view.visible
    tab.restore(View(choice={"curves": "on"}))
    tab.refresh()
    assert Job.last.question == CurvesQuestion(System(), 2.76, **tab.view.in_view)
    assert tab.searches.view.visible
    assert tab.view_texts()["choice"] == "curves:on"
    tab.hide()
    assert Job.last.cancelled
