"""Every tab gives the files that it offers, no others, and all of what it shows."""

import csv
import io
import json
import re

import pytest
from vibroscope.app.explorer.state import Setting
from vibroscope.app.page.study.tab import StudyView
from vibroscope.app.page.tab import Move
from vibroscope.app.page.tabs import VIEWS
from vibroscope.app.page.take_away import file_writer, offered_figures

from tests.app.fakes import FakeHost, QueueingHost
from tests.app.filled_tabs import ADDRESS, SETTING, filled  # noqa: F401 - a fixture
from tests.share import every

SETTING_KINDS = ("toml", "python", "command")
COLUMNS = {  # some of them, by figure
    "phase1": {"xi1", "velocity1"},
    "displacement": {"time", "xi1", "xi2"},
    "strip": {"contact_begin", "contact_end"},
    "force": {"time", "force", "impulse"},
    "diagram": {"eta", "xi2"},
    "bifurcation": {"eta", "xi2"},
    "bifurcation_strip": {"from_eta", "to_eta", "period"},
    "plane_penalty": {"K", "D", "period", "contact_steps"},
    "plane_exact": {"K", "D", "period", "impacts_per_period"},
    "basin_reference": {"xi2", "v2", "motion"},
    "basin_penalty": {"xi2", "v2", "motion", "periods"},
    "step_phase_fixed": {"xi2", "v2"},
    "step_spread": {"n", "scatter"},
    "speed": {"steps", "us_per_period", "error"},
    "claims": {"claim", "agrees", "found"},
}
STUDIES = ["bifurcation", "plane", "basin", "step", "speed"]


@pytest.mark.parametrize("key", every(VIEWS))
def test_an_offered_file_has_its_format(filled, key):  # noqa: F811
    tab = filled(key)
    for kind in SETTING_KINDS:
        assert file_writer(tab, kind, SETTING, ADDRESS)()["text"]
    offered = offered_figures(tab)
    assert bool(offered) == (key != "help")
    for name, title, drawn, tabled in offered:
        assert drawn or tabled
        for kind in ("png", "svg", "pdf", "plot"):  # what they hold: `test_drawing.py`
            assert (file_writer(tab, f"{kind}:{name}", SETTING, ADDRESS) is not None) == drawn
        if not tabled:
            assert file_writer(tab, f"csv:{name}", SETTING, ADDRESS) is None
            continue
        table = file_writer(tab, f"csv:{name}", SETTING, ADDRESS)()
        assert table["name"] == f"vibroscope-{name}.csv"
        rows = list(csv.reader(io.StringIO(table["text"])))
        assert rows[0][0] == "series"
        assert COLUMNS.get(name, {"series"}) <= set(rows[0])
        assert len(rows[0]) > 1
        assert len(rows) > 1, title
        assert {len(row) for row in rows} == {len(rows[0])}
    if offered:
        found = json.loads(file_writer(tab, "json", SETTING, ADDRESS)()["text"])
        assert found["address"] == ADDRESS
        assert found["data"]
        assert found.get("setting", SETTING._asdict()) == SETTING._asdict()
        report = file_writer(tab, "report", SETTING, ADDRESS)()["text"]
        assert report.count("<figure><svg ") == sum(drawn for _, _, drawn, _ in offered)
        assert f"<h1>Vibroscope report: {tab.title}</h1>" in report


@pytest.mark.parametrize("key", VIEWS)
def test_a_file_that_is_not_offered_cannot_be_had(key):
    tab = VIEWS[key](FakeHost())
    tab.build()
    if key != "paper":  # which offers all, and checks its claims when they are taken
        assert offered_figures(tab) == []
        assert file_writer(tab, "json", SETTING, ADDRESS) is file_writer(tab, "report", SETTING, ADDRESS) is None
    for what in (
        "csv:displacement",
        "csv:plane_exact",
        "csv:",
        "",
        "x" * 4000,
        "png:phase1",
        "plot:phase1",
    ):
        assert file_writer(tab, what, SETTING, ADDRESS) is None


@pytest.mark.parametrize("key", ["explore", *STUDIES])
def test_all_files_are_of_the_last_picture_until_the_next_comes(filled, key):  # noqa: F811
    tab, other = filled(key), SETTING._replace(eta=2.0, K=500.0, D=3.0, steps=400, kappa=2.3)
    tables = [f"csv:{name}" for name, *_, tabled in offered_figures(tab) if tabled]
    kinds = ["json", "report", "python", "command", *tables]

    def texts(setting):
        found = {kind: file_writer(tab, kind, setting, ADDRESS)()["text"] for kind in kinds}
        said = re.sub("<figure>.*?</figure>", "", found["report"].rpartition("<p>")[0], flags=re.DOTALL)
        return found | {"report": said}  # without its time, and its figures, which have the mark that was moved last

    before = texts(SETTING)
    if isinstance(tab, StudyView):
        tab.show(Move(2, other))
        tab.show(Move(3, other._replace(K=501.0)))
    after = texts(other)
    if isinstance(tab, StudyView):
        tab.show(Move(4, SETTING))
        tab.hide()
    assert before == after
    assert "eta = 2\n" in file_writer(tab, "toml", other, ADDRESS)()["text"]


def test_a_file_has_the_mark_that_was_moved_last(filled):  # noqa: F811
    tab = filled("plane")
    tab.show(Move(2, SETTING._replace(K=2000.0)))
    taken = json.loads(file_writer(tab, "json", SETTING, ADDRESS)()["text"])
    tab.show(Move(3, SETTING))
    tab.hide()
    assert taken["setting"]["K"] == 2000
    again = json.loads(file_writer(tab, "json", SETTING, ADDRESS)()["text"])
    assert taken["words"].keys() != again["words"].keys()


def test_the_table_of_a_diagram_has_the_one_that_it_is_compared_with():
    kind = VIEWS["bifurcation"]
    for direction in ("down", "up"):
        host = QueueingHost()
        tab = kind(host)
        tab.build()
        tab.restore(kind.read_view("", f"direction:{direction};count:24", ""))
        tab.show(Move(1, Setting(d1=0.0042)))
        host.catch_up_until(lambda host=host: host.summary)  # complete
        tab.hide()
    assert [series.label for series in tab.table("bifurcation")] == [
        "Reference continued upwards",
        "Reference continued downwards",
    ]
