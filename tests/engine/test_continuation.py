"""Branches of periodic motions: orbits, multipliers, what runs settle to, and how branches end."""

import contextlib

import numpy as np
import pytest
from vibroscope.engine import (
    BranchQuestion,
    Cancelled,
    Cells,
    ExactPenalty,
    Excitation,
    Newmark,
    Reference,
    System,
    TimeStepping,
    branches_dataset,
    continue_branch,
    continue_point,
    equal_restitution_damping,
    find_branches,
    run_cells,
    search_branches,
    simulate,
)
from vibroscope.engine.motions.poincare_map import multipliers

from tests.few_seeds import few_seeds
from tests.share import every

PAPER, EXACT = System(), ExactPenalty(12_000.0, 18.0)
STIFF = System(clearance=0.5, excitation=Excitation(base=1.0, force1=0.3, force1_phase=0.4))
CASES = [
    (PAPER, 2.76, Reference(), "eta", (2.6, 3.0)),
    (PAPER, 1.1, Reference(), "eta", (1.09, 1.12)),
    (PAPER, 1.1, Reference(threshold=0.0), "eta", (1.09, 1.12)),
    (PAPER, 2.76, EXACT, "eta", (2.7, 2.9)),
    (PAPER, 2.76, EXACT, "K", (6000.0, 20_000.0)),
    (PAPER, 2.76, EXACT, "D", (5.0, 40.0)),
    (PAPER, 2.76, Reference(), "restitution", (0.3, 0.8)),
    (STIFF, 2.9, Reference(), "clearance", (0.2, 1.0)),
    (STIFF, 2.9, EXACT, "force1", (0.1, 0.6)),
]


def of(system, eta, method, over, value):
    """The problem with one number changed."""
    if over == "eta":
        return system, value, method
    if over in ("K", "D"):
        return (
            system,
            eta,
            ExactPenalty(value, method.damping) if over == "K" else ExactPenalty(method.stiffness, value),
        )
    return system.changed({over: value}), eta, method


