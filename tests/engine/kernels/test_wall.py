"""What kernels compute in another way at a wall: the excitation after a skip, and the way to most zeros."""

import math
from dataclasses import replace

import numpy as np
import pytest
from vibroscope.engine import Newmark, System, simulate
from vibroscope.engine.drivers.parameters import parameters_of
from vibroscope.engine.kernels.accelerated.step_map import SKIPPING, set_up_skipping, turn_after
from vibroscope.engine.kernels.compile.options import uncompiled
from vibroscope.engine.kernels.linear.first_root import two_steps
from vibroscope.engine.kernels.linear.tables import REACH, TERMS
from vibroscope.engine.kernels.parameters import AT_WALL, no_keys
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
