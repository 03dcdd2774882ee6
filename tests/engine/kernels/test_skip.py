"""Newmark with skipped steps is the plain loop's solution: the same contact changes, at the same steps."""

import math
from itertools import pairwise

import numpy as np
import pytest
from vibroscope.engine import Newmark, Record, Status, System, simulate
from vibroscope.engine.drivers.parameters import parameters_of
from vibroscope.engine.kernels.accelerated.certificate import SKIP_ON, TAKE_STEP, single_steps
from vibroscope.engine.kernels.accelerated.step_map import (
    ENTRIES,
    FREE,
    PRESSED,
    TABLES,
    choose_strides,
    fill_tables,
    step_map,
)
from vibroscope.engine.kernels.time_stepping.newmark import scheme_of

from tests.share import share

SETTINGS = [
    (1.08, 2500.0, 8.0, 2000),
    (1.08, 100.0, 50.0, 2000),
    (2.76, 12000.0, 18.0, 2000),
    (2.76, 12000.0, 18.0, 8000),
    (3.25, 12000.0, 18.0, 8000),
    (1.70, 12000.0, 18.0, 2000),
    (1.08, 1e5, 100.0, 32000),
    (0.50, 10.0, 0.1, 1000),
    (4.00, 1e4, 10.0, 1013),
    (2.76, 1e5, 1e4, 1500),
]


def both(eta, stiffness, damping, n, periods, system=System(), **options):  # noqa: B008 - frozen
    """The same run with every step taken, and with steps skipped."""
    return (
        simulate(system, eta, Newmark(stiffness, damping, n, every_step=every), periods=periods, **options)
        for every in (True, False)
    )


def scheme(eta, method):
    """Coefficients of one step of the default system."""
    return scheme_of(parameters_of(System(), eta, method))


def steps_of(response):
    """The steps at which contacts begin and end."""
    return np.rint(response.contacts * response.method.steps * response.eta / (2 * math.pi)).astype(int)


@pytest.mark.parametrize(("eta", "stiffness", "damping", "n"), SETTINGS)
def test_the_same_steps(eta, stiffness, damping, n):
    plain, skipped = both(eta, stiffness, damping, n, 10, keep=10, record=Record(2, 500))
    np.testing.assert_array_equal(steps_of(skipped), steps_of(plain))
    scale = np.abs(plain.section).max()
    np.testing.assert_allclose(skipped.section, plain.section, atol=1e-8 * scale)
    for name in ("time", "position", "velocity_before", "velocity_after", "impulse", "closing_speed"):
        one, other = getattr(plain.impacts, name), getattr(skipped.impacts, name)
        np.testing.assert_allclose(other, one, atol=1e-7 * max(1, np.abs(one).max()))
    for name in ("time", "displacement", "velocity", "force"):
        one, other = getattr(plain.trajectory, name), getattr(skipped.trajectory, name)
        np.testing.assert_allclose(other, one, atol=1e-7 * max(1, np.abs(one).max()))


BETWEEN_STOPS = System(clearance=0.4, clearance2=1.1, stiffness_factor2=2.0, damping_factor2=0.5)
BETWEEN_WALLS = System(wall=True, spring1=0.0, d1=0.02, clearance=0.6, clearance2=0.6)


@pytest.mark.parametrize("system", [System(), BETWEEN_STOPS, BETWEEN_WALLS], ids=["one", "two", "walls"])
def test_the_same_steps_wherever_rounding_does_not_decide(system):
    """Settings drawn over the whole range of the explorer and more, three periods each.

    Many bounces in a period multiply a rounding error by up to 1e9. The plain loop shows how much, started 1e-11
    beside rest: skipping may not differ from it by more than that, nor by any contact step where it does not.
    """
    rng, compared, phases = np.random.default_rng(20), 0, 0
    for _ in range(share(330)):
        eta, n = rng.uniform(0.5, 4.0), int(np.exp(rng.uniform(math.log(200), math.log(64000))))
        numbers = eta, 10 ** rng.uniform(1, 5), 10 ** rng.uniform(-1, 2), n
        plain, skipped = both(*numbers, 3, system, keep=3)
        nudged, _ = both(*numbers, 3, system, keep=3, initial=(-1e-11, 0, 0, 0))
        assert skipped.status == plain.status
        if not (plain.ok and nudged.ok):  # a run that diverges magnifies rounding beyond any bound
            continue
        sensitivity = np.abs(plain.section - nudged.section).max()
        if sensitivity > 1e-4:
            continue
        compared += 1
        phases += plain.contacts.size
        np.testing.assert_array_equal(steps_of(skipped), steps_of(plain), err_msg=str(numbers))
        assert np.abs(plain.section - skipped.section).max() < 1e-9 + 10 * sensitivity, numbers
    assert compared > share(250)
    assert phases > share(2000)


