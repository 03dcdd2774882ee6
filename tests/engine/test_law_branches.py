"""Branches with the piecewise linear contact laws: orbits, multipliers and points against runs."""

from functools import cache

import numpy as np
import pytest
from scipy.optimize import brentq
from vibroscope.engine import ExactPenalty, Excitation, System, continue_branch, continue_point, simulate
from vibroscope.engine.continuation.orbit import KINDS
from vibroscope.engine.drivers import law_driven
from vibroscope.engine.drivers.law_driven import LawFlow
from vibroscope.engine.drivers.orbit_equations import equations_of
from vibroscope.engine.kernels.linear.tables import tabulate
from vibroscope.engine.motions.poincare_map import PoincareMap

from tests.share import every

PAPER = System()
WALL = System(wall=True, clearance=0.3, d1=0.05, excitation=Excitation(base=1.0))
LAWS = "cut", "limited", "compression"
SMALL = 1e-4  # step of differences, of the largest number of a state
CONVERGED = 1e-7  # what half the step may change


def at(law, eta, stiffness=100.0, damping=20.0):
    """The paper's system, η and a soft contact."""
    return PAPER, eta, ExactPenalty(stiffness, damping, law)


@cache
def branch_of(law, eta=1.3, low=0.8, high=2.0, **numbers):
    return continue_branch(*at(law, eta, **numbers), low=low, high=high, max_period=1)


def end_of(problem, y, period):
    """The state a run from y leads to, by the event loop alone."""
    flow = LawFlow(*problem)
    return flow.end(flow.start(y), float(period))[0]


def jacobian_of(problem, y, period, small=SMALL):
    """The derivative of that, by differences of fourth order. A wall does not move."""
    h, units = small * np.abs(y).max(), np.diag([0.0, 0.0, 1.0, 1.0] if problem[0].wall else np.ones(4))

    def central(step):
        return (end_of(problem, y + step, period) - end_of(problem, y - step, period)) / (2 * h)

    return np.column_stack([(4 * central(h * e) - central(2 * h * e) / 2) / 3 for e in units])


