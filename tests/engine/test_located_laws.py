"""Located steps with other contact laws than spring and damper: their twin, their order, their energy, their bits."""

import math

import numpy as np
import pytest
from vibroscope.engine import (
    INTEGRATORS,
    LAWS_BY_RESTITUTION,
    Excitation,
    Newmark,
    NewmarkBeta,
    System,
    TimeStepping,
    simulate,
)
from vibroscope.engine.energy.balance import energy_balance

from tests.engine.test_law_exact import APART, OTHER, method_of
from tests.law_numbers import law_numbers
from tests.naive_law_located import LocatedLawTwin
from tests.share import every

PERIODS = 2
SEEDS = 138, 505, 96, 366, 143, 433, *range(4)  # the first six have such a piece, as 4 of 100 have
EXPONENTS = {"impact": 2.2, "hunt-crossley": 1.0, "constant-restitution": 2.0}
# of the integrator alone 2; the damper of "jankowski" begins as δ^¼, that of "constant-restitution" with n = 2 as δ^½
ORDERS = {"jankowski": 1.25, "constant-restitution": 1.5}


def cases():
    """Integrator and law, in turns with two bodies and at a wall."""
    for turn, law in enumerate(OTHER):
        for other, kind in enumerate(INTEGRATORS.values()):
            yield kind, law, not (turn + other) % 2


@pytest.mark.parametrize(("kind", "law", "wall"), every(cases()))
def test_changes_and_states_are_those_of_the_twin(kind, law, wall):
    system = System(wall=wall, mu=None if wall else 0.7, kappa=2.0, d1=0.4, d2=0.5, clearance=0.1)
    steps, damping = 120 if kind.explicit else 50, None if law in LAWS_BY_RESTITUTION else 2.0
    numbers = law_numbers(law, EXPONENTS.get(law), 0.05)
    method = TimeStepping(80.0, damping, steps, kind(), "located", law=law, **numbers)
    run = simulate(system, 1.3, method, periods=PERIODS, keep=PERIODS)
    changes, states = LocatedLawTwin(system, 1.3, method).changes(PERIODS)
    assert len(changes) == 2 * len(run.contacts) > 0
    np.testing.assert_allclose(run.contacts.ravel(), [tau for tau, _ in changes], rtol=0, atol=1e-11)
    np.testing.assert_allclose(run.section, states, rtol=0, atol=1e-11)


def random_case(seed):
    """A contact of a few steps, with its method and where it starts: bodies apart."""
    draw = np.random.default_rng(seed)
    law, eta, clearance = draw.choice(["limited", "compression"]), draw.uniform(0.5, 1.5), draw.choice([-0.3, 0.0, 0.1])
    stiffness = 10 ** draw.uniform(1.5, 3.5)
    damping = 10 ** draw.uniform(-0.7, 0.7) * math.sqrt(stiffness / 2)  # times the critical one
    steps = int(2 * math.pi / eta * math.sqrt(2 * stiffness) / draw.uniform(1.0, 2.0))  # of 1 to 2 of the contact mode
    start = draw.uniform([-1.0, -1.0, 0.31, -1.0], [0.0, 1.0, 1.0, 1.0]).tolist()
    system = System(clearance=clearance, d1=0.05, d2=0.05)
    return system, eta, TimeStepping(stiffness, damping, steps, NewmarkBeta(), "located", law=str(law)), start


@pytest.mark.parametrize("seed", every(SEEDS))
def test_a_piece_that_begins_and_ends_within_one_step_is_seen(seed):
    """A piece begins where what ended the former one is zero: that zero is not its end."""
    system, eta, method, start = random_case(seed)
    run = simulate(system, eta, method, periods=PERIODS, keep=PERIODS, initial=start)
    _, states = LocatedLawTwin(system, eta, method).changes(PERIODS, start)
    np.testing.assert_allclose(run.section, states, rtol=0, atol=1e-9)


def errors_of(law, status, integrator):
    """Errors after a period over n."""
    exact = simulate(System(), 2.76, method_of(law), periods=1, keep=1, initial=APART).section[-1]
    found = []
    for steps in (1600, 3200, 6400, 12800, 25600):
        method = method_of(law, kind=TimeStepping, steps=steps, status=status, integrator=integrator)
        found.append(
            np.abs(simulate(System(), 2.76, method, periods=1, keep=1, initial=APART).section[-1] - exact).max()
        )
    return np.array(found)


def order_of(errors):
    return -np.polyfit(np.log(2.0) * np.arange(len(errors)), np.log(errors), 1)[0]


@pytest.mark.parametrize("name", ["newmark", "hht", "bathe"])
@pytest.mark.parametrize("law", OTHER)
def test_the_order_is_that_of_the_integrator_where_the_force_allows_it(law, name):
    located, plain = (errors_of(law, status, INTEGRATORS[name]()) for status in ("located", "start"))
    assert abs(order_of(located) - ORDERS.get(law, 2.0)) < 0.25
    if law in ("cut", "compression"):  # whose damper jumps at touch
        assert order_of(plain) < 1.3
        assert located[-1] < plain[-1] / 100


def test_newmark_cut_at_zero_resolves_its_contacts():
    """Its steps in contact are shortened, with the law that is cut as with spring and damper."""
    exact = simulate(System(), 2.76, method_of("cut", 12000.0, 18.0), periods=3, keep=1).section[-1]
    found = []
    for steps in (200, 400, 800, 1600):
        run = simulate(System(), 2.76, Newmark(12000, 18, steps, located=True, law="cut"), periods=3, keep=1)
        assert run.cost.steps > 3.3 * steps
        found.append(np.abs(run.section[-1] - exact).max())
    assert 1.8 < order_of(np.array(found)) < 2.2


@pytest.mark.parametrize("law", OTHER)
def test_the_energy_balance_closes_as_steps_become_smaller(law):
    system, residuals = System(clearance=-0.05, excitation=Excitation(base=0.3)), []
    for steps in (200, 800):
        method = method_of(law, kind=TimeStepping, steps=steps, status="located")
        balance = energy_balance(simulate(system, 1.4, method, periods=12, keep=4))
        residuals.append(np.abs(balance.residual).max() / balance.size)
    assert residuals[1] < residuals[0] / 3
    assert residuals[1] < 0.01
