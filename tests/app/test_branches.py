"""The branches of a diagram: how they are searched for, paired, drawn, and opened in Explore."""

import numpy as np
import pytest
from vibroscope.app.explorer.field_units import shown_field
from vibroscope.app.explorer.link import parse_address, print_address, print_choice
from vibroscope.app.explorer.reading import read_setting
from vibroscope.app.explorer.state import Setting
from vibroscope.app.page.bifurcation.branches import Branches, Place, opened, place_named, stretches, thinned
from vibroscope.app.page.bifurcation.figure import BifurcationView
from vibroscope.app.page.explore.other_motions import OpenedMotion
from vibroscope.app.page.explore.tab import Explore
from vibroscope.app.page.shared.seen import stability_words
from vibroscope.app.studies import branches as study
from vibroscope.app.studies.branches import BranchesQuestion, grow_branches, matched, why_none
from vibroscope.engine import (
    POINT_KINDS,
    Branch,
    Cancelled,
    ExactPenalty,
    Point,
    Reference,
    System,
    TimeStepping,
    simulate,
    steady,
)

from tests.app.fakes import FakeHost, send
from tests.few_seeds import few_seeds

SETTING = Setting(eta=1.42, K=12000.0, D=18.0)
QUESTION = BranchesQuestion(System(), Reference(), (1.3, 1.5))  # a motion that doubles its period and returns


def never():
    return False


@pytest.fixture(scope="module")
def grown():
    with few_seeds():
        return list(grow_branches(QUESTION, None, never))


@pytest.fixture
def shown(grown):
    """The branches of a tab in a figure of 2 × 4 units over 400 × 400 pixels, with their host."""
    figures = BifurcationView()
    figures.ranges["eta"].put(1.3, 1.5)
    figures.ranges["value"].put(-4, 4)
    made = Branches(host := FakeHost(), figures, lambda: None)
    made.ask({})
    made.studies["reference"].result = grown[-1]
    made.draw(SETTING, "eta", "xi2", [])
    return made, host


def test_the_branches_grow_one_by_one_and_the_last_result_is_complete(grown):
    assert [len(each.branches) for each in grown] == [1, 2, 2]
    assert [each.share for each in grown] == [0, 0, 1]
    assert grown[-1].words() == "2 branches of up to 4 periods with 2 period doublings"
    assert grown[-1].cut == ""


def test_a_search_that_begins_anew_keeps_what_was_found(grown):
    again = grow_branches(QUESTION, grown[1], never)
    assert next(again).branches == grown[1].branches
    again.close()


def test_a_search_is_cancelled_and_its_time_and_number_have_a_limit(monkeypatch):
    with pytest.raises(Cancelled):
        list(grow_branches(QUESTION, None, lambda: True))
    monkeypatch.setattr(study, "MOST_BRANCHES", 1)
    *_, last = grow_branches(QUESTION, None, never)
    assert (len(last.branches), last.share) == (1, 1)
    assert last.cut == "The search ended at 1 branches: a narrower range shows the others."
    monkeypatch.setattr(study, "SECONDS", -1.0)
    *_, last = grow_branches(QUESTION, None, never)
    assert (last.branches, last.share) == ((), 1)
    assert last.cut.startswith("The search ended after -1 s and may have missed branches")


def test_the_motions_near_a_value_are_those_whose_branch_passes_it(grown):
    result = grown[-1]
    near = {result.branches[n].period: result.branches[n].values[k] for n, k in result.near(1.42)}
    assert near == {1: pytest.approx(1.42, abs=0.01), 2: pytest.approx(1.42, abs=0.01)}
    assert [result.branches[n].period for n, _ in result.near(1.32)] == [1]
    assert result.near(9.0) == []


def test_the_tables_have_every_orbit_and_every_point(grown):
    orbits, points = grown[-1].orbit_table(), grown[-1].point_table()
    assert len(orbits["eta"]) == sum(len(each.values) * each.period for each in grown[-1].branches)
    second = grown[-1].branches[1]
    np.testing.assert_array_equal(orbits["xi2"][orbits["branch"] == 2], second.sections[..., 2].ravel())
    np.testing.assert_array_equal(orbits["section"][orbits["branch"] == 2][:4], [0, 1, 0, 1])
    assert points["kind"].tolist() == ["period doubling"] * 2
    np.testing.assert_allclose(points["multiplier_re"], -1, atol=1e-6)


def point(kind, value, period=1):
    return Point(kind, value, period, np.ones(4, complex), np.zeros(4), (), np.empty(0), 0)