@pytest.mark.parametrize(("system", "eta", "method", "over", "reach"), every(CASES))
def test_orbits_return_to_themselves_with_the_multipliers_of_the_poincare_map(system, eta, method, over, reach):
    branch = continue_branch(BranchQuestion(system, eta, method, over=over, low=reach[0], high=reach[1], max_period=4))
    assert len(branch.values) > 5
    compared = 0
    for k in range(0, len(branch.values), 1 + len(branch.values) // 12):
        problem = of(system, eta, method, over, branch.values[k])
        start, factors = branch.sections[k, 0], branch.multipliers[k]
        if not np.abs(factors).max() < 1e4:  # close to grazing
            continue
        run = simulate(*problem, periods=branch.period, keep=branch.period, initial=start)
        rows = np.vstack([branch.sections[k, 1:], branch.sections[k, :1]])
        size = np.abs(rows).max()
        assert np.abs(run.section - rows).max() < 1e-9 * size * max(1.0, np.abs(factors).max())
        expected = multipliers(*problem, start, branch.period)
        assert np.abs(np.poly(factors) - np.poly(expected)).max() < 1e-7 * max(1.0, np.abs(expected).max())
        compared += 1
    assert compared > 3


@pytest.mark.parametrize(
    ("over", "reach", "method"),
    [("restitution", (0.0, 1.0), Reference()), ("d1", (0.0, 0.9), Reference()), ("D", (0.0, 60.0), EXACT)],
    ids=str,
)
def test_a_branch_reaches_the_ends_of_what_a_number_may_be(over, reach, method):
    branch = continue_branch(BranchQuestion(PAPER, 2.76, method, over=over, low=reach[0], high=reach[1], max_period=1))
    assert (branch.values.min(), branch.values.max()) == reach
    assert branch.ends == (f"{over} leaves the range at {reach[0]:g}", f"{over} leaves the range at {reach[1]:g}")


@pytest.mark.parametrize("method", every([EXACT, Reference()]), ids=str)
def test_runs_from_near_a_stable_orbit_settle_to_it(method):
    compared = 0
    with few_seeds():
        found = find_branches(BranchQuestion(PAPER, 2.76, method, low=2.6, high=2.9, max_period=2))
    for branch in found:
        # where an impact begins or ceases to stick the motion jumps, and the disturbance of 1e-10 reaches past that
        # from one orbit in 300, at a distance of 2e-12; orbits at 1e-9 settle
        jumps = [point.value for point in branch.points if point.kind.startswith("sticking")]
        clear = np.abs(branch.values[:, None] - jumps).min(axis=1, initial=1) > 1e-10
        stable = np.flatnonzero(clear & branch.stable & (np.abs(branch.multipliers[:, 0]) < 0.97))[::4]
        starts = branch.sections[stable, 0] * (1 + 1e-10)
        starts[:, 2] = np.maximum(starts[:, 2], starts[:, 0])
        if len(stable):
            runs = run_cells(Cells(PAPER, branch.values[stable], method, initial=starts), transient=1600, sample=8)
            size = np.abs(branch.sections[stable]).max()
            distance = np.abs(branch.sections[stable] - runs.end[:, None]).max(axis=2).min(axis=1)
            assert (runs.period == branch.period).all()
            assert distance.max() < 1e-9 * size
            compared += len(stable)
    assert compared > 10


@pytest.mark.parametrize("method", every([Reference(), EXACT]), ids=str)
def test_what_a_sweep_shows_as_periodic_lies_on_a_branch(method):
    with few_seeds():
        found = find_branches(BranchQuestion(PAPER, 2.76, method, low=2.6, high=3.0, max_period=2))
    runs = run_cells(Cells(PAPER, np.linspace(2.61, 2.99, 60), method), transient=1600, sample=8)
    values = np.linspace(2.61, 2.99, 60)
    shown = [k for k in range(60) if runs.ok[k] and runs.period[k] in (1, 2)]
    assert len(shown) > 20
    for k in shown:
        rows = [row for branch in found if branch.period == runs.period[k] for row in orbits_at(branch, values[k])]
        assert min(np.abs(row - runs.end[k]).max() for row in rows) < 2e-3 * np.abs(runs.end[k]).max()


def orbits_at(branch, value):
    """Section points of a branch at a value, between neighbouring orbits."""
    for k in np.flatnonzero((branch.values[:-1] - value) * (branch.values[1:] - value) < 0):
        share = (value - branch.values[k]) / (branch.values[k + 1] - branch.values[k])
        yield from branch.sections[k] + share * (branch.sections[k + 1] - branch.sections[k])


def test_a_cascade_of_period_doublings_is_followed_to_period_16():
    with few_seeds():
        found = find_branches(BranchQuestion(PAPER, 1.7, ExactPenalty(100.0, 2.0), low=1.699, high=1.72, max_period=16))
    assert {branch.period for branch in found} == {1, 2, 4, 8, 16}


def test_the_points_of_both_solvers_come_together_as_the_contact_stiffens():
    def doubling(method):
        branch = continue_branch(BranchQuestion(PAPER, 2.76, method, low=2.7, high=2.85, max_period=1))
        (point,) = (p for p in branch.points if p.kind == "period doubling")
        return point.value

    exact = doubling(Reference(joint_damping="derived"))
    shifts = [abs(doubling(ExactPenalty(K, equal_restitution_damping(PAPER, K))) - exact) for K in (1e4, 1e5, 1e6)]
    assert shifts[0] > 2 * shifts[1] > 4 * shifts[2]


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"method": Newmark(12_000.0, 18.0, 2000, located=True)}, "has a time step: .* ExactPenalty"),
        ({"method": TimeStepping(12_000.0, 18.0, 2000, status="located")}, "has a time step: .* ExactPenalty"),
        ({"method": ExactPenalty(12_000.0, 18.0, "limited")}, "law = 'limited' has no branches: give 'kelvin-voigt'"),
        ({"method": ExactPenalty(12_000.0, 18.0, "hunt-crossley")}, "give 'kelvin-voigt'"),
        ({"over": "steps"}, "give one of eta, K, D"),
        ({"method": EXACT, "over": "restitution"}, "give D in its place"),
        ({"low": 3.0, "high": 2.0}, "empty range"),
        ({"low": 3.0, "high": 4.0}, "begin within the range"),
        ({"low": float("nan")}, "eta = nan"),
        ({"max_period": 0}, "longest cycle"),
        ({"high": -1.0, "low": -2.0}, "eta"),
        ({"initial": (1.0, 2.0)}, "four numbers"),
    ],
)
def test_bad_input_is_refused_in_one_line(change, said):
    given = {"system": PAPER, "eta": 2.76, "method": Reference(), "low": 2.5, "high": 3.0} | change
    with pytest.raises(ValueError, match=said) as caught:
        continue_branch(BranchQuestion(**given))
    assert "\n" not in str(caught.value)


