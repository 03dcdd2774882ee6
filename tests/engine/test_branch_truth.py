"""Bifurcation points against independent solutions: closed forms of published orbits, and a twin in 30 digits."""

import mpmath as mp
import numpy as np
import pytest
from vibroscope.engine import BranchQuestion, ExactPenalty, Excitation, Reference, System, continue_branch

from tests.naive_orbit import DIGITS, TOUCHING, Twin
from tests.share import every

PAPER, EXACT = System(), ExactPenalty(12_000.0, 18.0)
CLOSE = 1e-10


def values(branch, kind):
    """Where a branch has points of a kind."""
    return np.array([point.value for point in branch.points if point.kind == kind])


# Where to look, to four digits: method, kind, η of the point, and from where to where to follow which motion. The
# kinds are mixed, so that a part of the list has several.
POINTS = [
    (Reference(), "period doubling", 2.7889, (2.70, 2.76, 2.80)),
    (Reference(), "sticking begins", 1.09499, (1.09, 1.10, 1.12)),
    (Reference(), "period doubling", 3.7903, (2.70, 2.76, 3.80)),
    (EXACT, "fold", 1.2502, (1.22, 1.30, 1.31)),
    (Reference(), "Neimark-Sacker", 3.8248, (2.70, 2.76, 3.90)),
    (Reference(), "period doubling", 1.8007, (1.79, 1.95, 1.96)),
    (Reference(), "period doubling", 1.6681, (1.66, 1.95, 1.96)),
    (Reference(), "grazing", 1.5685, (1.56, 1.95, 1.96)),
    (EXACT, "period doubling", 1.7986, (1.79, 1.95, 1.96)),
    (Reference(), "Neimark-Sacker", 1.5537, (1.49, 1.50, 1.56)),
    (Reference(), "fold", 1.2375, (1.21, 1.30, 1.31)),
    (EXACT, "period doubling", 2.7798, (2.70, 2.76, 2.80)),
    (Reference(), "grazing", 1.2137, (1.21, 1.30, 1.31)),
    (EXACT, "Neimark-Sacker", 3.8181, (2.70, 2.76, 3.90)),
    (EXACT, "grazing", 1.5704, (1.56, 1.95, 1.96)),
]


@pytest.mark.parametrize(("method", "kind", "near", "reach"), every(POINTS))
def test_points_of_the_papers_system_equal_those_of_a_solution_of_30_digits(method, kind, near, reach):
    low, eta, high = reach
    branch = continue_branch(BranchQuestion(PAPER, eta, method, low=low, high=high, max_period=1))
    point = min((p for p in branch.points if p.kind == kind), key=lambda p: abs(p.value - near))
    assert abs(point.value - near) < 2e-4
    assert abs(of_twin(eta, method, "eta", point) - point.value) < CLOSE


# The same over other numbers: method, number, kind, η, and the range.
OTHERS = [
    (EXACT, "K", "period doubling", 2.78, (6000.0, 30_000.0)),
    (EXACT, "D", "period doubling", 2.78, (10.0, 30.0)),
    (Reference(), "restitution", "period doubling", 2.79, (0.4, 0.6)),
]


@pytest.mark.parametrize(("method", "over", "kind", "eta", "reach"), every(OTHERS))
def test_points_over_other_numbers_equal_those_of_a_solution_of_30_digits(method, over, kind, eta, reach):
    low, high = reach
    branch = continue_branch(BranchQuestion(PAPER, eta, method, over=over, low=low, high=high, max_period=1))
    (point,) = (p for p in branch.points if p.kind == kind)
    assert abs(of_twin(eta, method, over, point) - point.value) < CLOSE * (high - low)


def of_twin(eta, method, over, point):
    """Where the twin has a point."""
    with mp.workdps(DIGITS):
        twin = Twin(PAPER, eta, method, point.events, point.events[-1] in TOUCHING, point.period, over)
        guess = [mp.mpf(float(each)) for each in (*point.state, *point.instants, point.value)]
        return float(twin.located(point.kind, guess))