@pytest.mark.parametrize("law", every(LAWS))
@pytest.mark.parametrize(
    ("system", "eta", "numbers", "over", "reach"),
    every(
        [
            (PAPER, 1.3, (100.0, 20.0), "eta", (0.8, 2.0)),
            (PAPER, 2.76, (12_000.0, 18.0), "D", (4.0, 40.0)),
            (PAPER, 1.3, (100.0, 20.0), "kappa", (2.3, 2.5)),
            (WALL, 1.7, (200.0, 3.0), "K", (60.0, 500.0)),
        ]
    ),
)
def test_orbits_return_to_themselves_with_the_multipliers_of_runs(law, system, eta, numbers, over, reach):
    method = ExactPenalty(*numbers, law)
    branch = continue_branch(system, eta, method, over=over, low=reach[0], high=reach[1], max_period=2)
    assert len(branch.values) > 10
    compared = 0
    for k in range(0, len(branch.values), 1 + len(branch.values) // 20):
        value = branch.values[k]
        numbers_there = {"K": (value, numbers[1]), "D": (numbers[0], value)}.get(over, numbers)
        there = system.changed({over: value}) if over == "kappa" else system
        problem = there, value if over == "eta" else eta, ExactPenalty(*numbers_there, law)
        poincare, factors = PoincareMap(*problem, None), branch.multipliers[k]
        y, size = poincare.coordinates(branch.sections[k, 0]), max(1.0, np.abs(factors).max())
        assert poincare.residual(y, branch.period) < 1e-9 * size * np.abs(y).max()
        expected, again = (jacobian_of(problem, y, branch.period, SMALL * share) for share in (1.0, 0.5))
        if not np.abs(expected - again).max() < CONVERGED * np.abs(expected).max():  # a neighbour has other events
            continue
        difference = np.abs(np.poly(factors) - np.poly(np.linalg.eigvals(expected))).max()
        assert difference < 1e-5 * size**2
        compared += 1
    assert compared > 5


@pytest.mark.parametrize("law", every(LAWS))
def test_runs_settle_to_stable_orbits(law):
    branch, settled = branch_of(law), 0
    for k in np.flatnonzero(np.abs(branch.multipliers[:, 0]) < 0.9)[::12]:
        start = branch.sections[k, 0]
        nearby = start * (1 + 1e-4)
        run = simulate(*at(law, branch.values[k]), periods=400, keep=1, initial=nearby)
        close = np.abs(run.section[-1] - start).max() / np.abs(start).max()
        assert close < 1e-9 or close > 1e-5  # or it came to another motion, as near an edge
        settled += close < 1e-9
    assert settled > 5


POINTS = [
    ("cut", "period doubling", 0.8408),
    ("cut", "period doubling", 0.8753),
    ("limited", "period doubling", 0.8389),
    ("limited", "period doubling", 0.8750),
    ("compression", "period doubling", 1.7735),
    ("compression", "fold", 1.7255),
]


@pytest.mark.parametrize(("law", "kind", "near"), every(POINTS))
def test_points_are_where_differences_of_runs_have_them(law, kind, near):
    branch = branch_of(law)
    point = min((p for p in branch.points if p.kind == kind), key=lambda p: abs(p.value - near))
    assert abs(point.value - near) < 1e-4
    y = PoincareMap(*at(law, point.value), None).coordinates(point.state)
    # along the branch: by η at a doubling, and at a fold, where η turns, by the first number of the state
    held, sign, small = (4, 1.0, SMALL) if kind == "period doubling" else (0, -1.0, 1e-6)  # it is close to a grazing
    start = np.append(y, point.value)

    def orbit(number):
        x = start.copy()
        x[held] = number
        free = [i for i in range(5) if i != held]
        for _ in range(8):
            matrix = jacobian_of(at(law, x[4]), x[:4], 1, small)
            up, down = (end_of(at(law, x[4] + e), x[:4], 1) for e in (1e-6, -1e-6))
            whole = np.column_stack([matrix - np.eye(4), (up - down) / 2e-6])[:, free]
            x[free] -= np.linalg.solve(whole, end_of(at(law, x[4]), x[:4], 1) - x[:4])
        return x, np.linalg.det(matrix + sign * np.eye(4))

    width = 1e-5 * max(1.0, abs(start[held]))
    number = brentq(lambda n: orbit(n)[1], start[held] - width, start[held] + width, xtol=1e-13)
    assert abs(orbit(number)[0][4] - point.value) < 1e-10 * 1.2  # of the range 0.8 … 2


# Where contacts, or the events within one, become more or fewer: law, kind, and η.
CHANGES = [
    ("cut", "contact opens", 1.0883),
    ("cut", "contact opens", 1.2860),
    ("cut", "damper switches", 1.0856),
    ("limited", "contact opens", 1.3165),
    ("limited", "damper switches", 1.3238),
    ("limited", "damper switches", 0.8181),
    ("compression", "contact opens", 1.0846),
]


@pytest.mark.parametrize(("law", "kind", "near"), every(CHANGES))
def test_runs_have_other_contacts_on_both_sides_of_where_events_change(law, kind, near):
    branch = branch_of(law)
    points = [p for p in branch.points if p.kind == kind and np.abs(p.multipliers[0]) < 0.95]
    point = min(points, key=lambda p: abs(p.value - near))
    assert abs(point.value - near) < 1e-4
    runs = []
    for side in (-1, 1):
        problem = at(law, point.value + side * 1e-6)
        runs.append(simulate(*problem, periods=1000, keep=1, initial=point.state))
        assert np.abs(runs[-1].section[-1] - point.state).max() < 1e-3
    counts = [len(run.contacts) for run in runs]
    assert abs(counts[0] - counts[1]) == (0 if kind.startswith("damper") else 1)


@pytest.mark.parametrize(
    ("law", "kind", "away"),
    every(
        [
            ("cut", "period doubling", -0.03),
            ("limited", "period doubling", -0.03),
            ("compression", "fold", 0.021),
            ("cut", "contact opens", 0.02),
            ("limited", "contact opens", 0.02),
            ("compression", "grazing", 0.02),
        ]
    ),
)
def test_a_point_followed_along_the_damping_is_the_point_of_branches_there(law, kind, away):
    point = next(p for p in branch_of(law).points if p.kind == kind)
    reach = {"over": "eta", "low": 0.8, "high": 2.0, "along": "D", "along_low": 17.0, "along_high": 23.0}
    curve = continue_point(*at(law, 1.3), point, **reach)
    assert curve.values[[0, -1], 1].tolist() == [17.0, 23.0]
    value, damping = curve.values[int(np.argmin(np.abs(curve.values[:, 1] - 21.5)))]
    there = branch_of(law, value + away, value - 0.05, value + 0.05, damping=damping)
    assert min(abs(p.value - value) for p in there.points if p.kind == kind) < 1e-9


@pytest.mark.parametrize(
    ("law", "over", "said"),
    [("flores", "eta", "no closed form"), ("cut", "D", "without a damper the law cut is kelvin-voigt")],
)
def test_a_law_that_cannot_be_followed_is_refused(law, over, said):
    with pytest.raises(ValueError, match=said):
        continue_branch(*at(law, 1.3), over=over, low=0.0 if over == "D" else 1.0, high=30.0)


@pytest.mark.parametrize("law", every(LAWS))
def test_bifurcations_have_the_multiplier_of_their_kind(law):
    """At the end of a sequence the equations are singular, too, though nothing bifurcates there."""
    expected = {"period doubling": -1.0, "fold": 1.0}
    found = [p for p in branch_of(law).points if p.kind in expected]
    assert len(found) > 1
    for point in found:
        assert np.abs(point.multipliers - expected[point.kind]).min() < 1e-6


def test_tables_that_another_damping_leaves_as_they_are_are_taken_over(monkeypatch):
    made = []
    monkeypatch.setattr(law_driven, "tabulate", lambda *numbers: made.append(numbers) or tabulate(*numbers))
    first = equations_of(*at("cut", 1.3))
    assert len(made) == 4
    taken = equations_of(*at("cut", 1.3, damping=21.0), like=first)
    assert len(made) == 6  # of what depends on D; not where the bodies part from flight or from an overlap
    alone = equations_of(*at("cut", 1.3, damping=21.0))
    (orbit,) = (p for p in branch_of("cut").points if p.kind == "contact opens" and abs(p.value - 1.0883) < 1e-4)
    kinds = [KINDS[event] for event in orbit.events]
    unknowns = np.array([*PoincareMap(*at("cut", 1.3), None).coordinates(orbit.state), *orbit.instants])
    for found, expected in zip(*(each(kinds, False, 1, unknowns) for each in (taken, alone)), strict=True):
        np.testing.assert_array_equal(found, expected)
