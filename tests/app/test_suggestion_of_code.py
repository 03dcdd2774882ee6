"""Suggest K, D, Δτ over what a code has, where the tab Your code has one chosen."""

import queue
from dataclasses import replace

import pytest
from vibroscope.app.codes.catalogue import codes
from vibroscope.app.explorer import suggestion
from vibroscope.app.explorer.errors import Refused
from vibroscope.app.explorer.reading import read_setting
from vibroscope.app.explorer.suggestion import OfSchemes, Question, make_question, suggestion_content
from vibroscope.app.page.explore.suggest import Suggester
from vibroscope.app.page.tab import Move
from vibroscope.app.page.your_code.tab import YourCode
from vibroscope.app.runtime.cache import Cache
from vibroscope.engine import HHT, Newmark, NewmarkBeta

from tests.app.fakes import FakeHost, QueueingHost, send
from tests.app.searches import SETTING, TRIAL, WORSE, found_for
from tests.waiting import PATIENCE

ABAQUS = codes()["abaqus-standard"]
SCHEMES = ABAQUS.schemes()


def found(others=(), **more):
    question = make_question(SETTING, {"tolerance": "5"})
    best, *rest = (
        found_for(question._replace(search=replace(question.search, scheme=scheme)), **each)
        for scheme, each in ((SCHEMES[0], more), *others)
    )
    return OfSchemes(**vars(best), others=tuple(rest))


@pytest.fixture
def searched(monkeypatch):
    """`recommend_schemes` replaced by one that answers at once; what it was called with."""
    calls = queue.Queue()

    def listed(question, schemes, **_):
        calls.put((question, schemes))
        return [found_for(Question(replace(question, scheme=scheme))) for scheme in schemes]

    monkeypatch.setattr(suggestion, "recommend_schemes", listed)
    monkeypatch.setattr(suggestion, "CACHE", Cache(2))
    return calls


def test_the_question_is_of_the_code_whatever_integrator_is_set():
    asked = make_question(SETTING._replace(located="yes"), {"tolerance": "5"}, SCHEMES)
    assert asked.schemes == SCHEMES
    other = read_setting({"integrator": "bathe", "law": "hunt-crossley"})
    assert asked.follow(other) == asked
    assert asked.follow(other._replace(eta=1.2)) != asked
    assert asked != make_question(SETTING, {"tolerance": "5"})
    with pytest.raises(Refused, match="searched at one frequency"):
        make_question(SETTING, {"tolerance": "5", "from": "1", "to": "1.2"}, SCHEMES)


def test_a_suggestion_of_a_code_sets_its_integrator_and_speaks_its_words(searched):
    host = QueueingHost()
    host.code = "abaqus-standard"
    suggester = Suggester(host)
    suggester.follow(SETTING)
    assert suggester.view.code == "Abaqus/Standard"
    send(suggester.view, {"suggest": {"tolerance": "5", "code": "yes"}})
    question, schemes = searched.get(timeout=PATIENCE)
    assert (question.etas, schemes) == ((SETTING.eta,), SCHEMES)
    host.catch_up_until(lambda: suggester.view.content["phase"] == "done")
    method = read_setting(host.settings[-1], SETTING._replace(located="yes")).penalty
    assert method == replace(SCHEMES[0], stiffness=10500.0, damping=15.8, steps=5793)
    lines = suggester.view.content["lines"]
    assert lines[0].startswith("HHT-α, forces averaged (α = −0.05): K = 10500, D = 15.8")
    assert any(line.startswith("Newmark (β = 0.25, γ = 0.5): K = 10500") for line in lines)
    verified = "contact status iterated to the end of the step; contact law Kelvin–Voigt; from rest."
    assert f"Verified for HHT-α; {verified}" in lines
    assert lines[-1].startswith("What to set in Abaqus/Standard: *DYNAMIC, ALPHA=-0.05, DIRECT; 0.001")


@pytest.mark.parametrize("unchecked", [True, False])
def test_without_a_code_the_search_is_of_what_is_set(searches, unchecked):
    host = QueueingHost()
    suggester = Suggester(host)
    suggester.follow(SETTING)
    assert suggester.view.code == ""
    host.code = "abaqus-standard"
    suggester.follow(SETTING)
    assert suggester.view.code == "Abaqus/Standard"
    if unchecked:
        send(suggester.view, {"suggest": {"tolerance": "5", "code": ""}})
    else:
        host.code = ""  # no longer chosen
        send(suggester.view, {"suggest": {"tolerance": "5", "code": "yes"}})
    question, _, _, answer, _ = searches.get(timeout=PATIENCE)
    assert question.scheme == Newmark(1.0, 0.0, 1000)
    answer.put(found_for(make_question(SETTING, {"tolerance": "5"})))
    host.catch_up()
    assert "In the words" not in str(suggester.view.content)
    assert host.settings[-1].keys() == {"K", "D", "steps"}


def test_what_the_other_integrators_need_is_said_with_their_reason():
    others = (
        (replace(SCHEMES[0], integrator=NewmarkBeta()), {"met": False, "best": WORSE}),
        (replace(SCHEMES[0], integrator=HHT(-0.3)), {"met": False, "best": None, "front": (), "reason": "none ran"}),
    )
    content = suggestion_content(found(others, best=TRIAL), SETTING)
    text = " ".join(content["lines"])
    assert (
        "Newmark (β = 0.25, γ = 0.5): not met: K = 2000, D = 7, T/Δτ = 500 steps a period: error 30 %, 500 solves."
        in text
    )
    assert "(α = −0.3): none ran." in text
    assert content["front"][0][2] == content["use"] == {**content["use"], "integrator": "hht", "located": "no"}
    nothing = found(others, met=False, best=None, front=(), reason="no run reached its end")
    assert suggestion_content(nothing, SETTING)["lines"][0] == (
        "HHT-α, forces averaged (α = −0.05): no run reached its end."
    )
    assert len(suggestion_content(nothing, SETTING)["lines"]) == 3
    located = suggestion_content(found_for(make_question(SETTING._replace(located="yes"), {"tolerance": "5"})), SETTING)
    assert located["lines"][-1].startswith("Verified for Newmark; steps cut where contact changes;")


def test_the_tab_your_code_tells_which_code_is_chosen():
    host = FakeHost()
    tab = YourCode(host)
    tab.build()
    tab.restore(YourCode.read_view("", "code:opensees", ""))
    tab.show(Move(1, SETTING))
    assert host.code == "opensees"
    tab.panel.receive({"choose": {"code": "calculix"}})
    assert host.code == "calculix"
    tab.panel.receive({"choose": {"code": "none"}})
    assert host.code == ""
    tab.close()
