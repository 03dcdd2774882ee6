"""Orbits whose multipliers change fast: those of branches equal differences of runs of the event loop."""

import numpy as np
import pytest
from vibroscope.engine import BranchQuestion, ExactPenalty, System, continue_branch, simulate

PAPER = System()
NARROW = 1e-10  # of differences: by more, contacts come and go


def differences(eta, method, period, state):
    """How far a run over a cycle ends from its start, and the multipliers by differences of such runs."""

    def end(start):
        return simulate(PAPER, eta, method, periods=period, keep=1, initial=tuple(start)).section[-1]

    columns = [(end(state + step) - end(state - step)) / (2 * NARROW) for step in NARROW * np.eye(4)]
    return np.abs(end(state) - state).max(), np.linalg.eigvals(np.transpose(columns))


@pytest.mark.parametrize(("eta", "low", "high"), [(0.69, 0.66, 0.7), (1.22, 1.14, 1.24)])
def test_bifurcations_of_the_penalty_next_to_grazings_are_some(eta, low, high):
    # the damper of a new contact changes the multipliers with the root of the distance from its grazing
    method = ExactPenalty(12_000.0, 18.0)
    points = continue_branch(BranchQuestion(PAPER, eta, method, low=low, high=high, max_period=1)).points
    grazings = np.array([point.value for point in points if point.kind == "grazing"])
    sought = {"fold": 1.0, "period doubling": -1.0}
    beside = [p for p in points if p.kind in sought and np.abs(grazings - p.value).min() < 1e-6]
    assert len(beside) > 3
    for point in beside:
        off, found = differences(point.value, method, point.period, point.state)
        assert off < 1e-12
        assert np.abs(found - sought[point.kind]).min() < 2e-3, f"{point.kind} at {point.value}"


def test_where_a_contact_grazes_the_multipliers_are_those_of_the_orbit_without_it():
    # with a contact of no length the equations are singular
    branch = continue_branch(BranchQuestion(PAPER, 1.3, ExactPenalty(100.0, 20.0), low=0.8, high=2.0, max_period=1))
    grazings = [point for point in branch.points if point.kind in ("grazing", "contact opens")]
    assert grazings
    for point in grazings:
        sides = branch.multipliers[point.index - 1 : point.index + 3]
        off = np.abs(np.abs(sides) - np.abs(point.multipliers)).max(axis=1)
        assert off.min() < 1e-3, (point.value, off)
