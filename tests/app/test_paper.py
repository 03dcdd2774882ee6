"""The paper's claims: each as known, each able to fail, with the numbers checked in the model's description."""

import json
import subprocess
import sys
from dataclasses import replace
from functools import partial

import numpy as np
import pytest
from panel.models.esm import DataEvent
from vibroscope.app.commands import paper as command
from vibroscope.app.explorer.scenes import scenes
from vibroscope.app.export.formats import as_json
from vibroscope.app.page.paper.claims import draw
from vibroscope.app.page.paper.tab import Paper
from vibroscope.app.page.tab import Move
from vibroscope.app.paper import CLAIMS, as_dict, motions, penalties, planes
from vibroscope.app.paper import checks as checking
from vibroscope.app.paper.claim import SEEN, SYSTEM, newmark, reach, reference
from vibroscope.engine import ExactPenalty, Newmark, Reference, motion, simulate


@pytest.fixture(scope="module")
def findings():
    return {key: claim.find() for key, claim in CLAIMS.items()}


# ------------------------------------------------------------------------------------------------------------- claims


def test_every_figure_that_shows_a_result_is_remade():
    assert {claim.figure for claim in CLAIMS.values()} == {3, 4, 6, *range(9, 15)}
    assert list(CLAIMS)[:5] == ["3", "4A", "4B", "4C", "4D"]


@pytest.mark.parametrize("key", CLAIMS)
def test_a_claim_is_as_known(findings, key):
    finding = findings[key]
    assert finding.agrees == CLAIMS[key].holds, finding.found
    assert finding.found
    if not finding.agrees:
        assert finding.why


def test_all_that_is_found_is_json(findings):
    rows = [as_dict(CLAIMS[key], finding) for key, finding in findings.items()]
    assert json.loads(json.dumps(rows, allow_nan=False)) == rows


@pytest.mark.parametrize("key", CLAIMS)
def test_what_is_found_is_drawn(findings, key):
    plot = draw(findings[key].picture, f"paper{key}")
    assert plot.name == f"paper{key}"
    assert plot.renderers
    assert plot.x_range.start < plot.x_range.end
    assert plot.y_range.start < plot.y_range.end


@pytest.mark.parametrize(
    ("key", "scene"),
    [
        ("4A", "C"),
        ("4C", "A"),
        ("4D", "C"),
        ("6A", "C"),
        ("6B", "A"),
        ("9A", "9B"),
        ("9B", "9A"),
        ("10A", "10B"),
        ("10B", "10A"),
        ("13A", "10B"),
        ("13B", "14A"),
        ("14A", "10B"),
    ],
)
def test_a_check_fails_where_the_claim_does_not_hold(key, scene):
    assert not CLAIMS[key].check(scenes()[scene]).agrees


def test_the_check_of_the_step_agrees_where_the_step_does_no_harm():
    assert CLAIMS["14D"].check(scenes()["10B"]).agrees


def test_a_diagram_without_irregular_motion_is_not_the_paper_s(monkeypatch):
    true = motions.diagram(SYSTEM, Reference())
    flat = replace(true, displacement=true.displacement[:, :, :1].repeat(50, axis=2))
    monkeypatch.setattr(motions, "diagram", lambda *_: flat)
    assert not CLAIMS["3"].find().agrees


@pytest.mark.parametrize(
    ("key", "change"), [("11", {"regular": True}), ("12", {"steps": 99.0}), ("12", {"steps": 9.0})]
)
def test_planes_of_one_kind_are_not_the_paper_s(monkeypatch, key, change):
    cells = planes._cells()
    alike = {name: np.full_like(getattr(cells, name), value) for name, value in change.items()}
    monkeypatch.setattr(planes, "_cells", lambda: cells._replace(**alike))
    assert not CLAIMS[key].find().agrees


def test_cells_of_the_planes_are_what_single_runs_are(findings):
    divided, updated = findings["11"].picture, findings["12"].picture
    rng = np.random.default_rng(1)
    for row, column in zip(rng.integers(0, 19, 12), rng.integers(0, 22, 12), strict=True):
        K, D = divided.stiffness[column], divided.damping[row]
        free = simulate(SYSTEM, 2.76, ExactPenalty(K, D))
        stepped = simulate(SYSTEM, 2.76, Newmark(K, D, 2000))
        spread = [run.section[:, 2].std() / reach(run.section) for run in (free, stepped)]
        longest = np.diff(stepped.contacts, axis=1).max() / stepped.period * 2000
        wanted = 0 if spread[0] > SEEN else 1 if spread[1] > SEEN else 2
        assert divided.kind[row, column] == wanted
        assert updated.kind[row, column] == (0 if spread[0] > SEEN else 2 if round(longest, 6) < 30 else 1)


