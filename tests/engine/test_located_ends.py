"""Newmark with located contact changes always ends: random settings, extremes, and its bound on the cost."""

import math

import numpy as np
import pytest
from vibroscope.engine import Excitation, Newmark, Record, Status, System, simulate
from vibroscope.engine.kernels.compile.options import uncompiled
from vibroscope.engine.kernels.time_stepping import located as kernel

from tests.engine.test_located import run, scheme
from tests.share import every


def test_300_settings_end_and_make_sense():
    """K from 1 to 1e9, D from 0 to 1e6, T/20 to T/2000: contact is where the gap is not positive, and nowhere else."""
    rng = np.random.default_rng(7)
    for _ in range(300):
        eta, n = rng.uniform(0.3, 4.0), int(np.exp(rng.uniform(math.log(20), math.log(2000))))
        stiffness = 10 ** rng.uniform(0, 9)
        damping = rng.choice([0.0, 10 ** rng.uniform(-3, 6)])
        start = (0, 0, 0, 0) if rng.random() < 0.5 else tuple(rng.uniform(-3, 3, 4))
        numbers = eta, stiffness, damping, n, start
        response = run(eta, stiffness, damping, n, 5, record=Record(5, n), initial=start)
        assert response.status is Status.OK, numbers
        assert np.isfinite(response.section).all(), numbers
        edges = response.contacts.ravel()
        assert (np.diff(edges) >= 0).all(), numbers
        sampled = response.trajectory
        x1, x2 = sampled.displacement
        clear = np.abs(x2 - x1) > 1e-9 * max(1.0, np.abs(x1).max())  # else rounding of the samples decides
        clear[-1] = False  # there an open contact is noted as ended
        inside = np.searchsorted(edges, sampled.time, side="right") % 2 == 1
        np.testing.assert_array_equal(inside[clear], (x2 < x1)[clear], err_msg=str(numbers))
        assert (sampled.force[clear & ~inside] == 0).all(), numbers
        assert response.cost.steps < most_solves(response), numbers


def most_solves(response):
    """What the kernel's module says that a run costs: pieces are at least half as long as they may be."""
    m = scheme(response.eta, response.method)
    half = 1 / m.step_per_age  # N/2, the solves for half a cycle
    halves = np.diff(response.contacts).ravel() * m.step_per_age / m.shortest_step  # 2t/T_c
    solves = half * (np.minimum(halves, 1) + np.log(np.maximum(halves, 1))) + 40
    return 2 * response.periods * m.steps + 2 * solves.sum()


@pytest.mark.parametrize("eta", every([1.08, 2.76]))
def test_none_blows_up_where_the_plain_step_does(eta):
    blown = 0
    for stiffness in np.geomspace(100, 6e4, 12):
        for damping in np.geomspace(0.5, 100, 12):
            assert run(eta, stiffness, damping, 100, 200, keep=1).ok
            blown += not run(eta, stiffness, damping, 100, 200, located=False, keep=1).ok
    assert blown > 10


@pytest.mark.parametrize(
    ("eta", "stiffness", "damping", "n"),
    [
        (1.08, 1e9, 0.0, 200),
        (1.08, 1e9, 1e6, 200),
        (2.76, 1.0, 1e6, 200),
        (1.08, 1e12, 1e9, 50),
        (0.5, 2500.0, 8.0, 200_000),
        (1e3, 1e9, 10.0, 4),
        (0.01, 1e9, 0.0, 4),
        (1.0, 1e9, 2e4, 20),
    ],
)
def test_extremes_end(eta, stiffness, damping, n):
    response = run(eta, stiffness, damping, n, 3)
    assert response.ok
    assert np.isfinite(response.section).all()


def test_too_many_solves_in_one_step_have_a_status(monkeypatch):
    monkeypatch.setattr(kernel, "SOLVES_PER_STEP", 20)
    for name in ("advance", "integrate_located", "unpack_buffers"):  # a constant is compiled into the kernel
        monkeypatch.setattr(kernel, name, uncompiled(getattr(kernel, name)))
    found = simulate(System(), 0.001, Newmark(1e9, 0.0, 4, located=True), periods=5, keep=1)
    assert found.status is Status.UNRESOLVED
    assert "smaller K" in found.message


@pytest.mark.parametrize("steps", [20, 200])
@pytest.mark.parametrize("clearance", [-0.3, 0.0])
def test_pieces_at_a_wall_are_those_of_mirrored_bodies(steps, clearance):
    force = {"base": 0.0, "force1": 1.0}
    wall = System(wall=True, d1=0.01, clearance=clearance, excitation=Excitation(**force))
    both = Excitation(**force, force2=-1.0)
    both = System(1.0, 0.01, 0.01, mu=1.0, d3=None, clearance=2 * clearance, excitation=both)
    record = Record(periods=2, per_period=steps // 5)
    options = {"periods": 4, "keep": 4, "record": record}
    one = simulate(wall, 1.08, Newmark(2500.0, 8.0, steps, located=True), **options)
    two = simulate(both, 1.08, Newmark(1250.0, 4.0, steps, located=True), **options)
    assert one.cost.steps == pytest.approx(two.cost.steps, rel=0.02)  # where rounding decides it is one more
    assert len(one.impacts) == len(two.impacts) > 3
    np.testing.assert_allclose(one.contacts, two.contacts, atol=1e-8)
    np.testing.assert_allclose(one.impacts.impulse, two.impacts.impulse, rtol=1e-6)
    np.testing.assert_allclose(one.section[:, :2], two.section[:, :2], atol=1e-8)
    np.testing.assert_allclose(one.trajectory.displacement[0], two.trajectory.displacement[0], atol=1e-8)
