"""``vibroscope bench``: its JSON and its table, and that the peers solve the same problems."""

import json

import numpy as np
import pytest
from vibroscope.app.commands.cli import main
from vibroscope.app.performance import bench, peers
from vibroscope.app.performance.bench import CHECKED, SYSTEM
from vibroscope.engine import ExactPenalty, Newmark, Reference, simulate

SCENES = {"A": (1.08, 2500.0, 8.0), "B": (1.70, 12000.0, 18.0), "C": (2.76, 12000.0, 18.0), "D": (3.25, 12000.0, 18.0)}


@pytest.fixture(scope="module")
def quick():
    """One round of few periods, so that the whole report takes seconds; once for the JSON and the table."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(peers, "heyoka_version", lambda: None)
        found = bench.report(periods=12, rounds=1)
        patch.setattr(bench, "report", lambda: found)
        yield


@pytest.fixture
def no_heyoka(monkeypatch):
    monkeypatch.setattr(peers, "heyoka_version", lambda: None)


@pytest.mark.usefixtures("quick")
def test_json_is_the_contract(capsys):
    assert main(["bench", "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert (found["heyoka"], found["periods"], found["rounds"]) == (None, 12, 1)
    assert {key: (s["eta"], s["K"], s["D"]) for key, s in found["scenes"].items()} == SCENES
    for scene in found["scenes"].values():
        for name in ("reference", "exact"):
            assert 0 < scene[f"{name}_us_per_period"] < 1e4
            assert scene["errors"][name] < 1e-10
        assert 0 < scene["newmark_plain_ns_per_step"] < 1e4
        assert 0 < scene["newmark_every_step_ns_per_step"] < 1e4
        for name in ("newmark_fast", "newmark_located"):
            assert list(scene[f"{name}_us_per_period"]) == ["2000", "8000"]
            assert all(0 < cost < 1e6 for cost in scene[f"{name}_us_per_period"].values())
        # the plain loop and the engine's Newmark are one discrete solution
        plain, fast = scene["errors"]["newmark_plain"], scene["errors"]["newmark_fast"]
        assert list(plain) == ["2000", "8000"]
        assert all(abs(plain[n] - fast[n]) < 1e-6 for n in plain)
        assert scene["heyoka_us_per_period"] is scene["errors"]["heyoka"] is None
        assert any("heyoka is not installed" in note for note in scene["notes"])


@pytest.mark.usefixtures("quick")
def test_text_names_every_solver(capsys):
    assert main(["bench"]) == 0
    out = capsys.readouterr().out
    for words in ("[A] eta = 1.08", "reference", "exact penalty", "Newmark T/8000, plain loop", "heyoka not installed"):
        assert words in out


@pytest.mark.usefixtures("no_heyoka")
def test_without_the_solutions_errors_are_null_with_a_reason(monkeypatch, tmp_path):
    monkeypatch.setattr(bench, "TRUTH", tmp_path)
    bench.solutions.cache_clear()
    try:
        found = bench.measure_scene(*SCENES["C"], periods=2, rounds=1)
    finally:
        bench.solutions.cache_clear()
    errors = found["errors"]
    assert errors["reference"] is errors["exact"] is errors["newmark_fast"]["2000"] is None
    assert sum("assets/truth are not here" in note for note in found["notes"]) == 2


@pytest.mark.parametrize(("eta", "stiffness", "damping"), SCENES.values())
def test_there_is_a_solution_for_every_scene(eta, stiffness, damping):
    for method in (bench.REFERENCE, ExactPenalty(stiffness, damping)):
        state = bench.true_state(eta, method)
        assert state is not None
        found = simulate(SYSTEM, eta, method, periods=CHECKED, keep=1).section[-1]
        assert np.abs(found - state).max() < 1e-10
    assert bench.true_state(eta, Reference("derived", threshold=0.5)) is None


def test_costs_are_medians_and_ratios_are_those_of_the_turns():
    seconds = {"ours": iter([9, 1, 2, 40]), "theirs": iter([9, 3, 8, 80])}  # the first compiles

    def contender(name):
        return bench.Contender(name, lambda periods: (next(seconds[name]), np.zeros(4)))

    turns = bench.time_in_turns([contender("ours"), contender("theirs")], periods=1, rounds=3)
    assert np.median(turns["ours"]) == 2e6
    assert bench.ratio(turns, "theirs", "ours") == 3
    assert bench.ratio(turns, "absent", "ours") is None


@pytest.mark.parametrize(("eta", "stiffness", "damping"), [SCENES["A"], SCENES["C"]])
def test_the_plain_loop_is_the_same_discrete_solution(eta, stiffness, damping):
    state = peers.plain_loop(SYSTEM, eta, stiffness, damping, 2000)(5)
    method = Newmark(stiffness, damping, 2000, every_step=True)
    response = simulate(SYSTEM, eta, method, periods=5, keep=1)
    np.testing.assert_allclose(state, response.section[-1], atol=1e-9)


@pytest.mark.parametrize(("eta", "stiffness", "damping"), SCENES.values())
def test_heyoka_solves_both_problems(eta, stiffness, damping):
    pytest.importorskip("heyoka", reason="optional: pip install heyoka")
    d3, threshold = SYSTEM.derived_joint_damping, bench.REFERENCE.threshold
    reference = peers.heyoka_reference(SYSTEM, eta, d3, threshold)
    penalty = peers.heyoka_penalty(SYSTEM, eta, stiffness, damping)
    for run, method in ((reference, bench.REFERENCE), (penalty, ExactPenalty(stiffness, damping))):
        for _ in range(2):  # a run leaves nothing behind
            assert np.abs(run(CHECKED) - bench.true_state(eta, method)).max() < 1e-12
