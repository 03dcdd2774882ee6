"""The search for all branches: its orbits are motions, it finds what sweeps show, and it takes up what is known."""

from dataclasses import replace

import numpy as np
import pytest
from vibroscope.engine import (
    BranchQuestion,
    Cancelled,
    Cells,
    ExactPenalty,
    Excitation,
    Reference,
    System,
    continue_branch,
    find_branches,
    run_cells,
    search_branches,
    simulate,
    steady,
)
from vibroscope.engine.continuation import search

from tests.few_seeds import few_seeds
from tests.share import every, share

PAPER, EXACT = System(), ExactPenalty(12_000.0, 18.0)
WALL, ISOLATED = System(wall=True, clearance=0.5), {"low": 0.5, "high": 0.62, "max_period": 3}
AT_REST = System(excitation=Excitation(base=0.0))


@pytest.fixture(scope="module")
def period_one():
    with few_seeds():
        return find_branches(BranchQuestion(PAPER, 2.76, Reference(), low=0.5, high=4.0, max_period=1))


def test_every_orbit_of_a_wide_range_returns_also_where_events_pass_the_end_of_its_cycle(period_one):
    compared = 0
    for branch in period_one:
        for eta, rows, factors in zip(branch.values, branch.sections, branch.multipliers, strict=True):
            if not np.abs(factors).max() < 1e4:  # close to grazing
                continue
            start = rows[0] - [max(PAPER.overlap_of(rows[0]), 0.0), 0, 0, 0]  # by rounding
            end = simulate(PAPER, eta, Reference(), periods=1, keep=1, initial=start).section[0]
            assert np.abs(end - start).max() < 1e-9 * np.abs(start).max() * max(1.0, np.abs(factors).max()), eta
            compared += 1
    assert compared > 500


def test_the_events_of_a_point_lie_within_its_cycle(period_one):
    points = [point for branch in period_one for point in branch.points if len(point.instants)]
    assert len(points) > 50
    assert min(point.instants[0] for point in points) >= 0
    assert max(point.instants[-1] for point in points) < 1


def test_a_branch_goes_on_where_the_flight_grazes_together_with_its_impact():
    force = Excitation(base=0.0, force1=0.5)
    wall = System(wall=True, d1=0.05, clearance=1.0, restitution=0.8, excitation=force)
    with few_seeds():
        (branch,) = find_branches(BranchQuestion(wall, 1.0, Reference(), low=0.3, high=3.0, max_period=1))
    assert [end.split(" at ")[0] for end in branch.ends] == ["eta leaves the range"] * 2
    assert [point.kind for point in branch.points] == ["grazing", "period doubling", "fold", "grazing"]
    turns = np.flatnonzero(np.diff(np.sign(np.diff(branch.values))))
    assert len(turns) == 2  # the fold and the grazing, each once
    fold = branch.points[2]
    assert branch.values[turns + 1].max() == fold.value  # the orbit at the fold is one of the branch


@pytest.mark.parametrize(
    ("system", "method", "reach"),
    every(
        [
            (System(clearance=2.0), Reference(), (2.6, 2.7)),
            (PAPER, Reference(), (3.19, 3.21)),  # rest leads to period 2, slowly; most starts to period 6
            (PAPER, EXACT, (3.01, 3.05)),
        ]
    ),
)
def test_every_periodic_run_of_a_sweep_ends_on_a_branch(system, method, reach):
    found = find_branches(BranchQuestion(system, 3.0, method, low=reach[0], high=reach[1], max_period=6))
    values = np.linspace(*reach, share(100) + 2)[1:-1]
    # after 2,000 periods one run, 3e-4 beyond a period doubling, multiplier -0.994, is still 1e-3 of its size away from
    # its orbit, and after 4,000 its section still has twice the period of the orbit
    runs = run_cells(Cells(system, values, method), transient=4000, sample=64)
    compared = 0
    for value, period, end in zip(values, runs.period, runs.end, strict=True):
        if 0 < period <= 6:
            settled = steady(system, value, method, initial=end, max_period=period)
            assert np.abs(settled.state - end).max() < 1e-4 * np.abs(end).max()
            of_period = [branch for branch in found if branch.period == settled.period]
            rows = [row for branch in of_period for row in corrected_at(branch, value, system, method)]
            assert min(np.abs(row - settled.state).max() for row in rows) < 1e-9 * np.abs(end).max(), value
            compared += 1
    assert compared > share(50)


def corrected_at(branch, value, system, method):
    """Section points of a branch at a value: those between neighbours, corrected by Newton's method on the map."""
    for k in np.flatnonzero((branch.values[:-1] - value) * (branch.values[1:] - value) <= 0):
        share = (value - branch.values[k]) / (branch.values[k + 1] - branch.values[k])
        for row in branch.sections[k] + share * (branch.sections[k + 1] - branch.sections[k]):
            found = steady(system, value, method, initial=row, max_period=branch.period)
            yield from found.response.section if found.periodic else ()


@pytest.mark.parametrize("method", [ExactPenalty(100.0, 5.0), Reference()], ids=["exact", "reference"])
@pytest.mark.parametrize("system", [AT_REST, replace(AT_REST, clearance=-0.3)], ids=["touching", "pressed"])
def test_a_system_that_nothing_drives_has_its_equilibrium_alone_and_is_not_searched(system, method):
    asked = []
    question = BranchQuestion(system, 1.35, method, low=1.3, high=1.4)
    (branch,) = find_branches(question, cancelled=lambda: asked.append(1))  # never; polled at each orbit and each run
    assert (branch.values.min(), branch.values.max()) == (1.3, 1.4)
    assert branch.stable.all()
    end = simulate(system, 1.35, method, periods=400, keep=1).section[0]
    assert np.abs(branch.sections - end).max() < 1e-12
    assert len(asked) < 200