def tables_of(m, eta, free_rate, pressed_rate):
    """Tables of both contact states, their steps' maps, and the rows that give the signed gap at a step itself."""
    tables = TABLES.read(TABLES.zeros())
    maps = step_map(m, eta, False), step_map(m, eta, True)
    for state, rate in ((FREE, free_rate), (PRESSED, pressed_rate)):
        fill_tables(tables, m, eta, state, rate)
    here = [sign * one.gap @ np.linalg.inv(one.matrix) for sign, one in zip((1, -1), maps, strict=True)]
    return tables, maps, here


LEVELS = [(FREE, 2000, 1), (PRESSED, 2000, 1), (PRESSED, 100_000, 1), (FREE, 100_000, 1), (FREE, 100_000, 2)]


@pytest.mark.parametrize(("state", "n", "level"), LEVELS)
def test_no_second_difference_exceeds_the_bound_of_its_level(state, n, level):
    eta, method = 1.08, Newmark(2500.0, 8.0, n)
    tables, maps, _ = tables_of(scheme(eta, method), eta, 2.41, 90.0)
    stride = int(tables.strides[state, level])
    assert stride > 1
    change = maps[state].matrix - np.eye(6)
    row, largest = maps[state].gap @ change @ change, np.zeros(6)
    for _ in range(ENTRIES * stride):
        largest = np.maximum(largest, np.abs(row))
        row = row @ maps[state].matrix
    bound = tables.curvatures[state, level] * 8 / stride**2
    assert (bound >= largest * (1 - 1e-9)).all()
    assert (
        bound < 3 * largest + 1e-12 * largest.max()
    ).all()  # far too wide would send every flight through single steps


@pytest.mark.parametrize("longest", [0, 1, 2, 100, 500, 513, 5000, 10**6])
def test_every_step_is_an_entry_of_each_level_away(longest):
    """So what lies within a skip can be read off."""
    first, second = choose_strides(longest)
    strides = [1, *(stride for stride in (first, second) if stride > 0)]
    for below, above in pairwise(strides):
        assert below < above <= ENTRIES * below
        assert above % below == 0
    assert strides[-1] <= max(1, longest)


def test_a_run_diverges_at_the_same_step():
    plain, skipped = both(2.76, 1e7, 1.0, 1000, 40, keep=1)
    assert plain.status is skipped.status is Status.DIVERGED
    assert plain.cost.steps == skipped.cost.steps
    assert plain.message == skipped.message


def test_the_discrete_flight_is_newmarks():
    """Without contact the closed form and the loop agree over many periods, at any step."""
    for n in (1000, 3000):
        plain, skipped = both(0.7, 10, 0.1, n, 21, keep=21, initial=(0.0, 0.0, 500.0, 0.0))
        np.testing.assert_allclose(skipped.section, plain.section, rtol=1e-9, atol=1e-9)


@pytest.mark.parametrize(("depth", "outcome"), [(1e-9, SKIP_ON), (1e-14, TAKE_STEP), (-1e-14, TAKE_STEP)])
def test_a_graze_within_rounding_is_left_to_the_plain_step(depth, outcome):
    eta, j = 1.08, 50
    tables, _, _ = tables_of(scheme(eta, Newmark(2500.0, 8.0, 2000)), eta, 2.41, 90.0)
    gaps = tables.signed_gaps[FREE, 0].T
    # of p₂ − p₁ and Q₂ − Q₁, so that the gap has its minimum, ``depth``, after j steps
    conditions = np.array([gaps[j - 1], gaps[j] - gaps[j - 2]])
    for p1 in (1.0, -1.0):
        z = np.array([p1, 0.0, *np.linalg.solve(conditions[:, 2:4], (depth, 0.0) - conditions[:, 0] * p1), 0.0, 0.0])
        if (gaps @ z)[0] > 0:
            break
    assert np.argmin(gaps @ z) == j - 1
    steps, found, _, _ = single_steps(tables, FREE, tuple(z), 1.0, math.inf)
    assert (steps, found) == ((ENTRIES, SKIP_ON) if outcome == SKIP_ON else (j - 2, TAKE_STEP))
