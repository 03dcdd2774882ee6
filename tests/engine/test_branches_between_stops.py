"""Branches between two stops: the impact pair in closed form, plain twins, the mirror, runs, and what points are."""

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import brentq
from vibroscope.engine import (
    BranchQuestion,
    Cells,
    ExactPenalty,
    Excitation,
    Reference,
    System,
    continue_branch,
    continue_point,
    find_branches,
    run_cells,
    search_branches,
    simulate,
)
from vibroscope.engine.motions.poincare_map import multipliers

from tests import naive_stops
from tests.engine.test_continuation import orbits_at
from tests.engine.test_two_stops import PAIR, STIFF, SYMMETRIC, WALL, half_jacobian, impact_pair
from tests.few_seeds import few_seeds

E = 0.6
SLOT = System(wall=True, spring1=0.0, d1=0.0, clearance=5.0, clearance2=5.0, restitution=E)
EXACT = ExactPenalty(4000.0, 5.0)
CASES = [  # with grazings at either stop, sticking, contacts of the penalty at either, a loss of symmetry
    (WALL, 1.3, Reference(), "eta", (1.1, 1.6)),
    (WALL, 1.3, Reference(), "clearance2", (0.5, 1.0)),
    (WALL, 1.3, Reference(), "restitution2", (0.7, 0.9)),
    (PAIR, 1.3, Reference(), "eta", (1.28, 1.32)),
    (SYMMETRIC, 2.76, Reference("derived"), "eta", (2.7, 2.8)),
    (replace(WALL, **STIFF), 1.3, EXACT, "eta", (1.1, 1.5)),
    (replace(WALL, **STIFF), 1.3, EXACT, "damping_factor2", (0.4, 0.6)),
    (replace(PAIR, **STIFF), 2.2, EXACT, "eta", (2.18, 2.22)),
]


def pair_branches(low, high):
    """Branches of the impact pair over the amplitude of its walls, a clearance of 5 in units of which it has."""
    start = np.array(impact_pair(5.0 / low, E)[0]) * low
    question = BranchQuestion(
        replace(SLOT, excitation=Excitation(base=low)), 1.0, Reference(), over="base", low=low, high=high,
        max_period=1, initial=start,
    )  # fmt: skip
    with few_seeds():
        return find_branches(question)


def where_half_a_cycle_has(multiplier, low, high):
    """The clearance, in amplitudes, at which the closed form of the impact pair has it."""

    def determinant(clearance):
        start, phase, _ = impact_pair(clearance, E)
        return np.linalg.det(half_jacobian(clearance, E, phase, start[1]) - multiplier * np.eye(2))

    return brentq(determinant, low, high)


def test_a_branch_of_the_impact_pair_is_its_closed_form():
    branch = continue_branch(
        BranchQuestion(SLOT, 1.0, Reference(), over="base", low=0.8, high=4.5, initial=impact_pair(5.0, E)[0])
    )
    assert len(branch.values) > 20
    assert branch.sequences == ((0, "impact, impact at the second stop"),)
    for base, rows, values in zip(branch.values, branch.sections, branch.multipliers, strict=True):
        start, phase, _ = impact_pair(5.0 / base, E)
        np.testing.assert_allclose(rows[0], np.multiply(start, base), atol=1e-9)
        half = half_jacobian(5.0 / base, E, phase, start[1])
        np.testing.assert_allclose(np.poly(values[:2]), np.poly(half @ half), atol=1e-8)


def test_the_impact_pair_loses_its_symmetry_where_half_a_cycle_has_the_multiplier_minus_one():
    symmetric, *others = pair_branches(3.4, 4.2)
    assert [(point.kind, point.stop, point.is_crossing) for point in symmetric.points] == [
        ("symmetry breaking", 1, True)
    ]
    (point,) = symmetric.points
    assert 5.0 / point.value == pytest.approx(where_half_a_cycle_has(-1.0, 1.33, 1.38), rel=1e-9)
    assert point.critical_multiplier == pytest.approx(1.0, abs=1e-9)
    assert symmetric.stable_ranges == ((3.4, point.value),)
    assert [branch.ends[0] for branch in others] == ["begins at a symmetry breaking"] * 2
    found = []
    for branch in others:
        assert branch.stable[1:].all()
        assert not branch.points
        (orbit,) = orbits_at(branch, 4.0)
        system = replace(SLOT, excitation=Excitation(base=4.0))
        run = simulate(system, 1.0, Reference(), periods=300, keep=1, initial=orbit)
        second = run.impacts.impulse < 0
        (one,), (other,) = np.exp(1j * run.impacts.time[~second]), np.exp(1j * run.impacts.time[second])
        found.append((one, other))
    np.testing.assert_allclose(found[0], np.negative(found[1][::-1]), atol=1e-9)  # mirror images of each other
    assert abs(found[0][0] + found[0][1]) > 0.1


def test_the_impact_pair_turns_where_half_a_cycle_has_the_multiplier_one():
    share = 2 / math.pi * (1 - E) / (1 + E)  # of impact_pair: beyond this clearance there is no phase of an impact
    limit = 5.0 * share / math.hypot(1, share)
    branch = continue_branch(
        BranchQuestion(SLOT, 1.0, Reference(), over="base", low=0.7, high=1.2, initial=impact_pair(5.0, E)[0])
    )
    (fold,) = (point for point in branch.points if point.kind == "fold")
    assert fold.value == pytest.approx(limit, rel=1e-8)


def problem_at(system, eta, method, over, value):
    """The problem with one number changed."""
    return (system, value, method) if over == "eta" else (system.changed({over: value}), eta, method)