def budd_dux(omega, e, clearance, sign=1):
    """Orbit of ẍ + x = cos ωt against a wall with one impact a cycle (Budd & Dux).

    Returns its closing speed, x and x′ at τ = 0, and cos ωt at the impact.

    With C = sin T (1 + e)/(1 − cos T), ρ = (1 − e)/ω, γ = 1/(1 − ω²) the closing speed is V = (−2Cσ + √Δ)/(C² + ρ²),
    Δ = 4(γ²C² − (σ² − γ²)ρ²).
    """
    cycle, gamma, rho = 2 * np.pi / omega, 1 / (1 - omega**2), (1 - e) / omega
    c, s = np.cos(cycle), np.sin(cycle)
    big_c = s * (1 + e) / (1 - c)
    delta = 4 * (gamma**2 * big_c**2 - (clearance**2 - gamma**2) * rho**2)
    speed = (-2 * big_c * clearance + sign * np.sqrt(delta)) / (big_c**2 + rho**2)
    # after the impact at t = 0: x = a cos t + b sin t + p cos ωt + q sin ωt
    rows = [[1, 0, 1, 0], [0, 1, 0, omega], [c, s, 1, 0], [-s, c, 0, omega]]
    a, b, p, q = np.linalg.solve(rows, [clearance, -e * speed, clearance, speed])
    turn = np.arctan2(-q / gamma, p / gamma)  # p cos ωt + q sin ωt = γ cos(ωt + turn)
    t = (-turn / omega) % cycle
    here = np.array([np.cos(t), np.sin(t), np.cos(omega * t), np.sin(omega * t)])
    rate = np.array([-np.sin(t), np.cos(t), -omega * np.sin(omega * t), omega * np.cos(omega * t)])
    return speed, ([a, b, p, q] @ here, [a, b, p, q] @ rate), np.cos(turn)


def trace(omega, e, clearance, sign):
    """Trace of the Poincaré map of that orbit: −2e cos T + (1 + e) a sin T/V, a the acceleration at the wall."""
    speed, _, load = budd_dux(omega, e, clearance, sign)
    cycle = 2 * np.pi / omega
    return -2 * e * np.cos(cycle) + (1 + e) * (load - clearance) / speed * np.sin(cycle)


def random_orbits(count):
    """ω and e of orbits with one impact a cycle, and the clearance at which they fold."""
    random = np.random.default_rng(2)
    for omega, e in zip(random.uniform(2.1, 3.6, count), random.uniform(0.5, 0.95, count), strict=True):
        gamma, rho = 1 / (1 - omega**2), (1 - e) / omega
        cycle = 2 * np.pi / omega
        big_c = np.sin(cycle) * (1 + e) / (1 - np.cos(cycle))
        yield omega, e, -abs(gamma) * np.hypot(1, big_c / rho)  # big_c > 0


def wall(omega, e, clearance):
    """The system of these orbits."""
    force = Excitation(base=0.0, force1=1.0)
    return (
        System(wall=True, d1=0.0, clearance=clearance, restitution=e, excitation=force),
        omega,
        Reference(threshold=0),
    )


@pytest.mark.parametrize(("omega", "e", "fold"), every(random_orbits(50)))
def test_fold_and_multipliers_of_an_orbit_with_one_impact_are_those_of_closed_form(omega, e, fold):
    near, reach = 0.97 * fold, {"low": 1.05 * fold, "high": 0.96 * fold}
    state = budd_dux(omega, e, near)[1]
    branch = continue_branch(
        BranchQuestion(*wall(omega, e, near), over="clearance", **reach, initial=(*state, 0, 0), max_period=1)
    )
    (found,) = values(branch, "fold")
    assert abs(found / fold - 1) < CLOSE
    for k in range(0, len(branch.values), 7):  # both signs of the root: two orbits at each clearance
        if branch.values[k] == found:  # a double root
            continue
        expected = [trace(omega, e, branch.values[k], sign) for sign in (1, -1)]
        assert min(abs(branch.multipliers[k].sum() - each) for each in expected) < 1e-9 * max(map(abs, expected))
        assert abs(branch.multipliers[k][:2].prod() - e**2) < 1e-9


@pytest.mark.parametrize("seed", every(range(20)))
@pytest.mark.parametrize("method", [Reference(threshold=0), ExactPenalty(1000.0, 3.0)], ids=["reference", "exact"])
def test_an_orbit_grazes_the_wall_at_the_amplitude_of_the_linear_response(seed, method):
    random = np.random.default_rng(seed)
    omega, d, clearance = random.uniform(0.3, 3.0), random.uniform(0.02, 0.3), random.uniform(0.2, 3.0)
    grazing = clearance * np.hypot(1 - omega**2, 2 * d * omega)
    force = Excitation(base=0.0, force1=0.5 * grazing)
    system = System(wall=True, d1=d, clearance=clearance, restitution=0.8, excitation=force)
    branch = continue_branch(
        BranchQuestion(system, omega, method, over="force1", low=0.4 * grazing, high=1.02 * grazing, max_period=1)
    )
    assert np.abs(values(branch, "grazing") / grazing - 1).min() < 1e-12
