"""Poincaré sections: their period, their band, and whether they are regular."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from vibroscope.engine.drivers.section import TOLERANCE, period_of, sizes_of
from vibroscope.engine.kernels.section_statistics import near_period_of
from vibroscope.engine.motions.section import (
    band_width,
    band_widths,
    cycle_spreads,
    irregularity,
    rotation_number,
    settled_period,
    settled_periods,
)

from tests.share import share


@settings(max_examples=share(60))
@given(st.integers(1, 9), st.integers(2, 6), st.integers(0, 2**32 - 1))
def test_the_period_of_a_section_is_the_shortest_possible(period, cycles, seed):
    cycle = np.random.default_rng(seed).normal(size=(period, 4))
    assert period_of(np.tile(cycle, (cycles, 1))) == period
    assert band_width(np.tile(cycle, (cycles, 1)), period) < 1e-15
    blurred = np.tile(cycle, (cycles, 1))
    blurred[-1, 2] += 100 * TOLERANCE * np.abs(cycle).max()
    assert period_of(blurred) != period


@settings(max_examples=share(40))
@given(st.integers(2, 5), st.floats(1e3, 1e6), st.integers(0, 2**32 - 1))
def test_a_constant_displacement_hides_no_motion(period, afar, seed):
    """In shares of where the bodies are held, points that are a share of an amplitude apart would be the same."""
    near = np.tile(np.random.default_rng(seed).normal(size=(period, 4)), (9, 1))
    held = near + np.array([afar, 0, -afar, 0])
    assert period_of(held, 1e-3) == period
    assert sizes_of(held[None])[0] == pytest.approx(10.0)


def test_bands_of_many_sections_are_those_of_each():
    """Scatter about the points of a cycle, and the distances between its points; of ξ₁ and ξ₂ together."""
    rng, periods = np.random.default_rng(5), np.array([1, 3, 1, 4, 3])
    sections = rng.normal(size=(5, 25, 4))
    widths, spreads = band_widths(sections, periods), cycle_spreads(sections, periods)
    for section, period, width, spread in zip(sections, periods, widths, spreads, strict=True):
        points = section[25 % period :, [0, 2]].reshape(-1, period, 2)
        about = points - points.mean(axis=0)
        assert np.isclose(width, np.sqrt((about**2).sum(axis=2).mean()), rtol=1e-14)
        assert np.isclose(spread, np.sqrt(points.mean(axis=0).var(axis=0).sum()), rtol=1e-14)
        assert width == band_width(section, period)


def test_a_section_with_scatter_nearly_repeats():
    rng = np.random.default_rng(3)
    cycle = np.tile([[5.0, 1, -5, 1], [4.0, -1, 4, 2]], (20, 1))
    assert near_period_of(cycle + rng.normal(0, 0.02, cycle.shape), len(cycle)) == 2
    assert near_period_of(rng.normal(0, 5, cycle.shape), len(cycle)) == 0


@pytest.mark.parametrize("turns", [np.sqrt(2) - 1, (np.sqrt(5) - 1) / 2 - 0.2, np.sqrt(3) / 5, 1 / np.pi])
def test_regular_sections_are_distinguished_from_random_ones(turns):
    """A closed curve, a torus of two tubes, a torus of two frequencies, and random points."""
    n, golden = np.arange(8192), (np.sqrt(5) - 1) / 2
    angle, other = 2 * np.pi * turns * n, 2 * np.pi * golden * n
    curve = np.transpose([np.cos(angle), np.sin(angle), np.cos(angle + 0.3), np.exp(np.sin(angle))])
    tubes = curve + np.where(n % 2, 5.0, -5.0)[:, None]
    torus = curve + 0.1 * np.cos(other)[:, None]
    for section in (curve, tubes, torus):
        assert irregularity(section) < 1e-6
        assert rotation_number(section) == pytest.approx(turns, abs=1e-5)
    assert irregularity(np.random.default_rng(1).normal(size=(8192, 4))) > 1e-3


@pytest.mark.parametrize("of_cycle", [1, 2, 3])
def test_the_rest_of_a_transient_is_no_period(of_cycle):
    """It turns once in six periods, and has nearly died away."""
    rng, n = np.random.default_rng(of_cycle), np.arange(256)
    cycle = rng.normal(size=(of_cycle, 4))[n % of_cycle]
    turn = np.exp((-0.004 + 2j * np.pi / 6) * n)[:, None] * rng.normal(size=4)
    transient = cycle + 3e-4 * turn.real
    assert period_of(transient) == 6
    assert settled_period(transient) == of_cycle
    assert settled_period(cycle) == of_cycle
    lasting = cycle + 3e-4 * (turn / np.abs(turn)).real
    assert settled_period(lasting) == 6
    assert settled_periods(np.array([transient, cycle, lasting])).tolist() == [of_cycle, of_cycle, 6]
