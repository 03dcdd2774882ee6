"""The energy balance: equal to 60-digit work and losses, closed for every solver, open where an event is wrong."""

from dataclasses import replace

import numpy as np
import pytest
from vibroscope.engine import ExactPenalty, Newmark, Record, Reference, System, simulate
from vibroscope.engine.energy.balance import energy_balance

from tests import hard
from tests.share import every

EPSILON = np.finfo(float).eps


def run(eta, method, periods=20, system=None, initial=(0.0, 0.0, 0.0, 0.0), record=None):
    response = simulate(system or System(), eta, method, periods=periods, keep=periods, initial=initial, record=record)
    assert response.ok
    return response


def fastest(method):
    """Largest rate of the contact in units of ω₁: the factor by which a rounding error of an instant grows."""
    return 1 + np.sqrt(getattr(method, "stiffness", 0)) + getattr(method, "damping", 0)


def check_work_and_losses(case, response, balance):
    """Allowed is what follows from the error of the state, in which work and losses are quadratic."""
    _, eta, method = hard.arguments(case)
    truth = {name: float(value) for name, value in hard.CASES[case]["energy"].items()}
    error = np.abs(response.section - hard.states(case)).max()
    allowed = 100 * len(balance.work) * balance.size * EPSILON * (fastest(method) + eta)
    allowed += 100 * error * np.sqrt(balance.size) * response.window[1] * max(1, eta) ** 2
    assert abs(balance.work.sum() - truth["work"]) < allowed
    assert abs((balance.dampers + balance.contact).sum() - truth["damped"]) < allowed
    assert abs(balance.impacts.sum() - truth["lost"]) < allowed


def check_balance(method, eta, balance):
    """What is put in is lost or stored, and no impact or damper gives anything."""
    assert np.abs(balance.residual).max() < 100 * EPSILON * balance.size * (fastest(method) + eta + 1 / eta)
    assert (balance.impacts >= -EPSILON * balance.size).all()  # nothing, at e = 1
    assert (balance.dampers >= 0).all()


@pytest.mark.parametrize("case", every(hard.CASES))
def test_work_and_losses_are_the_true_ones_and_the_balance_closes(case):
    system, eta, method = hard.arguments(case)
    response = run(eta, method, hard.periods(case), system, hard.initial(case))
    balance = energy_balance(response, hard.initial(case))
    if hard.CASES[case].get("energy"):
        check_work_and_losses(case, response, balance)
    if "D=1e6" not in case:
        check_balance(method, eta, balance)


@pytest.mark.parametrize("threshold", [1e-9, 0.0])
def test_a_completed_chatter_is_balanced(threshold):
    """The limit sums the losses of infinitely many impacts; a small threshold has them one by one."""
    balance = energy_balance(run(1.08, Reference(threshold=threshold)))
    assert np.abs(balance.residual).max() < 1e-13 * balance.size


def test_the_balance_without_an_initial_state_omits_the_first_period():
    response = run(2.76, ExactPenalty(12000, 18))
    whole, later = energy_balance(response, (0, 0, 0, 0)), energy_balance(response)
    for name in ("gain", "work", "dampers", "contact", "impacts"):
        np.testing.assert_allclose(getattr(whole, name)[1:], getattr(later, name), atol=1e-13 * whole.size)


@pytest.mark.parametrize("change", [1e-6, -1e-6])
def test_a_wrong_event_leaves_a_residual(change):
    """A displaced impact, a wrong speed after it, a contact that ends late, a missing impact."""
    response = run(1.08, Reference())
    closed = np.abs(energy_balance(response).residual).max()
    impacts = response.impacts
    faster = replace(impacts, velocity_after=impacts.velocity_after + np.array([0.0, change]))
    late = response.contacts.copy()
    late[:, 1] += change * 1e3
    moved = replace(impacts, position=impacts.position + change)
    for wrong in (
        replace(response, impacts=faster),
        replace(response, contacts=late),
        replace(response, impacts=moved),
    ):
        assert np.abs(energy_balance(wrong).residual).max() > 1e4 * closed
    hardest = np.argmax(impacts.closing_speed)
    fewer = replace(impacts, **{name: np.delete(value, hardest, axis=0) for name, value in vars(impacts).items()})
    assert np.abs(energy_balance(replace(response, impacts=fewer)).residual).max() > 1e4 * closed


def test_the_losses_of_a_stiff_contact_tend_to_those_of_impacts():
    """A contact of equal restitution loses what an impact loses, up to O(1/√K)."""
    system = System()
    zeta = -np.log(0.5) / np.hypot(np.pi, np.log(0.5))
    lost = []
    for stiffness in (1e4, 1e6, 1e8):
        damping = zeta * np.sqrt(stiffness * system.mass_share)
        soft = energy_balance(run(2.76, ExactPenalty(stiffness, damping), 300)).contact[-50:].mean()
        lost.append(soft)
    rigid = energy_balance(run(2.76, Reference("derived"), 300)).impacts[-50:].mean()
    errors = np.abs(np.array(lost) - rigid)
    assert errors[2] < 1e-2 * rigid
    assert errors[2] < errors[1] < errors[0]


def test_newmark_balances_exactly_except_where_contact_changes():
    """Average acceleration creates no energy within a step, only where contact begins or ends."""
    free = run(80.0, Newmark(10.0, 0.1, 300), 2, initial=(-3.0, 0.0, 4.0, 0.0), record=Record(2, 300))
    assert len(free.contacts) == 0
    balance = energy_balance(free)
    assert np.abs(balance.residual).max() < 300 * EPSILON * balance.size
    coarse, fine = (energy_balance(run(2.76, Newmark(12000, 18, n), 20, record=Record(20, n))) for n in (2000, 32_000))
    made = [np.abs(balance.residual).mean() for balance in (coarse, fine)]
    assert made[0] > 1e-2
    assert made[1] < made[0] / 4


def test_the_located_step_balances_to_second_order():
    steps = np.array([400, 800, 1600, 3200, 6400])
    runs = [run(2.76, Newmark(12000, 18, int(n), located=True)) for n in steps]
    residuals = [np.abs(energy_balance(response).residual).mean() for response in runs]
    assert -np.polyfit(np.log(steps), np.log(residuals), 1)[0] == pytest.approx(2, abs=0.2)


def test_periods_whose_closed_form_overflows_are_nan():
    """Each contact that a coarse step misplaces drives the closed form K times as far away."""
    balance = energy_balance(run(0.5, Newmark(1e9, 18, 8, located=True), 60))
    lost = np.isnan(balance.residual)
    assert lost.any()
    for each in (balance.work, balance.dampers, balance.contact):
        np.testing.assert_array_equal(np.isnan(each), lost)


def test_responses_that_cannot_be_balanced_are_refused():
    one = run(2.76, Reference(), 1)
    with pytest.raises(ValueError, match="keep two periods"):
        energy_balance(one)
    assert len(energy_balance(one, (0, 0, 0, 0)).work) == 1
    with pytest.raises(ValueError, match="record every step"):
        energy_balance(run(2.76, Newmark(12000, 18, 200), record=Record(2, 100)))
    blown = simulate(System(), 2.76, Newmark(60000, 1, 100), periods=500, keep=500)
    with pytest.raises(ValueError, match="diverged"):
        energy_balance(blown)
