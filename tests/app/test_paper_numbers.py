"""Numbers that the description of the model states for the paper's figures."""

import numpy as np
import pytest
from vibroscope.app.explorer.presets import scenes
from vibroscope.app.paper import CLAIMS
from vibroscope.app.paper.claims import SYSTEM, run_newmark, run_reference
from vibroscope.engine import Reference, motion, simulate


def test_constants_of_table_1():
    assert pytest.approx(0.8722401775, abs=1e-10) == SYSTEM.mass_ratio
    assert SYSTEM.derived_joint_damping == pytest.approx(0.0084644, abs=1e-7)


def test_figure_4a_ten_impacts_and_nine_with_derived_damping():
    assert motion(run_reference(scenes()["A"].setting)).impacts_per_period == 10
    found = motion(simulate(SYSTEM, 1.08, Reference("derived")))
    assert (found.period, found.impacts_per_period) == (1, 9)


def test_figure_4b_the_section_visits_two_bands_in_turn():
    xi1 = simulate(SYSTEM, 1.70, Reference(), periods=2000, keep=200).section[:, 0]
    low, high = sorted((xi1[::2], xi1[1::2]), key=np.mean)
    assert low.max() < high.min()
    assert min(np.ptp(low), np.ptp(high)) > 0.5


def test_figure_9_three_contacts_the_last_long_and_one_of_56_percent():
    captured, missed = (run_newmark(scenes()[key].setting) for key in ("9A", "9B"))
    assert motion(captured).contacts_per_period == 3
    assert captured.section[-1, 2] == pytest.approx(1.6992, abs=1e-4)
    lengths = np.sort(np.diff(captured.contacts[1:4]).ravel())
    assert lengths[-1] > 3 * lengths[-2]
    assert motion(missed).contact_share == pytest.approx(0.56, abs=0.01)
    assert missed.section[-1, 2] == pytest.approx(1.03, abs=0.01)


@pytest.mark.parametrize(
    ("key", "words"), [("9A", "One period, 3 contacts"), ("9B", "One period, blurred by the time step, 1 contact")]
)
def test_figure_9_names_the_motions_as_explore_does(key, words):
    """The time step locks the scatter of [B] into a cycle of eight periods."""
    finding = CLAIMS[key].find()
    assert finding.agrees
    assert finding.result.startswith(f"{words} a period, ")


def test_figure_12_contact_of_18_steps():
    run = run_newmark(scenes()["14A"].setting)
    assert round(np.median(np.diff(run.contacts)) / run.period * 2000) == 18