def test_points_are_paired_by_kind_period_and_nearest_value():
    first = [point("fold", 1.0), point("fold", 2.0), point("fold", 2.1), point("grazing", 3.0), point("fold", 5.0, 2)]
    second = [point("fold", 1.1), point("fold", 1.2), point("fold", 2.3), point("grazing", 3.1, 2)]
    pairs = [tuple(each and (each.kind, each.value) for each in pair) for pair in matched(first, second)]
    assert pairs == [
        (("fold", 1.0), ("fold", 1.1)),
        (None, ("fold", 1.2)),
        (("fold", 2.0), None),
        (("fold", 2.1), ("fold", 2.3)),
        (("grazing", 3.0), None),
        (None, ("grazing", 3.1)),
        (("fold", 5.0), None),
    ]


@pytest.mark.parametrize(
    ("over", "method", "why"),
    [
        ("eta", Reference(), ""),
        ("D", ExactPenalty(1e4, 10), ""),
        ("restitution", Reference(), ""),
        ("steps", ExactPenalty(1e4, 10), "without a time step"),
        ("K", Reference(), "The reference has no K"),
        ("restitution", ExactPenalty(1e4, 10), "The penalty model has no restitution"),
        ("eta", TimeStepping(1e4, 10, 500, law="cut").limit, "contact law cut: choose kelvin-voigt"),
        ("eta", ExactPenalty(1e4, 10, law="flores"), "contact law flores"),
    ],
)
def test_a_sentence_says_why_there_are_no_branches(over, method, why):
    assert why in why_none(over, method)
    assert bool(why) == bool(why_none(over, method))


def test_every_kind_of_points_has_a_mark_of_its_own():
    kinds = POINT_KINDS.values()
    assert len({kind.marker for kind in kinds}) == len({kind.sign for kind in kinds}) == len(POINT_KINDS)


def test_lines_are_solid_or_dashed_without_gaps():
    is_stable = np.array([True, True, True, False, False, True, False, True, True])
    assert stretches(is_stable, True) == [(0, 3), (7, 9)]
    assert stretches(is_stable, False) == [(2, 8)]


def test_a_line_keeps_the_vertices_that_can_be_seen():
    x = np.linspace(0, 1, 2001)
    line = np.stack([x, x**3 + 1e-6 * np.sin(900 * x)], axis=1)
    kept = thinned(line)
    assert kept[0] == 0
    assert kept[-1] == 2000
    assert len(kept) < 60
    assert np.abs(np.interp(x, x[kept], line[kept, 1]) - line[:, 1]).max() < 6e-4


def test_a_tap_means_the_nearest_orbit_or_a_point_close_to_it(shown, grown):
    made, host = shown
    branch = grown[-1].branches[1]
    k = int(np.argmin(np.abs(branch.values - 1.42)))
    assert made.tapped(branch.values[k], branch.sections[k, 1, 2])
    assert not made.tapped(1.42, -3.9)
    key, texts, _ = host.visits.pop()
    assert key == "explore"
    assert float(texts["eta"]) == branch.values[k]
    doubling = grown[-1].branches[0].points[0]
    place = made.lines.at(doubling.value, doubling.state[2])
    assert (place.solver, place.branch, place.kind) == ("reference", 0, "point")