# ------------------------------------------------------------------------------- numbers of the model's description


def test_constants_of_table_1():
    assert pytest.approx(0.8722401775, abs=1e-10) == SYSTEM.mass_ratio
    assert SYSTEM.derived_joint_damping == pytest.approx(0.0084644, abs=1e-7)


@pytest.mark.parametrize(
    ("scene", "state"), [("A", [1.68339, 0.59798, 1.68339, 0.59798]), ("C", [-5.56905, -0.59972, 0.62677, 3.90177])]
)
def test_sections_of_figure_4(scene, state):
    np.testing.assert_allclose(reference(scenes()[scene]).section[-1], state, atol=1e-5)


def test_figure_4a_ten_impacts_and_nine_with_derived_damping():
    assert motion(reference(scenes()["A"])).impacts_per_period == 10
    found = motion(simulate(SYSTEM, 1.08, Reference("derived")))
    assert (found.period, found.impacts_per_period) == (1, 9)


def test_figure_4b_is_chaotic_in_two_bands():
    """Two runs 1e-9 apart drift apart by about +0.27 per period: chaos, not quasi-periodicity.

    Two bands: in ξ₁ the section leaves a gap in its middle, and visits its two sides in turn.
    """
    start = simulate(SYSTEM, 1.70, Reference(), periods=500, keep=1).section[-1]
    one = simulate(SYSTEM, 1.70, Reference(), periods=40, keep=40, initial=start).section
    other = simulate(SYSTEM, 1.70, Reference(), periods=40, keep=40, initial=start + np.array([0, 1e-9, 0, 0])).section
    rate = np.polyfit(np.arange(40), np.log(np.linalg.norm(one - other, axis=1)), 1)[0]
    assert 0.1 < rate < 0.5
    xi1 = simulate(SYSTEM, 1.70, Reference(), periods=2000, keep=200).section[:, 0]
    low, high = sorted((xi1[::2], xi1[1::2]), key=np.mean)
    assert low.max() < high.min()
    assert min(np.ptp(low), np.ptp(high)) > 0.5


def test_figure_9_three_contacts_the_last_long_and_one_of_56_percent():
    captured, missed = (newmark(scenes()[key]) for key in ("9A", "9B"))
    assert motion(captured).contacts_per_period == 3
    assert captured.section[-1, 2] == pytest.approx(1.6992, abs=1e-4)
    lengths = np.sort(np.diff(captured.contacts[1:4]).ravel())
    assert lengths[-1] > 3 * lengths[-2]
    assert motion(missed).contact_share == pytest.approx(0.56, abs=0.01)
    assert missed.section[-1, 2] == pytest.approx(1.03, abs=0.01)


def test_figure_12_contact_of_18_steps():
    run = newmark(scenes()["14A"])
    assert round(np.median(np.diff(run.contacts)) / run.period * 2000) == 18


def test_figure_14_scatter_falls_with_the_step_but_never_vanishes():
    """The kept 50 periods are a sample of a disturbed motion, so longer stretches are compared: roughly 1/n."""
    steps = np.array([2000, 4000, 6000, 8000, 32000])
    spread = np.array([penalties._scatter(scenes()["14A"], steps=int(n)) for n in steps])
    assert 0.1 < spread[0] < 0.4
    assert 0.003 < spread[-1] < 0.01
    assert -1.6 < np.polyfit(np.log(steps), np.log(spread), 1)[0] < -0.8


# --------------------------------------------------------------------------------------------- command line and tab


def test_the_command_tells_each_claim_and_fails_on_a_surprise(capsys, monkeypatch, findings):
    quick = {key: CLAIMS[key] for key in ("4C", "14D")}
    monkeypatch.setattr(command, "CLAIMS", quick)
    options = command.argparse.Namespace(json=True)
    assert command.run(options) == 0
    rows = json.loads(capsys.readouterr().out)
    assert [(row["figure"], row["agrees"]) for row in rows] == [("Figure 4 [C]", True), ("Figure 14 [D]", False)]
    assert rows[0]["found"] == findings["4C"].found
    monkeypatch.setattr(command, "CLAIMS", quick | {"14D": replace(CLAIMS["14D"], holds=True)})
    assert command.run(command.argparse.Namespace(json=False)) == 1
    assert "1 NOT as known" in capsys.readouterr().out


class _Host:
    doc = None

    def __init__(self):
        self.waiting, self.offers, self.summary = [], [], ""

    def update_offers(self):
        self.offers.append([figure.name for figure in self.tab.figures()])

    def call_later(self, callback):
        self.waiting.append(callback)

    def push(self, move, write):
        write()

    def summarise(self, text):
        self.summary = text


