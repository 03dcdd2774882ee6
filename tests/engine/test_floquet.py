"""The bifurcation that the multipliers and closing speeds of a cycle show to be near."""

import numpy as np
import pytest
from vibroscope.engine import Reference, System, motion
from vibroscope.engine.motions.poincare_map import nearest_bifurcation

SYSTEM = System()


@pytest.mark.parametrize(
    ("values", "approach", "name", "margin"),
    [
        ([-0.9, 0.5, 0.1, 0.0], 5.0, "period doubling", 0.1),
        ([0.95, 0.5, -0.9, 0.0], 5.0, "fold", 0.05),
        ([0.6 + 0.7j, 0.6 - 0.7j, 0.5, 0.1], 5.0, "Neimark-Sacker", 1 - np.hypot(0.6, 0.7)),
        ([-0.9, 0.5, 0.1, 0.0], 0.2, "grazing", 0.02),
        ([-0.9, 0.5, 0.1, 0.0], np.nan, "period doubling", 0.1),
    ],
)
def test_the_bifurcation_with_the_smallest_margin_is_nearest(values, approach, name, margin):
    found = nearest_bifurcation(np.array(values, complex), np.array([10.0, 3.0]), approach)
    assert found == (name, pytest.approx(margin))


def test_the_nearest_bifurcation_takes_place_when_eta_grows():
    """A multiplier approaches −1; beyond it the period is doubled, and the new cycle is near a fold."""
    found = [motion(SYSTEM, eta, Reference()) for eta in (2.76, 2.77, 2.79)]
    assert [each.period for each in found] == [1, 1, 2]
    assert [each.bifurcation for each in found] == ["period doubling", "period doubling", "fold"]
    assert found[0].margin > found[1].margin
