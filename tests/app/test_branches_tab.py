"""Branches in the tab Bifurcation: what is searched for and when, the words, the link, the files, and the way back."""

import csv
import io

import numpy as np
import pytest
from vibroscope.app.commands.cli import main
from vibroscope.app.explorer.state import Setting
from vibroscope.app.page import asker
from vibroscope.app.page.bifurcation.tab import Bifurcation
from vibroscope.app.page.explore.other_motions import CoexistingMotions
from vibroscope.app.page.study import tab as study
from vibroscope.app.page.tab import Move
from vibroscope.app.page.take_away import file_writer, offered_figures
from vibroscope.app.runtime.cache import Cache
from vibroscope.app.studies.bifurcation import grow_diagram
from vibroscope.app.studies.branches import grow_branches
from vibroscope.engine import ExactPenalty, Reference

from tests.app.fakes import Asked, FakeHost, send
from tests.few_seeds import few_seeds

SETTING = Setting(eta=1.42, K=12000.0, D=18.0, steps=2000)
RANGE = "eta:1.3,1.5"


@pytest.fixture
def opened(monkeypatch):
    """A function from choices to an open tab and its host; searches begin with few runs."""
    Asked.all = ()
    monkeypatch.setattr(asker, "StudyJob", Asked)
    results = Cache(8)
    for module in (study, asker):
        monkeypatch.setattr(module, "RESULTS", results)

    def open_tab(choice, setting=SETTING):
        tab = Bifurcation(host := FakeHost())
        tab.build()
        tab.restore(Bifurcation.read_view(RANGE if "over" not in choice else "", choice, ""))
        tab.show(Move(1, setting))
        return tab, host

    with few_seeds():
        yield open_tab


def searches():
    return [asked for asked in Asked.all if asked.grow is grow_branches]


def choose(tab, **wanted):
    tab.panel.receive({"choose": wanted})


def notes(tab):
    return " ".join(tab.searches.view.status["notes"])


def test_the_reference_stands_first_whichever_search_is_the_quicker(opened):
    tab, _ = opened("branches:both;count:20")
    for search in sorted(searches(), key=lambda each: isinstance(each.question.method, Reference)):
        search.run(1)
    assert tab.searches.view.status["text"].startswith("Reference: ")
    solvers = [row["cells"][-1]["text"] for row in tab.searches.view.near["rows"]]
    assert solvers == sorted(solvers, reverse=True)
    assert set(solvers) == {"reference", "exact penalty"}
    assert list(tab.searches.results) == ["reference", "penalty"]


def test_nothing_is_searched_for_while_branches_are_off_and_all_ends_when_they_are(opened):
    tab, _ = opened("count:20")
    assert searches() == []
    assert not tab.searches.view.visible
    choose(tab, branches="on")
    (search,) = searches()
    assert search.question.span == (1.3, 1.5)
    assert tab.searches.view.visible
    assert tab.view_texts()["choice"] == "branches:on;count:20"
    search.run(1)
    assert len(tab.view.sources["branches_reference_stable"].data["eta"]) > 10
    choose(tab, branches="off")
    assert search.cancelled
    assert not tab.searches.view.visible
    assert len(tab.view.sources["branches_reference_stable"].data["eta"]) == 0
    assert len(tab.view.sources["branch_points_reference"].data["eta"]) == 0


def test_the_axis_covers_the_branches_that_no_run_ends_on(opened):
    tab, _ = opened("branches:on;count:2;transient:100")  # runs at the ends, beside the doubled motion
    next(each for each in Asked.all if each.grow is grow_diagram).run()
    searches()[0].run()
    low, high = tab.view.ranges["value"].ends
    sections = [branch.sections[..., 2] for branch in tab.searches.results["reference"].branches]
    assert low < min(map(np.min, sections))
    assert high > max(map(np.max, sections))


def test_a_search_follows_the_question_and_not_the_line(opened):
    tab, _ = opened("branches:on")
    tab.show(Move(2, SETTING._replace(eta=1.35, K=500.0)))
    assert len(searches()) == 1
    tab.show(Move(3, SETTING._replace(kappa=2.4)))
    assert [each.cancelled for each in searches()] == [True, False]
    tab.hide()
    assert searches()[-1].cancelled
    tab.show(Move(4, SETTING._replace(kappa=2.4)))
    assert len(searches()) == 3


def test_another_range_keeps_what_is_drawn_until_its_first_branch_comes(opened):
    tab, _ = opened("branches:on")
    searches()[0].run(1)
    drawn = len(tab.view.sources["branches_reference_stable"].data["eta"])
    choose(tab, **{"from": "1.31"})
    assert len(searches()) == 2
    assert len(tab.view.sources["branches_reference_stable"].data["eta"]) == drawn
    assert "searching" in tab.searches.view.status["text"]
    tab.show(Move(2, SETTING._replace(kappa=2.4)))
    assert len(tab.view.sources["branches_reference_stable"].data["eta"]) == 0


