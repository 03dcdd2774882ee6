"""Other people's numbers under pulses and records."""

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from vibroscope.engine import (
    ExactPenalty,
    Load,
    Newmark,
    Reference,
    System,
    Units,
    parse_record,
    read_record,
    shock_response,
    transient,
)

from tests import naive_load

EL_CENTRO = Path(__file__).parents[1] / "data/published/el_centro_1940.csv"
INCH, GRAVITY = 25.4, 9.80665


@pytest.mark.parametrize(
    ("period", "damping", "inches"), [(0.5, 0.02, 2.67), (1.0, 0.02, 5.97), (2.0, 0.02, 7.47), (2.0, 0.05, 5.37)]
)
def test_el_centro_moves_oscillators_as_far_as_chopra_prints(period, damping, inches):
    """Chopra, Dynamics of Structures, figure 6.4.1: largest displacement, to the three digits that it has."""
    units = Units(omega1=2 * math.pi / period, base_amplitude=INCH)
    body = System(wall=True, d1=damping, clearance=1e3)
    record = read_record(EL_CENTRO, units)
    found = transient(body, record, Reference())
    sampled = found.response.trajectory
    at_samples = np.interp(record.segments[:, 0], sampled.time, sampled.displacement[0])  # as the book has it
    assert np.abs(at_samples).max() == pytest.approx(inches, abs=0.0051)
    assert found.peaks["displacement1"] == pytest.approx(inches, rel=0.01)
    stepped = transient(body, record, Newmark(100.0, 1.0, 400))
    assert stepped.peaks["displacement1"] == pytest.approx(found.peaks["displacement1"], rel=1e-3)


def test_a_light_building_that_pounds_against_a_heavy_one_alone_moves_otherwise():
    """Jankowski, Eng. Struct. 30 (2008) 2818: under El Centro the heavy and stiff building hardly notices.

    Periods 1.2 and 0.3 s, 25 and 1000 t, 5 % of critical damping, 20 mm apart, 9.35e7 N/m and e = 0.65. The paper draws
    curves and prints no numbers; these are compared with the plain twin. In millimetres.
    """
    units = Units(omega1=2 * math.pi / 1.2, base_amplitude=1.0)
    record = read_record(EL_CENTRO, units)
    buildings = System(mu=40.0, kappa=4.0, d1=0.05, d2=0.05, clearance=20.0, restitution=0.65)
    penalty = ExactPenalty(9.35e7 / (25e3 * units.omega1**2), 0.4103e6 / (2 * 25e3 * units.omega1))
    apart = transient(replace(buildings, clearance=1e4), record, penalty).peaks
    found = {method.name: transient(buildings, record, method, free=1.0) for method in (Reference(), penalty)}
    for each in found.values():
        assert each.peaks["displacement1"] > 1.1 * apart["displacement1"]
        assert each.peaks["displacement2"] == pytest.approx(apart["displacement2"], rel=1e-3)
    response = found[penalty.name].response
    events, end = naive_load.run(buildings, record, penalty, record.end + 1.0)
    touched = [time for time, kind in events if kind == 0]
    assert len(touched) > 20
    np.testing.assert_allclose(response.contacts[:, 0], touched, atol=1e-8)
    np.testing.assert_allclose(response.section[-1], end, atol=1e-8)


def test_the_undamped_response_to_a_half_sine_is_that_of_the_textbooks():
    """Harris and Piersol, chapter 8: the spectrum of a half-sine has 1.7685 as its maximum, at 2 tᵈ/T = 1.62."""
    ratios = np.linspace(0.7, 0.92, 45)  # of tᵈ/T
    found = shock_response(
        System(wall=True, d1=0.0, clearance=1e3), Load.half_sine(-1.0, 2 * math.pi), ratios, ExactPenalty(100.0, 0.0)
    )
    best = int(np.argmax(found.acceleration_without))
    assert found.acceleration_without[best] == pytest.approx(1.7685, abs=2e-4)
    assert 2 * ratios[best] == pytest.approx(1.62, abs=0.02)


def test_a_package_is_dropped_as_mindlin_computes_it():
    """Mindlin, Dynamics of package cushioning (1945): d = W/k (1 + √(1 + 2hk/W)), and a deceleration √(1 + 2hk/W) g.

    The drop is the step of the weight on a body at the height h above its cushion: a force that begins at once.
    """
    height, weight, stiffness = 10.0, 1.0, 100.0
    body = System(wall=True, spring1=0.0, d1=0.0, clearance=0.0)
    drop = Load.trapezoid(weight, 12.0, 0.0, on="force1")
    found = transient(body, drop, ExactPenalty(stiffness, 0.0), free=0.0, initial=(-height, 0.0, 0.0, 0.0))
    root = math.sqrt(1 + 2 * height * stiffness / weight)
    assert found.peaks["penetration"] == pytest.approx(weight / stiffness * (1 + root), rel=1e-6)
    assert found.peaks["contact_force"] - weight == pytest.approx(root * weight, rel=1e-3)


def test_a_strong_motion_file_of_peer_is_read():
    text = "PEER\nEVENT, STATION\nACCELERATION IN UNITS OF G\nNPTS=   5, DT=   .0200 SEC,\n 0. .1 -.2\n .1 0.\n"
    load = parse_record(text.encode(), Units(omega1=10.0, base_amplitude=1000 * GRAVITY / 100))  # in which 1 g is 1
    assert load.at(np.array([0.0, 0.2, 0.4, 0.5, 0.6])) == pytest.approx([0.0, 0.1, -0.2, -0.05, 0.1])
    with pytest.raises(ValueError, match="NPTS is 5, and 4 numbers follow"):
        parse_record(text.replace(" 0. .1", " .1").encode())


@pytest.mark.parametrize(("begin", "values"), [(1, [0.0, 2.0, 0.0]), (-1, [2.0, 2.0, 0.0])])
def test_a_record_that_begins_late_waits_and_one_that_begins_before_zero_is_moved_there(begin, values):
    load = parse_record(f"time [-], a [-]\n{begin}, 2\n{begin + 2}, 2\n".encode())
    assert load.at([0.5, 1.5, 3.5]).tolist() == values


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("time [s], b [x]\n0, 1\n1, 2\n", "has no unit of acceleration"),
        ("time [s], a, b\n0, 1, 2\n1, 2, 3\n", "mixes columns"),
        ("time, c, d\n0, 1, 2\n1, 2, 3\n", "one named a"),
        ("time [s], a [g]\n0, 1\nx, 2, 3\n2, 1\n", "line 3"),
        ("time [s], a [g]\n0, 1\n", "after 1 sample; give at least 2"),
        ("time [s], a [g]\n0, 0\n2, 1\n1, 3\n", "line 4: '1, 3' goes back in time; sort the lines"),
        ("time [s], a [g]\n0, 0\n2, 1e300\n3, 3\n", "line 3: '2, 1e300' is out of range"),
        ("time [s], f [N]\n0, 0\n2, 1\n", r"no unit of acceleration; give \[m/s2\] or \[g\]"),
    ],
)
def test_a_file_that_is_no_record_is_refused_in_words(text, words):
    with pytest.raises(ValueError, match=words):
        parse_record(text.encode())
