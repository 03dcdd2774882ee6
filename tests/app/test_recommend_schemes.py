"""Recommendations over all integrators, and over what a code has: schemes, order, table, words, JSON, bad input."""

import json
from dataclasses import replace

import pytest
from vibroscope.app.codes.catalogue import codes
from vibroscope.app.commands import recommend as command
from vibroscope.app.commands.cli import main
from vibroscope.app.explorer.method_words import scheme_texts
from vibroscope.engine import (
    HHT,
    INTEGRATORS,
    Cancelled,
    Newmark,
    Recommendation,
    SettingQuestion,
    System,
    TimeStepping,
    recommend_schemes,
)
from vibroscope.engine.recommendation.trials import NewmarkSetting, Trial

from tests.recommended import question

FEW = ["--eta", "1.08", "--tolerance", "0.3", "--K", "100", "--D", "3.68", "--steps-max", "16"]


def run(capsys, *arguments):
    status = main(["recommend", *arguments])
    return (status, *capsys.readouterr())


def made(scheme, met=True, steps=100, robust=0.04):
    best = robust and Trial(NewmarkSetting(1000.0, 5.0, steps), robust / 2, robust, float(steps))
    front = (best,) if best else ()
    asked, reason = SettingQuestion(System(), 1.08, scheme=scheme), "" if met else "why"
    return Recommendation(question=asked, eta=1.08, met=met, best=best or None, ranges={}, front=front, reason=reason)


@pytest.fixture
def asked(monkeypatch):
    """The schemes that the command asks for; nothing is searched."""
    schemes = []

    def listed(question, each, **_):
        schemes.extend(each)
        return [made(scheme) for scheme in each]

    monkeypatch.setattr(command, "recommend_schemes", listed)
    return schemes


def test_the_best_comes_first_and_two_stages_cost_twice(monkeypatch):
    answers = {
        "newmark": {"steps": 150},
        "hht": {"steps": 150, "robust": 0.03},
        "tr-bdf2": {"steps": 100, "robust": 0.01},
        "bathe": {"met": False, "robust": 0.2},
        "central-difference": {"met": False, "robust": 0.0},
        "semi-implicit-euler": {"met": False, "robust": 0.1},
    }
    shares = []

    def answered(question, *, progress, cancelled):
        progress(0.5)
        return made(question.scheme, **answers[question.scheme.integrator.name])

    monkeypatch.setattr("vibroscope.engine.recommendation.search.recommend", answered)
    schemes = [TimeStepping(1, 0, 1000, INTEGRATORS[name]()) for name in answers]
    found = recommend_schemes(question(System(), 1.08), schemes, progress=shares.append, cancelled=None)
    order = [each.scheme.integrator.name for each in found]
    assert order == ["hht", "newmark", "tr-bdf2", "semi-implicit-euler", "bathe", "central-difference"]
    assert [each.solves for each in found[:3]] == [150, 150, 200]
    assert shares == pytest.approx([(i + 0.5) / 6 for i in range(6)])


def test_a_search_over_nothing_is_refused_and_every_search_can_be_cancelled():
    with pytest.raises(ValueError, match="schemes is empty"):
        recommend_schemes(question(System(), 1.08), [])
    with pytest.raises(Cancelled):
        recommend_schemes(question(System(), 1.08), [Newmark(1, 0, 100)], cancelled=lambda: True)


@pytest.mark.parametrize("key", codes())
def test_a_code_has_the_integrators_of_its_table_with_its_status_and_law(key):
    code, schemes = codes()[key], codes()[key].schemes()
    own = code.method(1.0, 0.0, 1000)
    assert {each.integrator.name for each in schemes} == {own.integrator.name, *code.integrators}
    assert replace(own, damping=0.0) in schemes  # the search gives D
    for each in schemes:
        assert (each.law, each.without_solution) == (own.law, own.without_solution)
        if each.integrator.explicit:
            assert each.status == "start"
        elif code.status:
            assert each.status == code.status
    if not code.status:
        assert {each.status for each in schemes} == {"start", "end"}


