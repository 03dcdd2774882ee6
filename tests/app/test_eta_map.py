"""The map over η is that of the system that is shown, or it says that it is not there yet."""

from functools import partial

import bokeh.document
import numpy as np
import pytest
from bokeh.io.doc import patch_curdoc
from bokeh.models import Label
from vibroscope.app.explorer.compute import compute_runs
from vibroscope.app.explorer.shipped import is_shipped, load_diagram
from vibroscope.app.explorer.state import Setting
from vibroscope.app.page.explore import eta_map
from vibroscope.app.page.explore.eta_map import NOTHING, EtaMapView, MapPoints, MapSource
from vibroscope.app.page.explore.figures import MotionView
from vibroscope.app.page.tab import Move
from vibroscope.app.page.tabs import VIEWS
from vibroscope.app.studies.bifurcation import DiagramQuestion
from vibroscope.app.studies.study_job import StudyJob
from vibroscope.engine import Reference, simulate

from tests.app.fakes import QueueingHost

OTHER = Setting(eta=2.0, kappa=2.4)
TITLE = "Reference over frequency (click sets it)"


class Document(bokeh.document.Document):
    """Calls at once what the map asks after a rest, if a test says so."""

    waits = False

    def add_timeout_callback(self, callback, _):
        if not self.waits and isinstance(callback.func.__self__, MapSource):
            callback()


@pytest.fixture
def explore(monkeypatch):
    """Explore without a browser, and a function that shows a setting there; diagrams have few values of η."""
    monkeypatch.setattr(eta_map, "DiagramQuestion", partial(DiagramQuestion, count=16, transient=200))
    tab = VIEWS["explore"](QueueingHost(doc=Document()))
    tab.build()

    def show(setting):
        compute_runs(setting)
        assert tab.show_if_ready(Move(1, setting))
        return tab

    yield show
    tab.close()


def title(tab):
    return tab.eta_map.figure.title.text.partition(":")[0]


def scenes_shown(tab):
    return {label.visible for label in tab.eta_map.figure.select(type=Label)}


def test_the_map_of_another_system_is_computed_for_it(explore):
    load_diagram("table").result()
    tab = explore(Setting())
    shipped = tab.data()["diagram"]
    assert (title(tab), scenes_shown(tab)) == (TITLE, {True})
    explore(OTHER)
    assert title(tab) != TITLE
    assert tab.data()["diagram"] == {}  # and not that of the paper
    assert "diagram" not in [figure.name for figure in tab.figures()]
    assert not tab.eta_map.picture.data["image"][0].any()
    tab.host.catch_up_until(lambda: title(tab) == TITLE)
    assert scenes_shown(tab) == {False}
    assert "diagram" in [figure.name for figure in tab.figures()]
    found = tab.data()["diagram"]
    assert len(found["eta"]) < len(shipped["eta"])
    eta = float(found["eta"][np.argmin(np.abs(found["eta"] - 2.0))])
    run = simulate(OTHER.system, eta, Reference(), periods=248, keep=48)
    own = found["xi2"][np.isclose(found["eta"], eta)]
    np.testing.assert_allclose(np.sort(own), np.sort(run.section[:, 2]), atol=1e-5)
    explore(Setting())
    assert title(tab) == TITLE
    np.testing.assert_array_equal(tab.data()["diagram"]["eta"], shipped["eta"])


def points(low, high, share=1.0):
    """Points whose displacement reaches from end to end."""
    return MapPoints(np.array([1.0, 2.0]), np.tile([[low], [high]], (2, 1, 1)), share)


FINAL = points(-3e-4, 5.2e-4)
PARTIAL = points(-3e-4, 2e-4, 0.5)


@pytest.mark.parametrize(
    "before",
    [
        [points(-4.1e-4, 4.1e-4)],  # of another system, complete
        [points(-7.0, 1.0), NOTHING, PARTIAL],
        [points(-7.0, 1.0, 0.2), PARTIAL],
        [points(-9.0, 1.0, 0.2), points(-1e-4, 1e-4, 0.3), PARTIAL, NOTHING],
    ],
)
@pytest.mark.parametrize("last", [FINAL, PARTIAL])
def test_the_axis_is_that_of_the_points_whatever_was_drawn_before(before, last):
    views = [EtaMapView(MotionView().sources) for _ in range(2)]
    for found in before:
        views[0].update(OTHER, found, fresh=False)
    for view in views:
        view.update(OTHER, last, fresh=False)
    first, second = (view.ranges["section"].ends for view in views)
    assert first == second


def test_the_axis_of_a_free_vibration_is_that_of_no_map_before():
    view = EtaMapView(MotionView().sources)
    empty = view.ranges["section"].ends
    view.update(OTHER, FINAL, fresh=False)
    view.update(OTHER._replace(kappa=2.5), NOTHING, fresh=False)
    assert view.ranges["section"].ends != empty  # its points are on the way
    view.update(OTHER._replace(base=0.0), NOTHING, fresh=False)
    assert view.ranges["section"].ends == empty


def test_the_zoom_of_a_link_outlives_the_points_that_come():
    view = EtaMapView(MotionView().sources)
    view.ranges["section"].restore(-1.0, 2.0)
    view.update(OTHER, NOTHING, fresh=False)
    for found in (PARTIAL, points(-1.0, 1.0, 0.7), FINAL):
        view.redraw(found)
    assert view.ranges["section"].ends == (-1.0, 2.0)


def test_marks_beside_the_frame_are_not_drawn_over_the_labels_of_its_ticks(explore):
    load_diagram("table").result()
    view = explore(Setting()).eta_map
    view.figure.x_range.update(start=1.1, end=2.0)
    view.zoom()
    shown = [label.text for label in view.figure.select(type=Label) if label.visible]
    assert shown == ["[B]"]
    view.figure.x_range.update(start=0.5, end=4.0)
    view.zoom()
    assert scenes_shown(explore(Setting())) == {True}


@pytest.mark.parametrize("change", [{"threshold": 0.01}, {"joint_damping": "derived"}])
def test_a_map_is_that_of_the_solver(explore, change):
    tab, setting = explore(Setting()), Setting()._replace(**change)
    explore(setting)
    tab.host.catch_up_until(lambda: title(tab) == TITLE)
    assert is_shipped(setting) == ("joint_damping" in change)
    assert np.unique(tab.eta_map.in_view()["eta"]).size == (1401 if "joint_damping" in change else 16)


def test_no_map_is_computed_while_the_system_moves_or_the_tab_is_hidden(explore, monkeypatch):
    monkeypatch.setattr(Document, "waits", True)
    jobs = []

    def start(*asked):
        jobs.append(StudyJob(*asked))
        return jobs[-1]

    monkeypatch.setattr(eta_map, "StudyJob", start)
    tab = explore(OTHER)
    assert jobs == []
    monkeypatch.setattr(Document, "waits", False)
    explore(OTHER._replace(kappa=2.5))
    explore(OTHER._replace(kappa=2.6))
    assert [job.cancelled for job in jobs] == [True, False]
    tab.hide()
    assert [job.cancelled for job in jobs] == [True, True]


def test_the_picture_is_made_without_the_document_that_another_session_has_left_behind():
    """Bokeh has one current document for all threads: in that of a view it may be one of a session that has ended."""
    motion, ended = MotionView(), Document()
    del ended._theme  # as Panel destroys a document
    with patch_curdoc(ended):
        view = EtaMapView(motion.sources)
    assert not view.picture.data["image"][0].any()
