"""Kinds of motion of the cells of a bifurcation diagram, against the full judgement of single motions."""

from types import SimpleNamespace as Namespace

import numpy as np
import pytest
from vibroscope.engine import (
    COORDINATES,
    Cancelled,
    Cells,
    ExactPenalty,
    Kind,
    Lyapunov,
    Newmark,
    Reference,
    System,
    motion,
    repetition,
    simulate,
)
from vibroscope.engine.motions.judge import SETTLED_PERIODS, judge
from vibroscope.engine.sweeps import EtaStudy
from vibroscope.engine.sweeps.motion_kinds import CellKind, judge_cells, judge_runs, kind_words, known_kinds

from tests.share import every

SYSTEM = System()
NAMES = {CellKind.PERIODIC: "periodic", CellKind.QUASI_PERIODIC: "quasi-periodic", CellKind.CHAOTIC: "chaotic"}


def study_of(method, values, **more):
    choices = {"values": np.array(values, float), "coordinates": COORDINATES} | more
    return EtaStudy(SYSTEM, method, 2.76, transient=1000, sample=48, **choices)


def judged(study):
    """The kinds of all cells, and how many of them needed further runs."""
    values = study.compute()
    kinds = known_kinds(values["status"], values["period"])
    chosen = np.flatnonzero(kinds["kind"] == CellKind.UNKNOWN)
    for name, array in judge_cells(study, values, chosen).items():
        kinds[name][chosen] = array
    return kinds, len(chosen)


def test_scatter_of_the_step_is_distinguished_from_chaos_as_for_a_single_motion():
    eta = [1.08, 1.70, 2.76, 3.25]
    method = Newmark(12000, 18, 2000)
    kinds, runs = judged(study_of(method, eta))
    assert runs >= 3
    for i, value in enumerate(eta):
        found = motion(SYSTEM, value, method)
        kind = CellKind(kinds["kind"][i])
        assert (kind is CellKind.ARTEFACT) == (found.step_noise > 0), value
        assert NAMES.get(CellKind.PERIODIC if kind is CellKind.ARTEFACT else kind) == found.type
        assert kinds["kind_period"][i] == found.period
    assert CellKind.CHAOTIC in kinds["kind"]
    assert (kinds["kind"] == CellKind.ARTEFACT).sum() >= 2


@pytest.mark.parametrize("method", every([Reference(), ExactPenalty(12000, 18)]))
def test_motions_in_closed_form_are_judged_by_their_exponent(method):
    kinds, runs = judged(study_of(method, [1.70, 2.76]))
    assert runs == 1
    assert kinds["kind"].tolist() == [CellKind.CHAOTIC, CellKind.PERIODIC]
    full = motion(SYSTEM, 1.70, method)
    assert abs(kinds["lyapunov"][0] - full.lyapunov) < 4 * np.hypot(kinds["lyapunov_error"][0], full.lyapunov_error)
    assert np.isnan(kinds["lyapunov"][1])


@pytest.mark.parametrize(("system", "periods"), [(SYSTEM, 512), (System(wall=True, clearance=-0.4), 8192)])
def test_a_motion_that_settles_while_it_is_followed_is_periodic(monkeypatch, system, periods):
    """Where a body may stick, which leaves nothing of a disturbance, it is followed for long: that may be rare."""
    section, asked = np.random.default_rng(1).normal(size=(2048, 4)), []
    section[-1100:] = 1.0

    def settles(cells, places, starts, periods, judge, **how):
        asked.extend([periods] * len(places))
        for i in places:
            judge(int(i), Lyapunov(0.3, 0.001, 1.0, 1e-3, section))

    monkeypatch.setattr("vibroscope.engine.motions.judge.follow_cells", settles)
    runs = np.random.default_rng(2).normal(size=(1, SETTLED_PERIODS, 4))
    monkeypatch.setattr("vibroscope.engine.motions.judge.run_cells", lambda *_, **how: Namespace(ok=np.zeros(1, bool)))
    found = judge(Cells(system, [1.7], Reference()), runs)
    assert asked[0] == periods
    assert (found["kind"][0], found["kind_period"][0]) == (CellKind.PERIODIC, 1)
    assert np.isnan(found["lyapunov"][0])


