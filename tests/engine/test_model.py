"""The frozen objects that hold the numbers."""

import dataclasses
import math

import pytest
from vibroscope.engine import Newmark, Reference, System, simulate


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("kappa", 1e-4),
        ("kappa3", 3.0),
        ("kappa3", 1.0),
        ("d1", -0.1),
        ("d2", 1.0),
        ("d3", math.nan),
        ("restitution", 1.01),
        ("d1", "x"),
    ],
)
def test_system_refuses(name, value):
    with pytest.raises(ValueError, match=f"{name} = "):
        System(**{name: value})


def test_mass_ratio_and_joint_frequency_belong_together():
    """κ₃² = (1 + μκ²)/(1 + μ), there and back."""
    for mu in (0.1, 0.8722401775, 5.0):
        assert System.from_mass_ratio(mu).mass_ratio == pytest.approx(mu, rel=1e-12)
        assert System.from_mass_ratio(mu).mass_share == pytest.approx(mu / (1 + mu), rel=1e-12)
    with pytest.raises(ValueError, match="mass_ratio"):
        System.from_mass_ratio(-1)


def test_pendulum_2_may_be_the_slower_one():
    system = System.from_mass_ratio(1.0, kappa=0.5)
    response = simulate(system, 0.8, Reference("derived"), periods=50, keep=10)
    assert response.ok


def test_undamped_resonance_is_no_exception():
    """Impacts at e = 0.5 take more than the resonance brings; no formula divides by what vanishes there."""
    response = simulate(System(d1=0.0, d2=0.0, d3=0.0), 1.0, Reference("derived"), periods=500)
    assert response.ok
    assert abs(response.section).max() < 100


def test_objects_are_frozen():
    for item in (System(), Reference(), Newmark(100, 8, 100)):
        with pytest.raises(dataclasses.FrozenInstanceError):
            item.name = "other"
