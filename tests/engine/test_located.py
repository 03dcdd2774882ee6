"""Newmark with located contact changes: its twin, its order, its checkpoints."""

import math

import numpy as np
import pytest
from vibroscope.engine import Newmark, System, motion, simulate
from vibroscope.engine.drivers.located import scheme_of_run
from vibroscope.engine.drivers.parameters import parameters_of
from vibroscope.engine.kernels.compile.record import make_buffers
from vibroscope.engine.kernels.time_stepping import contact_location as location
from vibroscope.engine.kernels.time_stepping import law_pieces
from vibroscope.engine.kernels.time_stepping import located as kernel

from tests import truth
from tests.naive_located import newmark_located
from tests.share import every

CASES = {"pen|2.76|12000,18": (2.76, 12000.0, 18.0), "pen|1.08|2500,8": (1.08, 2500.0, 8.0)}


def run(eta, stiffness, damping, n, periods=10, located=True, **options):
    options = {"keep": periods, **options}
    return simulate(System(), eta, Newmark(stiffness, damping, n, located=located), periods=periods, **options)


def error(case, n, periods, **options):
    section = run(*CASES[case], n, periods, **options).section
    return np.abs(section[periods - 1] - truth.states(case)[periods]).max()


@pytest.mark.parametrize(
    ("eta", "stiffness", "damping", "n", "periods"),
    every(
        [
            (2.76, 12000.0, 18.0, 50, 3),
            (1.08, 2500.0, 8.0, 80, 2),
            (1.08, 100.0, 50.0, 40, 4),
            (3.25, 1000.0, 0.0, 30, 4),
            (1.70, 10.0, 30.0, 60, 4),  # overdamped
            (0.50, 5.0, 0.1, 100, 2),  # a contact softer than the pendulums
        ]
    ),
)
def test_contact_changes_and_states_are_those_of_the_twin(eta, stiffness, damping, n, periods):
    changes, states = newmark_located(System(), eta, stiffness, damping, n, periods)
    response = run(eta, stiffness, damping, n, periods)
    found = response.contacts.ravel()
    assert len(changes) > periods
    np.testing.assert_allclose(found[: len(changes)], [tau for tau, _ in changes], atol=1e-9)
    assert len(found) - len(changes) == (1 if changes[-1][1] else 0)
    np.testing.assert_allclose(response.section, states, atol=1e-8)


@pytest.mark.parametrize("case", CASES)
@pytest.mark.parametrize("periods", [1, 10])
def test_second_order(case, periods):
    steps = np.array([200, 400, 800, 1600, 3200])
    errors = [error(case, int(n), periods) for n in steps]
    order = -np.polyfit(np.log(steps), np.log(errors), 1)[0]
    assert 1.9 < order < 2.1


