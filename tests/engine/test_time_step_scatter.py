"""Newmark motions: scatter that the constant step causes, and motion that remains without a time step."""

import numpy as np
import pytest
from vibroscope.engine import ExactPenalty, Newmark, System, motion, simulate
from vibroscope.engine.drivers.parameters import parameters_of
from vibroscope.engine.kernels.time_stepping.newmark import scheme_of
from vibroscope.engine.motions.description import CellKind
from vibroscope.engine.motions.poincare_map import multipliers
from vibroscope.engine.motions.time_step_scatter import FINER, Limits, judge_bands

SYSTEM = System()
FREE, PRESSED = False, True


@pytest.mark.parametrize(("eta", "stiffness", "damping", "period"), [(2.76, 12000, 18, 1), (3.25, 12000, 18, 2)])
def test_a_band_that_shrinks_with_the_step_is_scatter(eta, stiffness, damping, period):
    found = motion(SYSTEM, eta, Newmark(stiffness, damping, 2000))
    assert (found.type, found.period) == ("periodic", period)
    assert found.step_noise == found.scatter > 0.02  # of ξ₂ alone
    assert "artefact of the time step" in found.reason
    assert found.bands[0] == (2000, found.step_noise)
    assert found.bands[-1][1] < 0.5 * found.step_noise
    limit = motion(SYSTEM, eta, ExactPenalty(stiffness, damping), initial=found.section[-1])
    np.testing.assert_allclose(found.multipliers, limit.multipliers, atol=1e-8)