@pytest.fixture
def checks(monkeypatch):
    """Checks of this test alone, with a thread that works when it is told to."""
    thread = _Thread()
    monkeypatch.setattr(checking, "_thread", lambda: thread)
    monkeypatch.setattr("vibroscope.app.page.paper.tab.CHECKS", checking.Checks())
    return thread


class _Thread:
    def __init__(self):
        self.jobs = []

    def submit(self, job, *args):
        self.jobs.append(partial(job, *args))

    def work(self):
        while self.jobs:
            self.jobs.pop(0)()


def opened(host):
    tab = host.tab = Paper(host)
    tab.build()
    return tab


def test_a_claim_is_checked_when_it_is_seen_and_once(checks):
    host = _Host()
    tab = opened(host)
    assert checks.jobs == []
    assert tab.figures() == []
    for message in ({"seen": True}, {"seen": True}, {"seen": "no"}, "seen"):
        tab._cards["4C"]._process_event(DataEvent(None, message))
    assert len(checks.jobs) == 1
    checks.work()
    assert tab._cards["4C"].found == {}
    host.waiting.pop()()
    assert tab._cards["4C"].found["verdict"] == "agrees"
    assert len(tab._slots["4C"]) == 2
    assert all(len(slot) == 1 for key, slot in tab._slots.items() if key != "4C")
    assert [row["figure"] for row in json.loads(as_json(tab.data()))["claims"]] == ["Figure 4 [C]"]
    assert host.offers == [["claims", "paper4C"]]
    other = _Host()
    opened(other)._seen("4C")
    assert checks.jobs == []
    assert len(other.waiting) == 1


def test_a_hidden_tab_checks_nothing_and_goes_on_when_it_is_shown(checks, monkeypatch):
    found = []
    find = CLAIMS["4C"].check
    monkeypatch.setitem(CLAIMS, "4C", replace(CLAIMS["4C"], check=lambda scene: found.append(scene.key) or find(scene)))
    host = _Host()
    tab = opened(host)
    tab._seen("4C")
    tab.hide()
    checks.work()
    assert found == host.waiting == []
    tab.show(Move(1, None))
    checks.work()
    assert found == ["C"]
    host.waiting.pop()()
    assert tab._cards["4C"].found["verdict"] == "agrees"


def test_the_tab_says_how_many_claims_agree_once_all_in_view_are_known(checks):
    host = _Host()
    tab = opened(host)
    assert tab.summary(None) == f"0 of {len(CLAIMS)} claims checked."
    tab.show(Move(1, None))
    tab._seen("4C")
    tab._seen("14D")
    checks.work()
    host.waiting.pop(0)()
    assert host.summary == ""
    host.waiting.pop(0)()
    assert host.summary == tab.summary(None)
    assert host.summary == f"2 of {len(CLAIMS)} claims checked: 1 agree, 1 differ, 0 shown by example."


def test_what_is_shown_by_our_example_is_not_counted_as_agreeing(capsys, monkeypatch):
    assert [key for key, claim in CLAIMS.items() if claim.example] == ["10A", "10B", "10C", "13A", "13B"]
    found = CLAIMS["10B"].find()
    row = as_dict(CLAIMS["10B"], found)
    assert (row["verdict"], row["agrees"], row["known_to_agree"]) == ("shown by example", False, False)
    assert CLAIMS["10B"].verdict(replace(found, agrees=False)) == "differs"
    monkeypatch.setattr(command, "CLAIMS", {key: CLAIMS[key] for key in ("4C", "10B")})
    assert command.run(command.argparse.Namespace(json=False)) == 0
    told = capsys.readouterr().out
    assert "Figure 10 [B]  shown by example" in told
    assert "2 claims: 1 agree, 0 differ, 1 shown by example; all as known" in told


def test_a_check_that_fails_is_told_on_its_card(checks, monkeypatch):
    claim = CLAIMS["4C"]
    monkeypatch.setitem(CLAIMS, "4C", replace(claim, check=lambda scene: 1 / 0))
    host = _Host()
    tab = opened(host)
    tab._seen("4C")
    checks.work()
    host.waiting.pop()()
    told = tab._cards["4C"].found["error"]
    assert told == "This could not be checked (division by zero). Open another tab and come back to try again."
    monkeypatch.setitem(CLAIMS, "4C", claim)
    tab.hide()
    tab.show(Move(1, None))
    checks.work()
    host.waiting.pop()()
    assert tab._cards["4C"].found["verdict"] == "agrees"


def test_the_claims_need_no_page():
    code = "import sys, app.paper, app.commands.paper; print(*{'panel', 'bokeh', 'holoviews'} & set(sys.modules))"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == ""