def test_all_integrators_are_asked_with_whole_and_with_located_steps(asked, capsys):
    status, out, _ = run(capsys, *FEW, "--integrator", "all", "--alpha", "-0.2")
    assert status == 0
    assert [each.located for each in asked] == [False] * len(INTEGRATORS) + [True] * len(INTEGRATORS)
    assert asked[0] == Newmark(1.0, 0.0, 1000)
    assert [each.integrator.alpha for each in asked[1:3]] == [-0.2, -0.2]
    assert out.splitlines()[1].split() == [
        "integrator",
        "status",
        "K",
        "D",
        "steps",
        "solves",
        "error",
        "robust",
        "met",
    ]
    assert "located           for codes that cut the step where contact changes" in out
    assert "for               codes with a constant step" in out


@pytest.mark.parametrize(
    ("options", "statuses"),
    [
        (["--status", "end", "--without-solution", "keep"], {"start", "end"}),
        (["--status", "start"], {"start"}),
        (["--located"], {"located"}),
        (["--status", "start", "--law", "hunt-crossley"], {"start"}),
    ],
)
def test_what_is_given_holds_for_all_integrators(asked, capsys, options, statuses):
    status, out, err = run(capsys, *FEW, "--integrator", "all", *options)
    assert (status, len(asked)) == (0, len(INTEGRATORS))
    assert {each.status for each in asked} == statuses
    assert ("knows the gap before the force" in err) == ("end" in options)
    assert "located           for" not in out
    if "--located" in options:
        assert "for               codes that cut the step where contact changes" in out


def test_a_code_is_answered_in_its_words(capsys, tmp_path, monkeypatch):
    found = []  # by the first of two calls that ask for the same

    def searched(*problem, **how):
        found.extend(() if found else recommend_schemes(*problem, **how))
        return found

    monkeypatch.setattr(command, "recommend_schemes", searched)
    path = tmp_path / "system.toml"
    path.write_text("[units]\nomega1 = 3.0\nm1 = 2.0\nbase_amplitude = 0.5\n")
    asked = [*FEW, "--code", "abaqus-standard", "--units", "--system", str(path)]
    _, out, _ = run(capsys, *asked)
    assert out.startswith("Abaqus/Standard (abaqus-standard): what it has; eta = 1.08, tolerance 30 %")
    rows = [line.split() for line in out.splitlines()[2:4]]
    assert {row[0] for row in rows} == {"newmark", "hht"}
    assert {row[2 if row[0] == "hht" else 3] for row in rows} == {"end"}
    assert "what to set       *DYNAMIC, ALPHA=" in out
    assert "not computed here The size of its increments" in out
    _, text, _ = run(capsys, *asked, "--json")
    report = json.loads(text)
    best = report["found"][0]
    assert (report["code"], best["law"], best["status"]) == ("abaqus-standard", "kelvin-voigt", "end")
    assert best["robust"] <= report["found"][1]["robust"] or best["solves"] < report["found"][1]["solves"]
    step = best["physical"]["time_step"]
    assert float(report["input"][1].split(",")[0]) == pytest.approx(step, rel=1e-4)
    assert set(best["integrator_numbers"]) == ({"alpha"} if best["integrator"] == "hht" else {"beta", "gamma"})


def test_a_code_without_a_setting_says_why_and_has_no_words(monkeypatch, capsys):
    nothing = [made(each, met=False, robust=0.0) for each in codes()["opensees"].schemes()]
    monkeypatch.setattr(command, "recommend_schemes", lambda *_, **__: nothing)
    status, out, _ = run(capsys, *FEW, "--code", "opensees")
    assert status == 0
    assert "not met           why" in out
    assert "what to set" not in out


def test_the_texts_of_a_scheme_are_those_of_its_code():
    for code in codes().values():
        assert scheme_texts(code.method(5.0, 2.0, 10)) == code.texts()
    changed = replace(codes()["opensees"].method(1, 1, 4), integrator=HHT(-0.2))
    assert (scheme_texts(changed)["integrator"], scheme_texts(changed)["alpha"]) == ("hht", "-0.2")
