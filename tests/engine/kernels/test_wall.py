"""What kernels compute in another way at a wall: the excitation after a skip, and the way to most zeros and changes."""

import math
from dataclasses import replace

import numpy as np
import pytest
from vibroscope.engine import HHT, Bathe, Excitation, Newmark, NewmarkBeta, System, simulate
from vibroscope.engine.drivers.located import stages_of
from vibroscope.engine.drivers.parameters import parameters_of
from vibroscope.engine.drivers.skip_tables import LocatedTables
from vibroscope.engine.drivers.step_modes import Piece
from vibroscope.engine.kernels.accelerated.located_skip import FREE
from vibroscope.engine.kernels.accelerated.step_map import FEW_AT_WALL, SKIPPING, set_up_skipping, turn_after
from vibroscope.engine.kernels.compile.options import uncompiled
from vibroscope.engine.kernels.linear.first_root import two_steps
from vibroscope.engine.kernels.linear.tables import REACH, TERMS
from vibroscope.engine.kernels.parameters import AT_WALL, no_keys
from vibroscope.engine.kernels.time_stepping import contact_location
from vibroscope.engine.kernels.time_stepping.contact_location import (
    contact_force,
    forcing_at,
    side,
    step,
    with_accelerations,
)
from vibroscope.engine.kernels.time_stepping.located import located_scheme
from vibroscope.engine.kernels.time_stepping.wall_step import NOT_FOUND
from vibroscope.engine.methods import STEPS_RANGE


@pytest.mark.parametrize("n", [*STEPS_RANGE, 5, 2000, 2048, 99_991])
def test_the_excitation_after_any_step(n):
    packed = SKIPPING.zeros()
    row = np.array(parameters_of(System(wall=True), 1.08, Newmark(100.0, 1.0, n)))
    set_up_skipping(packed, no_keys(), row)
    scheme = SKIPPING.read(packed, AT_WALL)
    steps = np.unique(np.linspace(0, n - 1, 1000).astype(int))
    found = [uncompiled(turn_after)(scheme.tables.turns, scheme.shift, k) for k in steps.tolist()]
    angle = 2 * math.pi * (steps / n)
    np.testing.assert_allclose(found, np.column_stack([np.cos(angle), np.sin(angle)]), atol=1.5e-15)


def polynomial(root, order, rng):
    """(root − u)ᵒʳᵈᵉʳ q(u) as powers of u, and q, whose coefficients fall as those of a motion do."""
    sizes = np.cumprod(np.append(1.0, REACH / np.arange(1, TERMS - order)))
    q = np.append(1.0, rng.normal(size=TERMS - order - 1)) * sizes
    terms = q
    for _ in range(order):
        terms = np.convolve(terms, (root, -1.0))
    return terms, q


def test_two_steps_reach_a_zero_and_know_it():
    rng = np.random.default_rng(5)
    for _ in range(500):
        root = rng.uniform(0.02, 0.98)
        terms, q = polynomial(root, 1, rng)
        u, slope, arrived = two_steps(terms, root * (1 + 3e-3 * rng.uniform(-1, 1)))
        assert arrived
        assert u == pytest.approx(root, rel=1e-14)
        assert slope == pytest.approx(-np.polynomial.Polynomial(q)(u), rel=1e-13)


def test_two_steps_say_where_they_have_not_arrived():
    rng = np.random.default_rng(6)
    for _ in range(100):
        root = rng.uniform(0.1, 0.9)
        many, _ = polynomial(root, 3, rng)  # a threefold zero, to which a step goes half of the way
        assert not two_steps(many, root + 0.05)[2]
        beyond, _ = polynomial(1.0 + root, 1, rng)
        assert not two_steps(beyond, 0.99)[2]


def test_a_wall_is_hit_at_the_same_steps():
    """Skipped and plain steps of 120 settings: the change of contact in a stride, mostly without a search."""
    rng, contacts = np.random.default_rng(8), 0
    for _ in range(120):
        eta, n = rng.uniform(0.5, 4.0), int(np.exp(rng.uniform(math.log(200), math.log(32000))))
        method = Newmark(10 ** rng.uniform(1, 5), 10 ** rng.uniform(-1, 1), n)
        system = System(wall=True, d1=0.05, clearance=rng.uniform(-0.5, 1.0))
        plain, skipped = (
            simulate(system, eta, replace(method, every_step=every), periods=3, keep=3) for every in (True, False)
        )
        assert skipped.status == plain.status
        if not plain.ok:
            continue
        contacts += len(plain.contacts)
        np.testing.assert_allclose(skipped.contacts, plain.contacts, atol=1e-3 / n, err_msg=str((eta, method)))
        np.testing.assert_allclose(skipped.section, plain.section, atol=1e-7 * np.abs(plain.section).max())
    assert contacts > 400