def test_a_cancelled_search_keeps_what_was_found():
    found, asked = [], []

    def cancelled():  # twenty orbits after the first branch
        asked.extend(found[:1])
        return len(asked) > 20

    with pytest.raises(Cancelled):
        found.extend(
            search_branches(
                BranchQuestion(PAPER, 2.76, Reference(), low=0.5, high=4.0, max_period=8), cancelled=cancelled
            )
        )
    assert len(asked) == 21
    assert found


def test_branches_as_a_dataset():
    with few_seeds():
        found = find_branches(BranchQuestion(PAPER, 2.76, Reference(), low=2.7, high=2.8, max_period=2))
    dataset = branches_dataset(found)
    assert dataset.sizes["orbit"] == sum(len(branch.values) for branch in found)
    assert np.isnan(dataset.section.values[dataset.period.values == 1, 1:]).all()
    kinds = dataset.point_kind.attrs["flag_meanings"].split()
    named = [kinds[k].replace("_", " ") for k in dataset.point_kind.values]
    assert named == [point.kind for branch in found for point in branch.points]
    assert "period doubling" in named


@pytest.mark.parametrize(
    ("method", "reach", "kind", "along", "ends"),
    every(
        [
            (Reference(), (2.7, 2.8), "period doubling", "restitution", (0.35, 0.7)),
            (EXACT, (2.7, 2.8), "period doubling", "K", (4000.0, 40_000.0)),
            (EXACT, (2.7, 2.8), "period doubling", "D", (5.0, 40.0)),
            (Reference(), (1.2, 1.31), "fold", "restitution", (0.45, 0.6)),
            (Reference(), (1.55, 1.7), "grazing", "clearance", (-0.2, 0.2)),
            (Reference(), (1.05, 1.15), "sticking begins", "restitution", (0.49, 0.51)),
            (Reference(), (1.05, 1.15), "sticking ends", "restitution", (0.49, 0.51)),
        ]
    ),
)
def test_a_point_in_two_parameters_is_the_point_of_a_branch_at_each_of_them(method, reach, kind, along, ends):
    eta = {2.7: 2.76, 1.2: 1.3, 1.55: 1.6, 1.05: 1.1}[reach[0]]
    branch = continue_branch(BranchQuestion(PAPER, eta, method, low=reach[0], high=reach[1], max_period=1))
    point = next(p for p in branch.points if p.kind == kind)
    wide = BranchQuestion(PAPER, eta, method, low=reach[0] - 0.4, high=reach[1] + 0.4)
    curve = continue_point(wide, point, along=along, along_low=ends[0], along_high=ends[1])
    assert len(curve.values) > 20
    compared = 0
    for value, second in curve.values[:: len(curve.values) // 4]:
        system, _, other = of(PAPER, eta, method, along, second)
        found = []
        for start in (value - 0.01, value + 0.01):
            with contextlib.suppress(ValueError):  # on the other side another motion attracts
                here = continue_branch(
                    BranchQuestion(system, start, other, low=value - 0.03, high=value + 0.03, max_period=1)
                )
                found += [p.value for p in here.points if p.kind == kind]
        if found:
            assert min(abs(each - value) for each in found) < 1e-9
            compared += 1
    assert compared > 2


def test_a_point_that_cannot_be_followed_is_refused_in_one_line():
    branch = continue_branch(BranchQuestion(PAPER, 2.76, Reference(), low=2.7, high=2.8, max_period=1))
    (point,) = (p for p in branch.points if p.kind == "period doubling")
    question = BranchQuestion(PAPER, 2.76, Reference(), low=2.5, high=3.0)
    given = {"along": "restitution", "along_low": 0.3, "along_high": 0.7}
    for change, said in (
        ({"along": "eta"}, "varies already"),
        ({"along": "K"}, "reference method has no K"),
        ({"along_low": 0.9, "along_high": 0.8}, "empty range"),
        ({"along_low": 0.6}, "begin within the range"),
    ):
        with pytest.raises(ValueError, match=said):
            continue_point(question, point, **(given | change))
