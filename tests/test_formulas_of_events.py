"""The formulas of chatter and of saltation matrices are what the event loop computes, read as in `test_formulas.py`."""

import re

import numpy as np
import pytest
from scipy.linalg import expm
from vibroscope.engine import Reference, System
from vibroscope.engine.drivers.event_driven import set_up
from vibroscope.engine.drivers.parameters import parameters_of
from vibroscope.engine.kernels.equations.motion import separated_generator
from vibroscope.engine.kernels.event_driven import events, saltation
from vibroscope.engine.kernels.linear.tables import POWERS

from tests.displayed import Matrix, compares, of_pages, sides, value

PAGES = of_pages()
SYSTEM, ETA = System(mu=0.7, kappa=1.8, d1=0.1, d2=0.2, clearance=0.1), 1.3
RANDOM = np.random.default_rng(22)
REFERENCE = set_up(SYSTEM, ETA, Reference()).views
PARAMETERS = parameters_of(SYSTEM, ETA, Reference())


def states(count, size):
    """Random states whose last two numbers are a cosine and a sine."""
    turn = RANDOM.uniform(0, 6, count)
    return np.column_stack([RANDOM.uniform(-2, 2, (count, size - 2)), np.cos(turn), np.sin(turn)])


def chatter_symbols(z, r):
    """What (36) to (42) are written with, of a common motion z that parts at the rate r."""
    a, jerk = events.gap_acceleration_and_jerk(REFERENCE.flight, z, REFERENCE.scratch)
    c1, c2 = 2 * SYSTEM.d1, 2 * SYSTEM.d2 * SYSTEM.kappa
    symbols = {"c₁": c1, "c₂": c2, "μ̂": SYSTEM.mass_share, "r": r, "e": SYSTEM.restitution, "a_g": a, "g‴": jerk}
    symbols["γ"] = value(sides(PAGES[36], 1)[1], symbols)
    return symbols | {"J_g": jerk - symbols["γ"] * a}


def without_order(formula):
    """A series as far as it is written."""
    return re.sub(r" \+ (…|O\(r³\)\.?)", "", formula)


def common_motions(count):
    """Of the free motion z, relative to its equilibrium, bodies that touch without speed and press."""
    gap = -PARAMETERS.free_gap
    found = [np.array([x, v, gap, 0.0, c, s]) for x, v, _, _, c, s in states(30 * count, 6)]
    pressing = [z for z in found if events.gap_acceleration_and_jerk(REFERENCE.flight, z, REFERENCE.scratch)[0] > 0.2]
    return pressing[:count]


@compares(36, 37)
def test_the_flights_of_a_chatter():
    """The gap by the free equations, with the common motion, to the order that is written."""
    generator = np.zeros((6, 6))
    generator[:4] = separated_generator(PARAMETERS)[:, :6]
    generator[4, 5], generator[5, 4] = -ETA, ETA
    for z in common_motions(3):
        symbols, misses = chatter_symbols(z, 0.0), []
        start = z.copy()
        for r in (1e-2, 1e-3):
            start[1], start[3] = z[1] - SYSTEM.mass_share * r, r  # the common motion is kept
            assert (generator @ start)[3] == pytest.approx(
                value(sides(PAGES[36])[1], symbols | {"t": 0.0, "g′": r}), rel=1e-9
            )
            t = value(without_order(sides(PAGES[37])[1]), symbols | {"r": r})
            later = expm(generator * t) @ start
            misses.append(abs(later[2] - z[2]))
        assert misses[1] < 2e-4 * misses[0]  # r times what an error of third order leaves: 1e-4 of it


@compares(38)
def test_the_length_of_a_chatter():
    for z in common_motions(5):
        r = 1e-3
        before = (z[0], z[1] - SYSTEM.mass_share * r, z[2], r, z[4], z[5])
        found, *_ = events.sum_up(REFERENCE.flight, before, SYSTEM.restitution, SYSTEM.mass_share, REFERENCE.scratch)
        assert value(without_order(sides(PAGES[38])[1]), chatter_symbols(z, r)) == pytest.approx(found, rel=1e-9)


def variation(time):
    """A random one."""
    found = saltation.make_variation()
    found.state[:] = RANDOM.uniform(-1, 1, (4, 4))
    found.time[:] = time
    return found


@compares(39, 40)
def test_the_change_along_an_event_and_the_saltation_matrix():
    flight = REFERENCE.flight
    for state in states(5, 6):
        before = np.array([state[0], state[1], -PARAMETERS.free_gap, -abs(state[3]), *state[4:]])
        d = variation(0.0)
        started = d.state.copy()
        saltation.meet_event(flight, d, before, before[3])
        w, slope, y = flight.rows[:4, POWERS], before[3], saltation.slope_of(flight, before)
        for k in range(4):
            numbers = {"w": 1.0, "δ": float(w @ started[:, k]), "f′": slope}
            dt = value(sides(PAGES[39])[1], numbers)
            assert dt == pytest.approx(d.time[k], rel=1e-12)
            for i in range(4):
                moved = value(sides(PAGES[39], 1)[1], {"δ": started[i, k], "y′": y[i], "dτ": dt})
                assert moved == pytest.approx(d.state[i, k], rel=1e-12)
        e, after = SYSTEM.restitution, before.copy()
        after[1] += (1 + e) * SYSTEM.mass_share * before[3]
        after[3] = -e * before[3]
        d.state[1] += (1 + e) * SYSTEM.mass_share * d.state[3]
        d.state[3] *= -e
        saltation.leave_event(flight, d, after)
        reset = np.diag([1.0, 1.0, 1.0, -e])
        reset[1, 3] = (1 + e) * SYSTEM.mass_share
        columns = {
            "y′⁻": Matrix(np.reshape(y, (4, 1))),
            "y′⁺": Matrix(np.reshape(saltation.slope_of(flight, after), (4, 1))),
        }
        columns |= {"R": Matrix(reset), "wᵀ": Matrix(w[None]), "f′": slope, "δ⁻": Matrix(started)}
        np.testing.assert_allclose(value(sides(PAGES[40])[1], columns).rows, d.state, rtol=1e-11, atol=1e-12)


@compares(41, 42)
def test_the_lengthening_of_a_chatter():
    for z in common_motions(5):
        d, parting, out, r = variation(RANDOM.uniform(-1, 1, 4)), RANDOM.uniform(-1, 1, 4), np.zeros(4), 1e-2
        saltation.chatter_lengthening(REFERENCE, d, z, r, parting, out)
        symbols = chatter_symbols(z, r)
        length, *_ = events.sum_up(
            REFERENCE.flight,
            (z[0], z[1] - SYSTEM.mass_share * r, z[2], r, z[4], z[5]),
            SYSTEM.restitution,
            SYSTEM.mass_share,
            REFERENCE.scratch,
        )
        curve = 2 * symbols["g‴"] / (3 * symbols["a_g"] ** 2) - symbols["γ"] / symbols["a_g"]
        for k in range(4):
            # the common motion at the event is moved by δ_e, and the excitation by the time of the event
            moved = np.array([*d.state[:, k], -ETA * z[5] * d.time[k], ETA * z[4] * d.time[k]])
            da, dj = events.gap_acceleration_and_jerk(REFERENCE.flight, moved, REFERENCE.scratch)
            own = symbols | {"da_g": da, "dg‴": dj, "dr": parting[k], "B_c": curve, "t∞": length}
            own["dB_c"] = value(sides(PAGES[42])[1], own)
            assert value(sides(PAGES[41])[1], own) == pytest.approx(out[k], rel=1e-9, abs=1e-12)