@pytest.mark.parametrize("steps", [8, 40, 200, 3000])
def test_the_instant_of_a_change_is_that_of_the_secants(steps, monkeypatch):
    """In steps with one change of contact; where the instant is not certain the secants follow."""
    rng, found, exact = np.random.default_rng(steps), 0, uncompiled(contact_location.locate_change)
    system = System(wall=True, d1=0.05, clearance=0.2, excitation=Excitation(base=0.8, force1=1.1, force1_phase=0.7))
    for case in range(200):
        p = parameters_of(system, 1.3, Newmark(10 ** rng.uniform(1, 5), rng.uniform(0, 20), steps, located=True))
        m, pressed, k = located_scheme(p), bool(case % 2), int(rng.integers(steps))
        e, length = side(m, pressed), min(m.h, m.shortest_step) if pressed else m.h
        rate = rng.choice([-1.0, 1.0]) * rng.uniform(0.1, 3)
        gap = 0.0 if rate < 0.0 and pressed else -rate * length * rng.uniform(0, 1)
        z = with_accelerations(e, (0.0, 0.0, 0.0, gap, rate, 0.0), forcing_at(m, k, 0.0))
        end = step(e, z, length, forcing_at(m, k, length))
        if (end[3] <= 0.0) == pressed or (gap <= 0.0) != pressed:
            continue
        theta, motion, solves = exact(m, pressed, z, end, length, k, 0.0)
        found += solves == 1
        with monkeypatch.context() as secants:
            secants.setattr(contact_location, "change_at_wall", lambda *_: (NOT_FOUND, (0.0, 0.0, 0.0)))
            other, there, _ = exact(m, pressed, z, end, length, k, 0.0)
        assert theta == pytest.approx(other, abs=1e-12 * length)
        np.testing.assert_allclose(motion, there, rtol=1e-9, atol=1e-11 * max(1.0, abs(z[5])))
        again = step(e, z, theta, forcing_at(m, k, theta))
        assert abs(again[3]) <= 1e-13 * max(abs(gap), abs(rate) * length)
    assert found >= (60 if steps >= 200 else 1)


@pytest.mark.parametrize("integrator", [None, HHT(), Bathe()], ids=repr)
def test_tables_at_a_wall_are_those_of_two_bodies(integrator):
    """Of which the first does not move: the same values of what is watched, and the same motions."""
    system = System(wall=True, d1=0.05, clearance=0.2, excitation=Excitation(base=0.8, constant1=0.3))
    method, kind = Newmark(700.0, 6.0, 400, located=True), integrator or NewmarkBeta()
    p = parameters_of(system, 1.3, method)
    m = located_scheme(p)
    if integrator:
        m = m._replace(stages=stages_of(kind, p), shortest_step=m.h)
    one, two = (LocatedTables(each, p, kind, [Piece(700.0, 6.0)]) for each in (m, m._replace(wall=False)))
    for made in (one, two):
        made.make_asked()
    few, many = one.arrays, two.arrays
    np.testing.assert_array_equal(few.counts, many.counts)
    np.testing.assert_array_equal(few.strides, many.strides)
    modes = np.flatnonzero(few.counts == 1)
    assert modes[0] == FREE
    assert len(modes) > 1
    rng = np.random.default_rng(3)
    for mode, pressed in ((mode, mode != FREE) for mode in modes):
        u = np.append(rng.normal(size=5), 1.0)
        whole = np.zeros(10)
        whole[[1, 3, 5, 7, 8, 9]] = u
        whole[6] = contact_force(m, pressed, (0.0, 0.0, 0.0, *u[:3]))
        for level in range(2 if few.strides[mode] else 1):
            close = {"rtol": 1e-9, "atol": 1e-9}
            np.testing.assert_allclose(u @ few.rows[mode, 0, level], whole @ many.rows[mode, 0, level], **close)
            after = np.einsum("eji,j->ei", few.columns[mode, level], u)
            expected = np.einsum("eji,j->ei", many.columns[mode, level], whole)[:, [1, 3, 5, 7, 8, 9]]
            np.testing.assert_allclose(after, expected, rtol=1e-8, atol=1e-8 * np.abs(expected).max())
            np.testing.assert_allclose(few.impulses[mode, level] @ u, many.impulses[mode, level] @ whole, **close)
    np.testing.assert_allclose(few.rates, many.rates[:, [1, 3, 5, 7, 8, 9]], rtol=1e-12, atol=1e-15)


@pytest.mark.parametrize(("eta", "stiffness", "damping", "n"), [(1.7, 12000, 18, 2000), (2.76, 12000, 0, 2000)])
def test_a_contact_is_seen_to_end_before_its_mode_leads_back(eta, stiffness, damping, n):
    packed = SKIPPING.zeros()
    row = np.array(parameters_of(System(wall=True), eta, Newmark(stiffness, damping, n)))
    set_up_skipping(packed, no_keys(), row)
    scheme = SKIPPING.read(packed, AT_WALL)
    touches = np.array([0.0, 0.0, -scheme.scheme.h, -scheme.scheme.h, 0.0, 0.0])  # with a closing speed of one
    signed_gaps = touches @ scheme.tables.signed_gaps[1, 0]
    assert signed_gaps[scheme.midst - 1] < 0.0 < signed_gaps[: scheme.midst // 2].min()
    assert scheme.midst <= FEW_AT_WALL
