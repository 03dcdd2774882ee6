"""The paper's claims that need only the two solvers, with the numbers checked in the model's description.

2,050 periods from rest, the last 50 kept, as in the paper.
"""

import numpy as np
import pytest

from engine import Newmark, Reference, System, motion, simulate

SYSTEM = System()


def reference(eta):
    return simulate(SYSTEM, eta, Reference())


def penalty(eta, stiffness, damping, steps, keep=50):
    return simulate(SYSTEM, eta, Newmark(stiffness, damping, steps), periods=2000 + keep, keep=keep)


def test_constants_of_table_1():
    assert pytest.approx(0.8722401775, abs=1e-10) == SYSTEM.mass_ratio
    assert SYSTEM.derived_joint_damping == pytest.approx(0.0084644, abs=1e-7)


def test_fig_4a_one_period_ten_impacts_one_permanent_contact():
    response = reference(1.08)
    found = motion(response)
    assert (found.period, found.impacts_per_period, found.contacts_per_period) == (1, 10, 1)
    np.testing.assert_allclose(response.section[-1], [1.68339, 0.59798, 1.68339, 0.59798], atol=1e-5)


def test_fig_4a_with_derived_damping_nine_impacts():
    found = motion(simulate(SYSTEM, 1.08, Reference("derived")))
    assert (found.period, found.impacts_per_period) == (1, 9)


def test_fig_4b_stripes():
    response = reference(1.70)
    found = motion(response)
    assert found.period == 0
    assert found.spread > 0.3


def test_fig_4b_is_chaotic_in_two_bands():
    """Two runs 1e-9 apart drift apart by about +0.27 per period: chaos, not quasi-periodicity.

    Two bands: in ξ₁ the section leaves a gap in its middle, and visits its two sides in turn.
    """
    start = simulate(SYSTEM, 1.70, Reference(), periods=500, keep=1).section[-1]
    one = simulate(SYSTEM, 1.70, Reference(), periods=40, keep=40, initial=start).section
    other = simulate(SYSTEM, 1.70, Reference(), periods=40, keep=40, initial=start + np.array([0, 1e-9, 0, 0])).section
    distance = np.linalg.norm(one - other, axis=1)
    rate = np.polyfit(np.arange(40), np.log(distance), 1)[0]
    assert 0.1 < rate < 0.5
    xi1 = simulate(SYSTEM, 1.70, Reference(), periods=2000, keep=200).section[:, 0]
    low, high = sorted((xi1[::2], xi1[1::2]), key=np.mean)
    assert low.max() < high.min()
    assert np.ptp(low) > 0.5
    assert np.ptp(high) > 0.5


def test_fig_4c_one_period_one_impact():
    response = reference(2.76)
    found = motion(response)
    assert (found.period, found.impacts_per_period, found.contacts_per_period) == (1, 1, 0)
    np.testing.assert_allclose(response.section[-1], [-5.56905, -0.59972, 0.62677, 3.90177], atol=1e-5)


def test_fig_4d_two_periods_one_impact_in_two():
    found = motion(reference(3.25))
    assert (found.period, found.impacts_per_period) == (2, 0.5)


def test_fig_9a_captures_the_motion():
    response = penalty(1.08, 2500, 8, 2000)
    found = motion(response)
    assert (found.period, found.contacts_per_period) == (1, 3)
    assert response.section[-1, 2] == pytest.approx(1.6992, abs=1e-4)
    lengths = np.diff(response.contacts[1:4]).ravel()
    assert lengths.max() > 3 * np.sort(lengths)[-2]


def test_fig_9b_is_completely_different():
    response = penalty(1.08, 100, 50, 2000)
    found = motion(response)
    assert found.contacts_per_period == 1
    assert found.contact_share == pytest.approx(0.56, abs=0.01)
    assert response.section[-1, 2] == pytest.approx(1.03, abs=0.01)


def test_fig_12_contact_of_18_steps():
    response = penalty(2.76, 12000, 18, 2000)
    steps = np.diff(response.contacts).ravel() / (2 * np.pi / 2.76 / 2000)
    assert round(np.median(steps)) == 18


def test_fig_14_spread_falls_with_the_step_but_never_vanishes():
    """The kept 50 periods are a sample of a disturbed motion, so longer stretches are compared: roughly 1/n."""
    steps = np.array([2000, 4000, 6000, 8000, 32000])
    spread = np.array([motion(penalty(2.76, 12000, 18, n, keep=1000)).spread for n in steps])
    assert 0.1 < spread[0] < 0.4
    assert 0.003 < spread[-1] < 0.01
    slope = np.polyfit(np.log(steps), np.log(spread), 1)[0]
    assert -1.6 < slope < -0.8