def test_bands_are_judged_together_as_each_by_itself():
    """Every kind of limit, with bands that shrink, stay or are none, or lie about other points."""
    rng, rows = np.random.default_rng(2), 64
    kinds = np.array([CellKind.PERIODIC] * 4 + [CellKind.CHAOTIC, CellKind.QUASI_PERIODIC, CellKind.UNDECIDED])
    periods = np.array([1, 2, 2, 1, 0, 0, 0])
    sections = np.tile([3.0, 1.0, -2.0, 0.5], (7, rows, 1)) + rng.normal(0, 0.01, (7, rows, 4))
    sections[1, ::2] += 1.0
    sections[3] = sections[3, :1]
    limits = Limits(kinds, periods, np.array([0.0, 0.7, 0.7, 0.0, 0.0, 0.0, 0.0]))
    asked = []

    def finer(places, factor):
        asked.append((places.tolist(), factor))
        share = np.where(kinds[places] == CellKind.PERIODIC, 1.2 / factor, 1.0)[:, None, None]
        middle = sections[places].reshape(len(places), rows // 2, 2, 4).mean(axis=1)
        middle = np.tile(middle, (1, rows // 2, 1))
        return middle + share * (sections[places] - middle), np.full(len(places), True)

    own, steps = np.array([0, 0, 0, 1, 0, 0, 0]), np.full(7, 500)
    together = judge_bands(sections, own, limits, steps, finer, FINER)
    assert asked == [([0, 1, 4, 5], 4), ([0, 1], 16)]
    artefact, undecided = CellKind.ARTEFACT, CellKind.UNDECIDED
    assert together.kinds.tolist() == [artefact, artefact, undecided, CellKind.PERIODIC, *kinds[4:]]
    assert together.periods.tolist() == [1, 2, 0, 1, 0, 0, 0]
    assert together.is_about_cycle.tolist() == [True, True, False, True, True, True, True]
    for i in range(7):
        some = Limits(*(each[i : i + 1] for each in limits))
        of_one = lambda _, factor, i=i: finer(np.array([i]), factor)  # noqa: E731
        alone = judge_bands(sections[i : i + 1], own[i : i + 1], some, steps[:1], of_one, FINER)
        assert all(one[0] == many[i] for one, many in zip(alone, together, strict=True))


def test_the_rest_of_a_transient_is_no_scatter():
    """Nothing touches, and little damps: after 2,050 periods a twentieth of the free vibration is left."""
    found = motion(System(wall=True, clearance=1000.0, d1=0.0003), 1.3, Newmark(100, 5, 200))
    assert (found.type, found.period, found.step_noise, found.bands) == ("periodic", 1, 0, ())


def test_a_band_that_keeps_its_width_is_chaotic_motion():
    found = motion(SYSTEM, 1.70, Newmark(12000, 18, 2000))
    assert (found.type, found.step_noise) == ("chaotic", 0)
    assert 0.24 <= found.lyapunov <= 0.30
    widths = [width for _, width in found.bands]
    assert max(widths) < 1.5 * min(widths)


def test_a_section_that_repeats_itself_has_no_step_noise():
    fixed, located = Newmark(2500, 8, 2000), Newmark(2500, 8, 500, located=True)
    for method in (fixed, located):
        found = motion(SYSTEM, 1.08, method)
        assert (found.type, found.period, found.step_noise, found.bands) == ("periodic", 1, 0, ())


def test_the_exponent_of_the_discrete_map_does_not_separate_scatter_from_motion():
    """The map expands along a motion that is periodic, and contracts along a chaotic one."""
    assert exponent_of_map(2.76, Newmark(12000, 18, 2000)) > 0.1
    assert exponent_of_map(1.70, Newmark(12000, 18, 2000)) < 0


def test_multipliers_of_newmark_are_those_of_the_product_of_its_step_matrices():
    """Derivatives by differences against products of the matrices of steps with and without contact."""
    method = Newmark(2500, 8, 2000)
    run = simulate(SYSTEM, 1.08, method, periods=1200, keep=2)
    product = np.eye(4)
    for matrix in step_matrices(run):
        product = matrix @ product
    by_matrices = np.linalg.eigvals(product)
    found = multipliers(SYSTEM, 1.08, method, run.section[0], 1)
    np.testing.assert_allclose(np.sort(np.abs(found))[2:], np.sort(np.abs(by_matrices))[2:], rtol=1e-6)


def step_matrices(run, last=1):
    """Powers of the step matrices over the last periods, from contact change to contact change."""
    scheme, n = scheme_of(parameters_of(run.system, run.eta, run.method)), run.method.steps
    free, pressed = step_matrix(scheme, FREE), step_matrix(scheme, PRESSED)
    end = run.periods * n
    position = end - last * n
    for begin, stop in np.rint(run.contacts / scheme.h).astype(int):
        if stop <= position:
            continue
        begin, stop = max(begin, position), min(stop, end)
        yield np.linalg.matrix_power(free, begin - position)
        yield np.linalg.matrix_power(pressed, stop - begin)
        position = stop
    yield np.linalg.matrix_power(free, end - position)


def step_matrix(m, contact):
    """One step of Newmark on (p₁, Q₁, p₂, Q₂), as engine/kernels/time_stepping/newmark.py derives it."""
    a1, a2 = np.array([-m.stiffness1, -m.damping1, 0, 0]), np.array([0, 0, -m.stiffness2, -m.damping2])
    if contact:
        force = np.array([m.contact_p, m.contact_q, -m.contact_p, -m.contact_q]) + m.contact_a * (a1 - a2)
        a1, a2 = a1 - m.react1 * force, a2 + m.react2 * force
    q1, q2 = np.eye(4)[1] + a1, np.eye(4)[3] + a2
    return np.array([np.eye(4)[0] + q1, q1, np.eye(4)[2] + q2, q2])


def exponent_of_map(eta, method, periods=1000):
    run = simulate(SYSTEM, eta, method, periods=1000 + periods, keep=periods)
    v, growth = np.full(4, 0.5), 0.0
    for matrix in step_matrices(run, periods):
        v = matrix @ v
        growth += np.log(np.linalg.norm(v))
        v /= np.linalg.norm(v)
    return growth / periods