def test_both_solvers_are_searched_and_the_exact_penalty_stands_for_newmark(opened):
    tab, _ = opened("branches:both")
    assert [each.question.method for each in searches()] == [Reference(), ExactPenalty(12000.0, 18.0)]
    assert "The exact penalty stands for Newmark T/2000" in notes(tab)
    choose(tab, branches="on", solver="exact")
    assert not tab.searches.view.status["notes"]
    choose(tab, solver="newmark")
    assert "stands for Newmark" in notes(tab)


@pytest.mark.parametrize(
    ("choice", "count", "why"),
    [
        ("branches:on;over:steps;solver:newmark", 0, "without a time step"),
        ("branches:both;over:K;solver:exact", 1, "The reference has no K"),
        ("branches:both;over:restitution", 1, "The penalty model has no restitution"),
    ],
)
def test_a_number_that_a_solver_does_not_have_is_said(opened, choice, count, why):
    tab, _ = opened(choice)
    assert len(searches()) == count
    assert why in notes(tab)
    assert tab.searches.view.visible


def test_a_search_is_stopped_and_goes_on_and_a_failure_is_said(opened):
    tab, _ = opened("branches:on")
    send(tab.searches.view, {"stop": True})
    assert searches()[0].cancelled
    assert tab.searches.view.status["text"] == "stopped"
    tab.refresh()
    assert len(searches()) == 1
    send(tab.searches.view, {"stop": False})
    searches()[1].run(1)
    searches()[1].deliver(searches()[1], ValueError("a reason"))
    assert "Reference: the search ended early (a reason)" in notes(tab)
    assert "1 branch" in tab.searches.view.status["text"]


@pytest.mark.filterwarnings("ignore:Consolidated metadata")
def test_the_branches_are_listed_said_and_taken_away(opened, tmp_path, capsys):
    tab, _ = opened("branches:on;count:12;transient:100")
    next(each for each in Asked.all if each.grow is grow_diagram).run()
    assert [figure[0] for figure in offered_figures(tab)] == ["bifurcation", "bifurcation_strip"]
    searches()[0].run()
    tab.hide()
    tab.show(Move(2, SETTING))
    assert len(searches()) == 1  # all is known
    near = tab.searches.view.near
    assert near["title"] == "Motions of the branches near η = 1.42"
    assert [row["cells"][0]["text"] for row in near["rows"]] == ["unstable, period 1", "stable, period 2"]
    assert "Branches of the reference: 2 branches" in tab.summary(SETTING)
    files = {name: file_writer(tab, f"csv:{name}", SETTING, "?")()["text"] for name, *_ in offered_figures(tab)}
    points = list(csv.DictReader(io.StringIO(files["bifurcation_points"])))
    assert [row["kind"] for row in points] == ["period doubling"] * 2
    assert len(files["bifurcation_branches"].splitlines()) > 100
    space = {}
    exec(tab.python(SETTING), space)
    found = space["branches_reference"]
    assert [branch.period for branch in found] == [1, 2]
    store = tmp_path / "branches_reference.zarr"
    line = next(line for line in tab.command(SETTING).splitlines() if line.startswith("vibroscope branch"))
    assert main([*line.replace(store.name, str(store)).split()[1:]]) == 0
    assert capsys.readouterr().err == ""
    assert store.exists()
    assert [repr(float(row["eta"])) for row in points] == [repr(each.value) for each in found[0].points]


def test_explore_follows_its_motion_into_the_branches_over_eta(opened):
    host = FakeHost()
    motions = CoexistingMotions(host)
    motions.follow(SETTING._replace(eta=3.0))
    send(motions.view, {"follow": True})
    key, texts, prepare = host.visits[0]
    assert (key, texts) == ("bifurcation", {})
    tab, _ = opened("count:20")
    prepare(tab)
    tab.show(Move(2, SETTING._replace(eta=3.0)))
    assert tab.panel.chosen["branches"] == "on"
    assert tab.view.span == (0.5, 4.0)  # the former range does not have this η
    assert searches()[-1].question.search.eta == 3.0
    assert searches()[-1].question.search.initial == SETTING.initial
    choose(tab, branches="both", over="K")
    prepare(tab)
    assert (tab.panel.chosen["over"], tab.panel.chosen["branches"]) == ("eta", "both")


def test_a_link_searches_first_for_the_motion_that_was_followed(opened):
    setting = SETTING._replace(eta=1.11212379937079, zero_start="zero", start_xi1=-0.123456789, start_v2=1 / 3)
    tab, _ = opened("count:20")
    tab.follow(setting)
    tab.show(Move(2, setting))
    tab.show(Move(3, setting._replace(eta=1.4, start_xi1=0.0)))
    question = searches()[-1].question
    assert question.followed == (setting.eta, setting.initial)
    linked = Bifurcation(FakeHost())
    linked.build()
    linked.restore(Bifurcation.read_view(**tab.view_texts()))
    linked.show(Move(1, setting._replace(eta=1.4)))
    assert searches()[-1].question == question
    other = setting._replace(kappa=2.4)
    for move, shown in enumerate((other, setting), start=2):  # it is no motion of another system, nor is it kept
        linked.show(Move(move, shown))
        assert searches()[-1].question.followed is None
        assert "followed" not in linked.view_texts()["choice"]
