"""Newmark by leaps is the plain loop's solution: the same contact changes, at the same steps."""

import math

import numpy as np
import pytest

from engine import Newmark, Status, System, simulate
from engine.kernels.newmark import BEGIN, CONTACT, STEP

SETTINGS = [
    (1.08, 2500.0, 8.0, 2000),
    (1.08, 100.0, 50.0, 2000),
    (2.76, 12000.0, 18.0, 2000),
    (2.76, 12000.0, 18.0, 8000),
    (3.25, 12000.0, 18.0, 8000),
    (1.70, 12000.0, 18.0, 2000),
    (1.08, 1e5, 100.0, 32000),
    (0.50, 10.0, 0.1, 1000),
    (4.00, 1e4, 10.0, 1013),
    (2.76, 1e5, 1e4, 1500),
]


def at_the_end(eta, stiffness, damping, n, periods, *, every_step, x1=0.0):
    """The solver's whole state after some periods, the transient alone: predictors, contact and when it last began."""
    method = Newmark(stiffness, damping, n, every_step=every_step)
    response = simulate(System(), eta, method, periods=periods + 1, keep=1, initial=(x1, 0, 0, 0))
    return response, np.array(response.checkpoint.state)


def same_contact(one, other):
    return (one[[CONTACT, STEP, BEGIN]] == other[[CONTACT, STEP, BEGIN]]).all()


@pytest.mark.parametrize(("eta", "stiffness", "damping", "n"), SETTINGS)
def test_the_same_steps(eta, stiffness, damping, n):
    for periods in (1, 2, 5, 10):
        _, walked = at_the_end(eta, stiffness, damping, n, periods, every_step=True)
        _, leapt = at_the_end(eta, stiffness, damping, n, periods, every_step=False)
        assert same_contact(leapt, walked)
        np.testing.assert_allclose(leapt[:4], walked[:4], atol=1e-7)


def test_the_same_steps_wherever_rounding_does_not_decide():
    """300 settings drawn over the whole range of the explorer, three periods each.

    Many bounces in a period multiply a rounding error by up to 1e9. How much, the plain loop itself tells, started
    1e-11 beside rest: leaps may not differ from it by more than that, nor by any contact step where that does not.
    """
    rng, compared = np.random.default_rng(20), 0
    for _ in range(300):
        eta, n = rng.uniform(0.5, 4.0), int(np.exp(rng.uniform(math.log(1000), math.log(8000))))
        numbers = eta, 10 ** rng.uniform(1, 5), 10 ** rng.uniform(-1, 2), n
        walked, one = at_the_end(*numbers, 3, every_step=True)
        leapt, other = at_the_end(*numbers, 3, every_step=False)
        nudged = at_the_end(*numbers, 3, every_step=True, x1=-1e-11)[1]
        assert leapt.status == walked.status
        sensitivity = np.abs(one[:4] - nudged[:4]).max()
        if sensitivity > 1e-4:
            continue
        compared += 1
        assert same_contact(one, other), numbers
        assert np.abs(one[:4] - other[:4]).max() < 1e-9 + 10 * sensitivity, numbers
    assert compared > 250


def test_a_blow_up_is_met_at_the_same_step():
    arguments = 2.76, 1e7, 1.0, 1000
    walked, _ = at_the_end(*arguments, 40, every_step=True)
    leapt, _ = at_the_end(*arguments, 40, every_step=False)
    assert walked.status is leapt.status is Status.DIVERGED
    assert walked.cost.steps == leapt.cost.steps


def test_the_discrete_flight_is_newmarks():
    """Without contact the closed form and the loop agree over many periods, at any step."""
    for n in (1000, 3000):
        start = (0.0, 0.0, 500.0, 0.0)
        ends = [
            simulate(System(), 0.7, Newmark(10, 0.1, n, every_step=walk), periods=21, keep=1, initial=start).checkpoint
            for walk in (True, False)
        ]
        np.testing.assert_allclose(ends[0].state[:4], ends[1].state[:4], rtol=1e-10)