@pytest.mark.parametrize(("system", "eta", "method", "over", "reach"), CASES)
def test_orbits_return_to_themselves_with_the_multipliers_of_the_poincare_map(system, eta, method, over, reach):
    branch = continue_branch(BranchQuestion(system, eta, method, over=over, low=reach[0], high=reach[1], max_period=4))
    assert "second stop" in branch.sequences[0][1]
    compared = 0
    for k in range(0, len(branch.values), 1 + len(branch.values) // 12):
        problem, factors = problem_at(system, eta, method, over, branch.values[k]), branch.multipliers[k]
        if not np.abs(factors).max() < 1e3:  # close to grazing
            continue
        run = simulate(*problem, periods=branch.period, keep=branch.period, initial=branch.sections[k, 0])
        rows = np.vstack([branch.sections[k, 1:], branch.sections[k, :1]])
        assert np.abs(run.section - rows).max() < 1e-9 * np.abs(rows).max() * max(1.0, np.abs(factors).max())
        expected = multipliers(*problem, branch.sections[k, 0], branch.period)
        assert np.abs(np.poly(factors) - np.poly(expected)).max() < 1e-7 * max(1.0, np.abs(expected).max())
        compared += 1
    assert compared > 3


def test_multipliers_are_differences_of_a_twin_that_mirrors_nothing():
    branch = continue_branch(BranchQuestion(WALL, 1.3, Reference(), low=1.25, high=1.35))
    k = len(branch.values) // 2
    start, eta, width = branch.sections[k, 0], branch.values[k], 1e-6

    def image(x, v):
        events, end = naive_stops.reference(WALL, eta, 0.0, Reference().threshold, branch.period, (x, v, 0.0, 0.0))
        return events, np.array(end[:2])

    events, end = image(*start[:2])
    assert {stop for _, _, stop, _ in events} == {0, 1}
    np.testing.assert_allclose(end, start[:2], atol=1e-9)
    columns = [
        (image(*(start[:2] + width * step))[1] - image(*(start[:2] - width * step))[1]) / (2 * width)
        for step in np.eye(2)
    ]
    np.testing.assert_allclose(np.poly(branch.multipliers[k, :2]), np.poly(np.transpose(columns)), atol=1e-5)


def test_in_a_mirror_a_branch_has_the_same_points_at_the_other_stop():
    one, other = (
        continue_branch(BranchQuestion(system, 1.3, Reference(), low=1.1, high=1.6, initial=start, max_period=1))
        for system, start in ((WALL, (0.1, 0.9, 0.0, 0.0)), (WALL.mirrored, (-0.1, -0.9, 0.0, 0.0)))
    )
    assert [point.kind for point in one.points] == [point.kind for point in other.points]
    assert "grazing" in {point.kind for point in one.points}
    for point, image in zip(one.points, other.points, strict=True):
        assert image.value == pytest.approx(point.value, abs=1e-9)
        assert image.stop == (3 - point.stop if point.kind == "grazing" else point.stop)
        np.testing.assert_allclose(image.state, -point.state, atol=1e-7)
    named = {point.words for point in (*one.points, *other.points) if point.kind == "grazing"}
    assert named == {"grazing", "grazing at the second stop"}


@pytest.mark.parametrize(("method", "reach"), [(Reference(), (1.2, 1.5)), (EXACT, (1.2, 1.5))])
def test_what_a_diagram_shows_as_periodic_lies_on_a_branch(method, reach):
    with few_seeds():
        found = find_branches(BranchQuestion(WALL, 1.3, method, low=reach[0], high=reach[1], max_period=2))
    values = np.linspace(reach[0] + 0.01, reach[1] - 0.01, 25)
    runs = run_cells(Cells(WALL, values, method), transient=800, sample=8)
    shown = [k for k in range(25) if runs.ok[k] and runs.period[k] in (1, 2)]
    assert len(shown) > 10
    for k in shown:
        rows = [row for branch in found if branch.period == runs.period[k] for row in orbits_at(branch, values[k])]
        assert min(np.abs(row - runs.end[k]).max() for row in rows) < 2e-3 * np.abs(runs.end[k]).max()


def test_a_point_at_a_stop_is_followed_in_two_numbers():
    question = BranchQuestion(WALL, 1.3, Reference(), low=1.1, high=1.6, max_period=1)
    branch = continue_branch(question)
    point = next(point for point in branch.points if point.kind == "grazing")
    curve = continue_point(question, point, along="clearance", along_low=0.45, along_high=0.55)
    assert np.abs(curve.values - [point.value, 0.5]).max(axis=1).min() < 1e-8
    assert np.ptp(curve.values[:, 0]) == pytest.approx(0.5)
    across = {"over": "clearance", "low": 0.48, "high": 0.52, "max_period": 1, "initial": point.state}
    there = continue_branch(BranchQuestion(WALL, point.value, Reference(), **across))
    assert [each.value for each in there.points if each.kind == "grazing"] == pytest.approx([0.5], abs=1e-9)


def test_a_search_goes_on_from_what_is_kept(tmp_path):
    question = BranchQuestion(WALL, 1.3, Reference(), low=1.25, high=1.5, max_period=1)
    with few_seeds():
        first, second = (tuple(search_branches(question, keep=tmp_path)) for _ in range(2))
    assert any(point.kind == "grazing" for branch in first for point in branch.points)
    for one, other in zip(first, second, strict=True):
        assert one.values.tobytes() == other.values.tobytes()
        assert [(p.kind, p.stop, p.value) for p in one.points] == [(p.kind, p.stop, p.value) for p in other.points]