def test_over_the_steps_the_scatter_goes_and_the_motion_stays():
    study = study_of(Newmark(12000, 18, 300), [300, 2000, 8000], over="steps")
    kinds, _ = judged(study)
    assert set(kinds["kind"].tolist()) == {CellKind.ARTEFACT}
    assert set(kinds["kind_period"].tolist()) == {1}


def test_cells_that_ended_early_need_no_run_and_a_cancelled_judgement_raises():
    study = study_of(Newmark(12000, 18, 2000), [1.70, 2.76])
    values = study.compute()
    values["status"][1] = 1
    assert known_kinds(values["status"], values["period"])["kind"].tolist() == [CellKind.UNKNOWN, CellKind.ENDED_EARLY]
    with pytest.raises(Cancelled):
        judge_cells(study, values, np.array([0]), cancelled=lambda: True)


def test_a_motion_that_grows_without_end_ended_early_as_a_single_one_and_beside_others():
    system = System(kappa=1.38, kappa3=1.08, d1=0.014, d2=0.0043, d3=0.049, restitution=0.6)
    study = EtaStudy(
        *(system, Newmark(2320, 0.331, 600)), transient=34, sample=16, values=[0.6163, 1.0], coordinates=COORDINATES
    )
    values = study.compute()
    assert values["status"].tolist() == [0, 0]
    assert np.abs(values["end"]).max(axis=1).tolist()[0] > 1e6 > np.abs(values["end"]).max(axis=1).tolist()[1]
    found = judge_cells(study, values, np.array([0, 1]))
    assert found["kind"][0] == CellKind.ENDED_EARLY
    assert motion(system, 0.6163, study.method).type == "diverged"
    assert found["kind"][1] == judge_cells(study, values, np.array([1]))["kind"][0]


def test_an_undecided_motion_nearly_repeats_as_a_single_one_does():
    """Without a kind the section alone says how: not at all is another statement."""
    run = simulate(SYSTEM, 2.76, Newmark(12000, 18, 8000), periods=2050, keep=50)
    found = motion(run)
    assert (found.type, found.near_period) == ("undecided", 1)
    words = kind_words(CellKind.UNDECIDED, 0, found.near_period, run.section)
    assert words == f"{repetition(found)}, kind not decided"
    assert words.startswith("nearly repeats every period (±")
    assert kind_words(CellKind.ARTEFACT, 1, 2, run.section) == kind_words(CellKind.ARTEFACT, 1, section=run.section)


def test_numbers_of_stored_kinds_stay():
    """Stores and other people's scripts hold them."""
    stored = {"unknown": -1, "undecided": 0, "periodic": 1, "quasi-periodic": 2, "chaotic": 3, "ended-early": 4}
    found = study_of(Reference(), [2.76]).variables["motion"].flags
    assert stored.items() <= found.items()
    assert list(found) == [str(kind) for kind in Kind]
    assert [CellKind[kind.name] for kind in Kind] == list(found.values())


def test_a_band_about_other_points_than_those_of_the_cycle_is_undecided_in_both():
    """One point at T/1000, three without a time step: smaller steps lead from the one motion to the other."""
    method = Newmark(22220, 0.7267, 1000)
    found = motion(SYSTEM, 1.08, method)
    kinds = judge_runs(Cells(SYSTEM, [1.08], method), transient=2000, sample=50)
    assert (found.type, found.period, found.step_noise) == ("undecided", 0, 0)
    assert (kinds["kind"][0], kinds["kind_period"][0]) == (CellKind.UNDECIDED, 0)
    assert "repeats itself every 3 periods: with this time step it is another motion" in found.reason
    assert len(found.bands) == 1


def test_a_long_chaotic_transient_is_no_chaos_with_and_without_steps():
    eta, stiffness, damping = 3.84, 12600, 0.247  # irregular over some ten thousand periods from rest
    method = ExactPenalty(stiffness, damping)
    assert motion(simulate(SYSTEM, eta, method, periods=60_000, keep=12)).period == 3
    found = motion(SYSTEM, eta, method)
    assert (found.type, found.period) == (Kind.PERIODIC, 3)
    stepped = motion(SYSTEM, eta, Newmark(stiffness, damping, 2000))
    assert stepped.type is not Kind.CHAOTIC
    assert (stepped.type, stepped.period) == (Kind.PERIODIC, 3) or "as long a transient" in str(stepped.reason)