def test_an_opened_motion_is_that_of_the_branch(grown):
    branch = grown[-1].branches[1]
    for k in (0, len(branch.values) // 2):
        texts, words, orbit = opened(QUESTION, Place("reference", 1, "orbit", k), branch)
        setting = read_setting(texts, SETTING)
        run = simulate(setting.system, setting.eta, setting.reference, initial=setting.initial, periods=2, keep=2)
        np.testing.assert_allclose(run.section[-1], setting.initial, atol=1e-8)
        assert "the reference repeats every 2 periods, stable" in words
        columns = orbit.columns(setting)
        for name in ("x1", "x2"):
            assert columns[name][0] == pytest.approx(columns[name][-1], abs=1e-4)
            assert np.ptp(columns[name]) > 1


def test_a_motion_with_overlap_is_opened_beside_it_and_the_words_say_so():
    method, eta = ExactPenalty(20.0, 0.5), 1.1
    found = steady(System(), eta, method, max_period=4)
    assert found.periodic
    assert System().overlap_of(found.state) > 1e-3
    rows, multipliers = np.tile(found.state, (1, found.period, 1)), np.full((1, 4), 0.5 + 0j)
    branch = Branch("eta", found.period, np.array([eta]), rows, multipliers, (), (), ("", ""))
    texts, words, orbit = opened(BranchesQuestion(System(), method, (1, 2)), Place("penalty", 0, "orbit", 0), branch)
    assert "the bodies overlap in it" in words
    assert float(texts["start_xi1"]) == float(texts["start_xi2"]) == pytest.approx(found.state[2])
    columns = orbit.columns(read_setting(texts, SETTING))
    assert columns["x1"][0] == pytest.approx(columns["x1"][-1], abs=1e-3)


def test_words_say_how_fast_a_run_leaves_an_unstable_motion():
    assert stability_words(0.5 + 0j, 1) == "stable (largest multiplier 0.5)."
    assert stability_words(complex(np.nan), 1) == "of unknown stability."
    nearly = "unstable (largest multiplier 1.0000011): a small deviation grows 1.0000011-fold every period"
    assert stability_words(1.0000011 + 0j, 1).startswith(nearly)
    words = stability_words(-10 + 0j, 2)
    assert words.startswith("unstable (largest multiplier −10): a small deviation grows 10-fold every 2 periods")
    assert "after about 24 excitation periods" in words
    assert "−0.6 ± 1.2i" in stability_words(-0.6 + 1.2j, 1)
    assert "∞" in stability_words(complex(np.inf, 0), 1)
    assert POINT_KINDS["Neimark-Sacker"].words() == "Neimark–Sacker point"


def test_tables_are_in_the_units_of_the_setting_and_say_the_shift(shown, grown):
    made, _ = shown
    made.ask({"reference": QUESTION, "penalty": QUESTION._replace(span=(1.3, 1.5001))})
    made.cancel()
    for each in made.studies.values():
        each.result = grown[-1]
    physical = SETTING._replace(units="si", omega1=20.0)
    made.draw(physical, "eta", "xi2", ["A note."])
    assert made.view.status["notes"] == ["A note."]
    assert made.view.points["heads"] == ["kind", "period", "reference", "exact penalty", "shift"]
    row = [cell["text"] for cell in made.view.points["rows"][0]["cells"]]
    value = shown_field("eta", physical).factor * grown[-1].branches[0].points[0].value
    assert row[:2] == ["period doubling", "1"]
    assert float(row[2].removesuffix(" Hz")) == pytest.approx(value)
    assert row[3:] == [row[2], "+0 Hz"]


@pytest.mark.parametrize(
    "message", [{"open": "reference:9:orbit:0"}, {"open": "reference:0:orbit:99999"}, {"open": "x:0:point:0"},
                {"open": "reference:-1:orbit:0"}, {"open": "reference:0:__class__:0"}, {"open": 3}, "open", {}],
)  # fmt: skip
def test_a_forged_message_opens_nothing(shown, message):
    made, host = shown
    send(made.view, message)
    assert host.visits == []
    send(made.view, {"open": "reference:0:point:0"})
    assert host.visits
    assert place_named("reference:0:point:0") == Place("reference", 0, "point", 0)


def test_the_line_in_explore_stays_as_long_as_its_setting(grown):
    texts, words, orbit = opened(QUESTION, Place("reference", 1, "orbit", 5), grown[-1].branches[1])
    line = OpenedMotion()
    line.announce(texts, words, orbit)
    line.follow(SETTING)
    assert not line.visible
    set_to = read_setting(texts, SETTING)
    line.follow(set_to)
    assert (line.visible, line.words) == (True, words)
    line.follow(set_to._replace(frame="absolute"))
    assert line.visible
    assert line.columns(set_to)
    line.follow(set_to._replace(K=13000.0))
    assert not line.visible
    assert line.columns(set_to) == {}
    line.follow(set_to)
    assert line.visible
    send(line, {"close": True})
    line.follow(set_to)
    assert not line.visible


@pytest.mark.parametrize("solver", ["reference", "penalty"])
def test_a_link_has_the_motion_again_also_where_its_bodies_overlap(solver, grown):
    if solver == "reference":
        branch, place, question = grown[-1].branches[1], Place("reference", 1, "orbit", 5), QUESTION
    else:
        method = ExactPenalty(20.0, 0.5)
        found = steady(System(), 1.1, method, max_period=4)
        rows, multipliers = np.tile(found.state, (1, found.period, 1)), np.full((1, 4), 0.5 + 0j)
        branch = Branch("eta", found.period, np.array([1.1]), rows, multipliers, (), (), ("", ""))
        place, question = Place("penalty", 0, "orbit", 0), BranchesQuestion(System(), method, (1, 2))
    texts, _, orbit = opened(question, place, branch)
    line, again = OpenedMotion(), OpenedMotion()
    setting = read_setting(texts, SETTING if solver == "reference" else SETTING._replace(K=20.0, D=0.5))
    line.announce(texts, "", orbit)
    assert line.choice() == {}
    line.follow(setting)
    view = Explore.read_view("", print_choice(line.choice()), "")
    assert ("orbit_xi1" in view.choice) == (solver == "penalty")
    again.restore(view.choice)
    again.follow(read_setting(parse_address(print_address(setting))))
    assert again.visible
    assert f"repeats every {branch.period} periods" in again.words or branch.period == 1
    if solver == "reference":  # the other branch is made up
        assert stability_words(branch.multipliers[5, 0], branch.period) in again.words
    for name, column in line.columns(setting).items():
        np.testing.assert_array_equal(again.columns(setting)[name], column)
    again.follow(setting._replace(K=setting.K + 1.0))
    assert again.choice() == {}


def test_a_link_to_a_motion_that_is_none_shows_nothing():
    line = OpenedMotion()
    line.restore({"reference_orbit": 3})
    line.follow(SETTING)
    assert (line.visible, line.choice()) == (False, {})