def test_a_search_ends_after_a_number_of_orbits_and_says_so(monkeypatch):
    monkeypatch.setattr(search, "MOST_IN_ALL", 30)
    notes = []
    found = find_branches(BranchQuestion(PAPER, 2.76, Reference(), low=2.7, high=2.85), note=notes.append)
    assert sum(len(branch.values) for branch in found) >= 30
    assert notes == ["the search ended after 30 orbits and may have missed branches: narrow the range"]


def test_unstable_motions_are_found_where_no_run_settles_to_them():
    with few_seeds():
        (branch,) = find_branches(BranchQuestion(PAPER, 3.2, Reference(), low=3.1, high=3.3, max_period=1))
    assert branch.stable_ranges == ()
    assert (branch.values.min(), branch.values.max()) == (3.1, 3.3)


def test_a_cancelled_branch_is_kept_as_far_as_it_goes():
    asked, found = [], []

    def cancelled():
        asked.append(1)
        return len(asked) > 60

    question = BranchQuestion(PAPER, 2.76, Reference(), low=2.6, high=3.0, initial=(0, 0, 0, 0))
    with pytest.raises(Cancelled):
        found.extend(search_branches(question, cancelled=cancelled))
    (branch,) = found
    assert branch.ends == ("stopped", "stopped")
    assert len(branch.values) > 5


def test_no_orbit_of_a_branch_that_jumps_is_followed_again():
    (branch,) = find_branches(BranchQuestion(PAPER, 1.0, Reference(), low=0.9, high=1.1, max_period=1))
    assert "sticking begins" in {point.kind for point in branch.points}


def test_the_motion_of_a_start_is_followed_first():
    other, usual = (
        next(search_branches(BranchQuestion(PAPER, 3.2, Reference(), low=3.19, high=3.21, initial=initial)))
        for initial in (PAPER.rest, (1.0, 2.0, 3.0, -4.0))
    )
    assert {other.period, usual.period} == {2, 6}


def test_what_is_not_found_is_said_with_its_reason():
    notes = []
    question = BranchQuestion(PAPER, 3.365, Reference(), low=3.365, high=3.3651, max_period=1, initial=PAPER.rest)
    with few_seeds():
        find_branches(question, note=notes.append)
    assert notes[0].startswith("the motion from the initial state is not followed: there is no periodic motion")


@pytest.mark.parametrize(("initial", "words"), [((1.0, 2.0), "four numbers"), ((5.0, 0.0, 0.0, 0.0), "initial gap")])
def test_a_search_refuses_an_initial_state_that_is_none(initial, words):
    with pytest.raises(ValueError, match=words):
        find_branches(BranchQuestion(PAPER, 2.76, Reference(), low=2.75, high=2.8, max_period=1, initial=initial))


@pytest.fixture(scope="module")
def isolated():
    start = (-0.009197782845214886, -0.1351231394306132, 0.0, 0.0)
    return continue_branch(BranchQuestion(WALL, 0.5508751686340112, Reference("derived"), initial=start, **ISOLATED))


@pytest.mark.parametrize("phase", range(3))
@pytest.mark.parametrize("value", every([0.5047, 0.506, 0.513, 0.53, 0.55, 0.5631, 0.594]))
def test_an_isolated_branch_is_the_same_wherever_and_from_whichever_event_it_is_followed(isolated, value, phase):
    """It touches branches of period one at 0.50458, where three flights graze at once, and closes after one turn."""
    off = np.abs(np.subtract.outer(isolated.values, sorted_values(isolated))).min(axis=1)  # not at a grazing
    k = int(np.argmin(np.where(off > 1e-6, np.abs(isolated.values - value), np.inf)))
    state = isolated.sections[k][phase]
    again = continue_branch(BranchQuestion(WALL, isolated.values[k], Reference("derived"), initial=state, **ISOLATED))
    assert again.ends == ("the branch closes in itself",) * 2
    for branch in (isolated, again):
        points = sorted((point.kind, point.value) for point in branch.points)
        assert [kind for kind, _ in points] == ["fold"] + ["grazing"] * 6 + ["period doubling"] * 2
        values = [value for _, value in points]
        assert np.abs(np.subtract(values, sorted_values(isolated))).max() < 1e-10
        turned = [np.abs(branch.sections[-1] - np.roll(branch.sections[0], k, axis=0)).max() for k in range(3)]
        assert min(turned) < 1e-6  # neither short of its first orbit nor beyond it


def sorted_values(branch):
    """The numbers at the points of a branch, kind by kind."""
    return [value for _, value in sorted((point.kind, point.value) for point in branch.points)]


def test_a_branch_of_two_periods_ends_where_it_grazes_as_one_of_period_one(isolated):
    state = (-0.12729196473086413, 0.004863650611044364, 0.0, 0.0)
    branch = continue_branch(BranchQuestion(WALL, 0.513, Reference("derived"), initial=state, **ISOLATED))
    assert branch.period == 2
    touching = next(value for value in sorted_values(isolated) if abs(value - 0.50458) < 1e-6)
    ends = sorted(branch.ends)
    assert ends[0] == "eta leaves the range at 0.62"
    assert ends[1].startswith("joins a branch of period 1 at eta = ")
    assert abs(float(ends[1].rpartition(" ")[2]) - touching) < 1e-9