@pytest.mark.parametrize("case", CASES)
def test_contact_changes_are_those_of_the_truth(case):
    expected = truth.events(case)
    errors = []
    for n in (1600, 3200):
        response = run(*CASES[case], n)
        found = response.contacts.ravel()[: len(expected)]
        assert [kind for _, kind, _ in expected] == [0, 1] * (len(expected) // 2) + [0] * (len(expected) % 2)
        errors.append(np.abs(found - [tau for tau, _, _ in expected]).max())
        speeds = np.array([-speed for _, kind, speed in expected if kind == 0 and speed < 0])
        closed = len(response.impacts)
        assert closed in (len(speeds), len(speeds) - 1)  # the last one may last beyond the events listed
        errors.append(np.abs(response.impacts.closing_speed - speeds[:closed]).max())
    assert errors[2] < errors[0] / 3
    assert errors[3] < errors[1] / 3
    assert max(errors[2:]) < 1e-3


def test_200_steps_do_what_8000_do_not():
    """The paper's Figure 14: the motion is periodic, and shows so; at a twentieth of the solves, or less."""
    case = "pen|2.76|12000,18"
    cut, plain = (run(*CASES[case], n, 2050, located, keep=50) for n, located in ((200, True), (8000, False)))
    assert motion(cut).period == 1
    assert motion(plain).period == 0
    assert motion(cut).spread < 1e-6 * motion(plain).spread
    for periods in (10, 50):
        assert error(case, 200, periods) < 0.2 * error(case, 8000, periods, located=False)
    assert cut.cost.steps < 0.05 * plain.cost.steps


def scheme(eta, method):
    """Both sides and the time grid of the default system."""
    return scheme_of_run(parameters_of(System(), eta, method), method)


def start(m, initial):
    """The state at τ = 0."""
    return kernel.start_state(m, initial, False, False)


def test_location_alone_is_not_enough():
    """With contacts of two steps the location is exact and the rebound is not: contacts need steps of their own."""
    case, n, periods = "pen|2.76|12000,18", 200, 10
    m = scheme(2.76, Newmark(12000, 18, n, located=True))
    coarse = m._replace(shortest_step=m.h)
    assert coarse.shortest_step * math.sqrt(-m.pressed.bg) > 1.5  # ω_c Δτ
    nothing, ends = make_buffers(0, np.zeros(1), 0, 0), []
    forces = 2.76**2 * np.column_stack([np.cos(2 * np.pi * np.arange(n + 1) / n), np.zeros(n + 1)])
    for chosen in (m, coarse):
        state = kernel.STATE.pack(start(chosen, (0.0, 0.0, 0.0, 0.0)))
        window = (periods * n, periods * n, n)
        kernel.integrate_located(location.SCHEME.pack(chosen), forces, state, periods * n, 10**9, window, *nothing[:2])
        s = kernel.STATE.read(state)
        ends.append(np.abs(np.array([s.x, s.v, s.x + s.g, s.v + s.u]) - truth.states(case)[periods]).max())
    assert ends[1] > 100 * ends[0]


@pytest.mark.parametrize("depth", [1e-6, 1e-9, 1e-12, -1e-12, -1e-9, -1e-6])
@pytest.mark.parametrize("contact", [False, True])
def test_a_dip_within_a_step_is_found_if_it_crosses(depth, contact):
    """A gap that comes from its side, passes its end by ``depth``, and is back before the step ends."""
    m = scheme(1.08, Newmark(0.01, 0.0, 100, located=True))  # contact as soft as can be: two like sides
    e, side, h = (m.pressed if contact else m.separated), (-1.0 if contact else 1.0), m.h
    displaced = -1.0 * side  # pendulum 2 accelerates by (κ² − 1) x less than pendulum 1 in either
    now = location.forcing_at(m, (0, 0.0))
    curvature = location.with_accelerations(e, (displaced, 0.0, 0.0, 0.0, 0.0, 0.0), now)[5] * side
    assert curvature > 0
    # the vertex lies half a step ahead; its height is found by stepping there, and set
    speed, gap = -0.5 * h * curvature, 0.0
    for _ in range(30):
        z = location.with_accelerations(e, (displaced, 0.0, 0.0, side * gap, side * speed, 0.0), now)
        end = location.step(e, z, h, location.forcing_at(m, (0, h)))
        vertex = -speed / (0.5 * side * (z[5] + end[5]))
        there = location.step(e, z, vertex, location.forcing_at(m, (0, vertex)))
        gap -= side * there[3] + depth
    assert (end[3] <= 0.0) == contact  # the same side at both ends
    piece = law_pieces.MAIN if contact else law_pieces.FREE
    theta, at, after, _ = law_pieces.locate_change(m, m.law.gain, piece, z, end, h, (0, 0.0))
    assert (after == piece) == (depth < 0)
    if depth > 0:
        assert 0 < theta < vertex
        for earlier in np.linspace(0, theta, 50, endpoint=False)[1:]:
            assert side * location.step(e, z, earlier, location.forcing_at(m, (0, earlier)))[3] > 0
        assert at[3] == 0.0
        assert side * at[4] < 0


def test_starts():
    """At zero gap the first derivative of the gap that is not zero decides."""
    method = Newmark(12000, 18, 200, located=True)
    for initial, contact in (
        ((0, 0, 0, 0), True),  # the third, negative
        ((0, 1, 0, 2), False),  # the first
        ((0, 2, 0, 1), True),
        ((1, 0, 1, 0), True),  # the second: (1 − κ²) ξ
        ((-1, 0, -1, 0), False),
        ((0, 0, 1e-300, -5), False),
        ((0, 0, -1e-300, 5), True),
    ):
        assert (start(scheme(2.76, method), initial).piece != kernel.FREE) == contact, initial
    approaching = run(2.76, 12000.0, 18.0, 200, 1, initial=(0, 2, 0, 1))
    assert approaching.impacts.time[0] == 0
    assert approaching.impacts.closing_speed[0] == 1
    assert run(2.76, 12000.0, 18.0, 200, 1).contacts[0, 0] == 0


def test_impulse_is_the_change_of_momentum():
    """Over one short contact the springs of the pendulums hardly act: μ Δξ₂′ ≈ impulse ≈ −Δξ₁′."""
    system = System()
    impacts = run(2.76, 1e8, 1500.0, 200, 300, keep=20).impacts
    gained = system.mass_ratio * (impacts.velocity_after[:, 1] - impacts.velocity_before[:, 1])
    lost = impacts.velocity_before[:, 0] - impacts.velocity_after[:, 0]
    assert len(impacts) >= 20
    np.testing.assert_allclose(impacts.impulse, gained, rtol=2e-3)
    np.testing.assert_allclose(impacts.impulse, lost, rtol=2e-3)
    np.testing.assert_allclose(
        impacts.closing_speed, impacts.velocity_before[:, 0] - impacts.velocity_before[:, 1], rtol=1e-12
    )


@pytest.mark.parametrize("ratio", [0.0, 0.1, 0.5, 0.9])
def test_a_short_impact_has_the_restitution_of_its_damping(ratio):
    """e(ζ) holds for a contact that ends at zero gap, as these do: −g′⁺/g′⁻ = exp(−πζ/√(1 − ζ²))."""
    stiffness = 1e10
    damping = ratio * math.sqrt(stiffness * System().mass_share)
    response = run(2.76, stiffness, damping, 400, 1, initial=(0, 5.0, 0, -5.0))
    impacts = response.impacts
    before = impacts.velocity_before[0, 0] - impacts.velocity_before[0, 1]
    after = impacts.velocity_after[0, 1] - impacts.velocity_after[0, 0]
    assert after / before == pytest.approx(math.exp(-math.pi * ratio / math.sqrt(1 - ratio**2)), abs=2e-3)


def test_the_motion_between_changes_is_the_plain_one():
    """Without contact no step is cut: the same solution, solve for solve."""
    start = (-100.0, 0.0, 500.0, 0.0)
    cut, plain = (run(10.0, 10.0, 0.1, 300, 1, located, initial=start) for located in (True, False))
    np.testing.assert_allclose(cut.section, plain.section, rtol=1e-11)
    assert len(cut.contacts) == 0
    assert cut.cost.steps == plain.cost.steps == 300
