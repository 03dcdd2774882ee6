"""Kinds of motion on the page: of the setting that is shown, and of the cells of a bifurcation diagram."""

from dataclasses import replace

import numpy as np
import pytest
from vibroscope.app.explorer import motion_kind
from vibroscope.app.explorer.compute import compute_runs
from vibroscope.app.explorer.explanation import explain
from vibroscope.app.explorer.motion_kind import describe_kind, judge_motions, keep_kind, known_kinds, with_kinds
from vibroscope.app.explorer.state import Setting
from vibroscope.app.page.bifurcation.figure import BifurcationView, legend
from vibroscope.app.page.bifurcation.panel import statements
from vibroscope.app.runtime.cache import Cache
from vibroscope.app.studies.bifurcation import DiagramQuestion, grow_diagram
from vibroscope.engine import Cancelled, Kind, Newmark, Reference, System, motion
from vibroscope.engine.sweeps import CellKind

SYSTEM = System()
SCATTERED = Setting(eta=2.76, K=12000.0, D=18.0, steps=2000)


def never():
    return False


@pytest.fixture(autouse=True)
def nothing_known(monkeypatch):
    monkeypatch.setattr(motion_kind, "KINDS", Cache(20))


def test_scatter_of_the_step_is_named_an_artefact_and_judged_once():
    assert known_kinds(SCATTERED) is None
    kinds = judge_motions(SCATTERED, never)
    assert kinds["reference"].kind == "periodic"
    assert kinds["penalty"].kind is Kind.ARTEFACT
    assert kinds["penalty"].name == "period 1, blurred by the time step"
    for text in ("artefact", "T/2000", "T/8000", "largest Floquet multiplier"):
        assert text in kinds["penalty"].evidence
    assert known_kinds(SCATTERED) == kinds
    texts = with_kinds({"Penalty": "One period."}, kinds)
    assert texts["Penalty"].startswith("One period. Period 1, blurred by the time step. The blur is")


@pytest.mark.parametrize(("made", "words"), [(0.5, "creates 25 %"), (-0.02, "removes 1 %"), (0.001, ""), (np.nan, "")])
def test_what_the_time_step_makes_of_the_energy_is_said_where_it_counts(made, words):
    found = replace(motion(SYSTEM, 2.76, Reference()), energy_lost=2.0, energy_created=made)
    text = describe_kind(found).evidence
    assert f"The time step {words}" in text if words else "The time step" not in text
    assert "The time step" not in describe_kind(replace(found, energy_lost=0.0)).evidence


def test_chaos_is_named_with_its_exponent():
    found = motion(SYSTEM, 1.70, Reference())
    kind = describe_kind(found)
    assert kind.kind == "chaotic"
    assert f"{found.lyapunov:+.3g} ± " in kind.evidence
    assert f"factor of {np.exp(found.lyapunov):.3g}" in kind.evidence


def test_a_motion_that_takes_too_long_is_undecided_and_a_cancelled_one_is_not_judged(monkeypatch):
    monkeypatch.setattr(motion_kind, "SECONDS", 0.0)
    assert judge_motions(SCATTERED, never)["penalty"].kind == "undecided"
    monkeypatch.setattr(motion_kind, "KINDS", Cache(20))
    with pytest.raises(Cancelled):
        judge_motions(SCATTERED, lambda: True)
    assert known_kinds(SCATTERED) is None


@pytest.fixture
def scattered_diagram():
    """Results of a short diagram of Newmark's method with scatter and chaos in it."""
    question = DiagramQuestion(SYSTEM, Newmark(12000, 18, 2000), "rest", (1.70, 2.78), count=9, transient=300)
    return list(grow_diagram(question, None, never))


def test_a_diagram_is_judged_after_it_is_complete_and_goes_on_where_it_was(scattered_diagram):
    known = [result for result in scattered_diagram if result.known.all()]
    assert len(known) >= 2
    first, whole = known[0], known[-1]
    assert 0.5 <= first.share < 1 == whole.share
    kinds = whole.kinds["kind"]
    assert kinds[0] == CellKind.CHAOTIC
    assert (kinds == CellKind.ARTEFACT).sum() >= 3
    assert CellKind.UNKNOWN not in kinds
    assert "kind not judged" in statements(SCATTERED, first)[-1][1]
    assert "periodic but blurred by the time step" in statements(SCATTERED, whole)[-1][1]
    resumed = list(grow_diagram(whole.question, whole, never))
    assert len(resumed) == 1  # nothing is judged again
    np.testing.assert_array_equal(resumed[0].kinds["kind"], kinds)


def test_an_artefact_is_drawn_otherwise_than_chaos(scattered_diagram):
    view = BifurcationView()
    result = scattered_diagram[-1]
    view.update(SCATTERED, result, "xi2", None)
    drawn = (view.sources[f"bifurcation_{name}"] for name in ("penalty", "artefacts"))
    chaos, artefact = (set(source.data["eta"].tolist()) for source in drawn)
    at = result.question.axis.astype(np.float32)
    assert artefact == set(at[result.kinds["kind"] == CellKind.ARTEFACT].tolist())
    assert float(at[0]) in chaos - artefact
    strip = view.strip_source.data
    looks = {
        kind: (colour, hatch)
        for kind, colour, hatch in zip(strip["kind"], strip["colour"], strip["hatch"], strict=True)
    }
    assert len({*looks.values()}) == len(looks) >= 2
    assert looks["step artefact"][1] != looks["chaotic"][1]  # not by colour alone
    key = {text: colour for colour, text, _ in legend()}
    assert key["artefact of the time step"] == looks["step artefact"][0]
    assert key["chaotic"] == looks["chaotic"][0]


def test_a_kind_that_the_explanation_needs_is_judged_once(monkeypatch):
    judged = []
    explain(compute_runs(SCATTERED), on_judged=lambda *found: judged.append(found))
    ((name, found),) = judged
    assert name == "penalty"
    expected = judge_motions(SCATTERED, never)
    assert describe_kind(found) == expected[name]
    monkeypatch.setattr(motion_kind, "KINDS", Cache(20))
    keep_kind(SCATTERED, name, found)
    monkeypatch.setattr(
        motion_kind, "motion", lambda *problem, **_: motion(*problem) if problem[2] == Reference() else None
    )
    assert judge_motions(SCATTERED, never) == expected
