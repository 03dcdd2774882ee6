"""The search for what a motion is, with contact laws that have no closed form: its work is bounded, and said."""

from dataclasses import replace

import numpy as np
import pytest
from vibroscope.engine import Cancelled, ExactPenalty, Reference, System, TimeStepping, motion, simulate, steady
from vibroscope.engine.motions.description import CellKind, describe
from vibroscope.engine.motions.poincare_map import PoincareMap
from vibroscope.engine.motions.steady import CLOSED_FORM, schedule_of
from vibroscope.engine.motions.time_step_scatter import Limits, judge_bands, section_judgement

SYSTEM = System()
CHAOTIC = ExactPenalty(2500, 8, "hunt-crossley")  # at η = 1.08: it rebounds with nearly all of its speed
STATE = np.array([0.4, -1.2, 0.3, 2.0])  # ξ₁, ξ₁′, g, g′


def test_the_search_of_a_law_without_a_closed_form_ends_early_and_says_after_how_many_periods():
    found = steady(SYSTEM, 1.08, CHAOTIC)
    assert not found.periodic
    assert found.message.endswith("this is the run of 512 periods, the last 50 kept")
    assert (found.response.periods, found.response.keep) == (512, 50)


def test_a_chaotic_motion_of_such_a_law_is_found_with_few_periods_and_the_reason_says_how_many():
    found = motion(SYSTEM, 1.7, ExactPenalty(100, 1, "hunt-crossley"))
    assert (found.type, found.lyapunov > 3 * found.lyapunov_error > 0) == ("chaotic", True)
    assert found.reason.endswith("over 2048 periods")


def test_a_band_that_nothing_decided_says_what_was_run_without_the_step():
    run = simulate(SYSTEM, 1.08, TimeStepping(2500, 8, 300, law="hunt-crossley"), periods=300, keep=50)
    limit = replace(describe(run, 0), reason="growth over 2048 periods")
    limits = Limits(np.array([CellKind.UNDECIDED]), np.zeros(1, int), np.zeros(1))
    judged = judge_bands(run.section[None], np.zeros(1, int), limits, np.array([300]), None, ())
    reason = section_judgement(run, limit, judged, 0, []).reason
    assert reason.endswith("undecided (growth over 2048 periods): more steps per period would decide")


@pytest.mark.parametrize(
    "method", [Reference(), ExactPenalty(2500, 8), ExactPenalty(2500, 8, "cut"), ExactPenalty(2500, 8, "compression")]
)
def test_closed_forms_are_searched_as_long_as_ever(method):
    assert schedule_of(method) == CLOSED_FORM
    assert CLOSED_FORM[:3] == ((8, 32, 128, 512), 2050, 64)


@pytest.mark.parametrize("system", [SYSTEM, System(wall=True, clearance=0.1)], ids=["two bodies", "wall"])
@pytest.mark.parametrize("law", ["kelvin-voigt", "cut", "hunt-crossley"])
def test_a_derivative_in_one_direction_is_that_of_the_jacobian(system, law):
    poincare = PoincareMap(system, 1.08, ExactPenalty(2500, 8, law), None)
    y = np.array([0.0, 0.0, 0.3, 2.0]) if system.wall else STATE
    whole, direction = poincare(y), np.array([0.3, -0.5, 0.7, 0.2])
    after = direction.copy()
    growth, states = poincare.follow(y.copy(), after, 1)
    np.testing.assert_array_equal(states[0], whole.state)
    along, least = np.exp(growth[0]) * after, 1e-6 * np.abs(whole.jacobian).max()
    np.testing.assert_allclose(along, whole.jacobian @ direction, rtol=1e-4, atol=least)
    assert poincare.periods == 2


def test_the_residual_is_known_without_a_jacobian():
    poincare = PoincareMap(SYSTEM, 1.08, CHAOTIC, None)
    assert poincare.residual(STATE, 2) == poincare(STATE, 2).residual
    with pytest.raises(Cancelled):
        PoincareMap(SYSTEM, 1.08, CHAOTIC, lambda: True).residual(STATE, 2)


def test_a_cycle_of_such_a_law_is_found_as_before():
    found = steady(SYSTEM, 2.76, ExactPenalty(12000, 400, "hunt-crossley"))
    assert found.periodic
    assert found.residual < 1e-10
    assert np.abs(found.multipliers).max() < 1
