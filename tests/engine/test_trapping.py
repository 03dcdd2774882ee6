"""Trapping regions: whatever starts in one comes to the cycle."""

import warnings
from dataclasses import replace

import numpy as np
import pytest
from vibroscope.engine import ExactPenalty, Excitation, Reference, System, simulate, steady
from vibroscope.engine.cells import Cells
from vibroscope.engine.drivers.batch import NO_TRAP, Traps, settle
from vibroscope.engine.motions.poincare_map import Return
from vibroscope.engine.motions.section import same_cycle
from vibroscope.engine.motions.steady import Contraction, FixedPoint
from vibroscope.engine.motions.trapping import trapping_regions

WALL = System(wall=True, clearance=1.0, restitution=0.7)
CASES = [
    (System(), 3.2, Reference(), None, 2),
    (System(), 3.2, Reference(), (-2.0, 3.0, 4.0, -8.0), 6),
    (System(), 2.76, Reference(), None, 1),
    (System(), 3.2, ExactPenalty(12000.0, 18.0), None, 2),
    (WALL, 2.2, Reference(), None, 1),
    (System(clearance=0.5), 3.2, ExactPenalty(3000.0, 9.0), None, None),
]


@pytest.mark.parametrize(("system", "eta", "method", "start", "period"), CASES)
def test_whatever_starts_in_a_region_comes_to_the_cycle(system, eta, method, start, period):
    """Points on the border of each region, run for long."""
    found = steady(system, eta, method, initial=start, max_period=64)
    assert found.periodic
    assert period in (None, found.period)
    regions = trapping_regions(system, eta, method, found)
    assert len(regions) == found.period
    rng, compared = np.random.default_rng(1), 0
    for region in regions:
        for unit in rng.standard_normal((6, 4)):
            state = region.centre + np.linalg.pinv(region.factor) @ (unit / np.linalg.norm(unit))
            if isinstance(method, Reference) and system.gap(state[0], state[2]) < 0:
                continue
            run = simulate(system, eta, method, periods=1500, keep=2 * found.period, initial=state)
            assert same_cycle(found.response.section, run.section, found.period)
            compared += 1
    assert compared >= 2 * len(regions)


@pytest.mark.parametrize("clearance", [-0.5, 0.0, 0.5])
@pytest.mark.parametrize("method", [Reference("derived"), ExactPenalty(3000.0, 9.0)])
def test_without_excitation_every_start_comes_to_rest(method, clearance):
    system = System(d1=0.05, d2=0.05, clearance=clearance, excitation=Excitation(base=0.0))
    (region,) = trapping_regions(system, 1.7, method, steady(system, 1.7, method, initial=system.rest))
    assert not region.factor.any()
    np.testing.assert_allclose(region.centre, steady(system, 1.7, method, initial=system.rest).state, atol=1e-12)
    for start in np.random.default_rng(2).normal(size=(6, 4)):
        start[2] = max(start[2], start[0] - clearance)
        end = simulate(system, 1.7, method, periods=150, keep=1, initial=start).section[-1]
        np.testing.assert_allclose(end, region.centre, atol=1e-3)


def test_what_has_no_damper_does_not_come_to_rest():
    damped = System(clearance=5.0, excitation=Excitation(base=0.0))
    found = steady(damped, 1.7, Reference())
    assert trapping_regions(damped, 1.7, Reference(), found)
    assert not trapping_regions(replace(damped, d1=0.0), 1.7, Reference(), found)
    pressed = System(clearance=-0.5, d3=0.0, excitation=Excitation(base=0.0))  # joined, they swing for ever
    found = steady(pressed, 1.7, Reference("derived"), initial=pressed.rest)
    assert not trapping_regions(pressed, 1.7, Reference("table"), found)
    assert trapping_regions(pressed, 1.7, Reference("derived"), found)


def test_regions_are_larger_than_rounding_and_hold_their_centre():
    found = steady(System(), 3.2, Reference())
    rows = np.roll(found.response.section, 1, axis=0)  # which begins at the end of the first period
    for region, row in zip(trapping_regions(System(), 3.2, Reference(), found), rows, strict=True):
        np.testing.assert_allclose(region.centre, row, atol=1e-9)
        assert 0.05 < 1 / np.linalg.norm(region.factor, 2) < 1.0


def test_another_sequence_of_events_breaks_the_condition():
    jacobian, origin = 0.5 * np.eye(4), np.zeros(4)
    orbit, norm = FixedPoint(1, origin, Return(origin, jacobian, 1, 0.0), 0), Contraction(0.75, np.eye(4))
    deviation = np.array([0.1, 0.0, 0.0, 0.0])
    for course, holds in ((1, True), (2, False)):
        returned = Return(jacobian @ deviation, jacobian, course, 0.0)
        assert norm.contracts(orbit, deviation, returned) is holds
    assert not norm.contracts(orbit, deviation, Return(deviation, jacobian, 1, 0.0))
    assert not norm.contracts(orbit, deviation, None)


def test_an_unstable_cycle_has_no_region():
    found = steady(System(), 1.7, Reference(), stable_only=False)
    assert found.periodic
    assert np.abs(found.multipliers).max() > 1
    assert trapping_regions(System(), 1.7, Reference(), found) == []


def test_bodies_in_permanent_contact_have_a_region_of_joined_states():
    """At η = 1.08 the section lies in permanent contact: gap and gap rate are zero."""
    found = steady(System(), 1.08, Reference())
    (region,) = trapping_regions(System(), 1.08, Reference(), found)
    x1, v1, x2, v2 = region.centre
    moved = region.factor @ (np.array([x1 + 1e-3, v1, x2 + 1e-3, v2]) - region.centre)
    parted = region.factor @ (np.array([x1, v1, x2 + 1e-3, v2]) - region.centre)
    assert np.linalg.norm(moved) < 1 < np.linalg.norm(parted)


def test_a_cell_ends_at_the_first_section_in_a_region():
    """The kernel against the section of one run, row by row."""
    system, eta, method = System(), 3.2, Reference()
    found = steady(system, eta, method)
    regions = trapping_regions(system, eta, method, found)
    traps = Traps(np.array([r.centre for r in regions]), np.array([r.factor for r in regions]))
    start = np.array([0.0, 0.0, 2.0, 1.0])
    section = simulate(system, eta, method, periods=400, keep=400, initial=start).section
    inside = np.array([[np.linalg.norm(r.factor @ (row - r.centre)) <= 1 for r in regions] for row in section])
    first = int(np.argmax(inside.any(axis=1)))
    cells = Cells(system, [eta], method, initial=start[None])
    one = settle(method, cells.parameters(), start[None], np.zeros(1), traps, 400, threads=1)
    assert (one.periods[0], one.known[0]) == (first + 1, int(np.argmax(inside[first])))
    np.testing.assert_allclose(one.end[0], section[first], rtol=0, atol=1e-9)
    short = settle(method, cells.parameters(), start[None], np.zeros(1), traps, first, threads=1)
    assert (short.periods[0], short.known[0]) == (first, NO_TRAP)
    np.testing.assert_allclose(short.end[0], section[first - 1], rtol=0, atol=1e-9)


def test_a_body_that_a_wall_holds_has_no_region_to_look_for():
    system, method = System(wall=True, d1=0.05, clearance=-60.0), Reference()
    with warnings.catch_warnings():
        warnings.simplefilter("error")  # of a division by the size of no deviation
        assert trapping_regions(system, 1.3, method, steady(system, 1.3, method)) == []
