"""One-step methods that skip steps have the plain loop's solution: the same contact changes, at the same steps."""

import math
from dataclasses import replace

import numpy as np
import pytest
from vibroscope.engine import (
    CONTACT_LAWS,
    HHT,
    INTEGRATORS,
    Bathe,
    Excitation,
    HHTInterpolated,
    NewmarkBeta,
    Record,
    System,
    TimeStepping,
    simulate,
)
from vibroscope.engine.drivers.parameters import parameters_of
from vibroscope.engine.drivers.skip_tables import skip_tables
from vibroscope.engine.drivers.time_stepping import linear_scheme
from vibroscope.engine.kernels.accelerated.matrix_skip import AFTER_STEP
from vibroscope.engine.law_table import numbers_of

from tests.law_numbers import SKIPPED, law_numbers
from tests.share import every

IMPACTS = ("time", "position", "velocity_before", "velocity_after", "impulse", "closing_speed")
TRAJECTORY = ("time", "displacement", "velocity", "force")


def random_run(rng, kind, two_stops=False):
    """A system with or without a wall, clearance or preload and forces; η and a method."""
    wall = rng.random() < 0.4
    system = System(
        kappa=rng.uniform(0.5, 3),
        d1=rng.uniform(0, 0.2),
        d2=rng.uniform(0, 0.2),
        mu=None if wall else rng.uniform(0.2, 4),
        wall=wall,
        clearance=rng.choice([0.0, rng.uniform(-1, 1)]),
        excitation=Excitation(
            base=rng.uniform(0, 1),
            force1=rng.choice([0.0, rng.uniform(0, 1)]),
            force1_phase=rng.uniform(-3, 3),
            constant1=rng.choice([0.0, rng.uniform(-0.5, 0.5)]),
        ),
    )
    if two_stops:
        second = {"clearance2": rng.uniform(0.05, 1), "stiffness_factor2": rng.uniform(0.5, 2)}
        system = replace(system, clearance=rng.uniform(0.05, 1), **second)
    status = "start" if kind.explicit else rng.choice(["start", "end"])
    without, law = str(rng.choice(["stop", "keep", "halve"])), str(rng.choice(CONTACT_LAWS))
    steps = int(np.exp(rng.uniform(math.log(300), math.log(8_000))))
    contact = 10 ** rng.uniform(1, 4.5), 10 ** rng.uniform(-1, 2)
    draw = {"exponent": lambda: float(rng.choice([1.0, 1.5, 2.0])), "penetration": lambda: 10 ** rng.uniform(-4, -1)}
    draw["stiffening"] = lambda: rng.uniform(1.5, 10)
    numbers = {name: draw[name]() for name in numbers_of(law)}
    return system, rng.uniform(0.5, 4), TimeStepping(*contact, steps, kind(), str(status), without, law, **numbers)


def steps_of(response):
    """The steps at which contacts begin and end."""
    return np.rint(response.contacts * response.method.steps * response.eta / (2 * math.pi)).astype(int)


def counts_of(response):
    """How the run ended, and the steps that had no solution or two."""
    return response.status, response.steps_without_solution, response.steps_with_two, response.cost.steps


@pytest.mark.parametrize("two_stops", [False, True], ids=["one", "two"])
@pytest.mark.parametrize("kind", every(INTEGRATORS.values()), ids=every(INTEGRATORS))
def test_the_same_steps_wherever_rounding_does_not_decide(kind, two_stops):
    """The plain loop shows how much rounding grows, with a start that differs by 1e-11."""
    rng, compared, changes = np.random.default_rng(7), 0, 0
    for _ in range(18):
        system, eta, method = random_run(rng, kind, two_stops)
        plain = replace(method, every_step=True)
        options, start = {"periods": 3, "keep": 3}, np.array(system.rest)
        skipped = simulate(system, eta, method, **options)
        one, nudged = (
            simulate(system, eta, plain, initial=start + x, **options) for x in (0.0, np.array([1e-11, 0, 0, 0]))
        )
        if not (one.ok and counts_of(one) == counts_of(nudged)):
            continue
        sensitivity = np.abs(one.section - nudged.section).max()
        if sensitivity > 1e-5 or not np.array_equal(steps_of(one), steps_of(nudged)):
            continue
        compared, changes = compared + 1, changes + one.contacts.size
        assert counts_of(skipped) == counts_of(one), (system, eta, method)
        np.testing.assert_array_equal(steps_of(skipped), steps_of(one))
        assert np.abs(one.section - skipped.section).max() < 1e-9 + 10 * sensitivity
    assert compared > 10
    assert changes > 60


@pytest.mark.parametrize("law", every(CONTACT_LAWS))
def test_every_law_with_every_integrator_and_status(law):
    """A damped system, so that rounding does not grow; where a damper jumps at touch, some steps have no solution."""
    system, none, two = System(d1=0.3, d2=0.4, clearance=0.1), 0, 0
    numbers = law_numbers(law, 1.0 if law in ("constant-restitution", "hunt-crossley") else None, 1e-2)
    runs = [(kind(), status) for kind in INTEGRATORS.values() for status in ("start", "end")]
    for integrator, status in runs:
        if integrator.explicit and status == "end":
            continue
        steps = 4000 if integrator.explicit else 1000
        method = TimeStepping(400.0, 60.0, steps, integrator, status, "keep", law, **numbers)
        one, other = (
            simulate(system, 1.1, replace(method, every_step=each), periods=8, keep=8) for each in (True, False)
        )
        assert counts_of(other) == counts_of(one)
        np.testing.assert_array_equal(steps_of(other), steps_of(one))
        assert len(one.contacts) >= 8
        np.testing.assert_allclose(other.section, one.section, rtol=0, atol=1e-10)
        assert not np.array_equal(other.section, one.section)  # some steps were skipped
        none += one.steps_without_solution
        two += one.steps_with_two
    assert (two > 0) == (law in ("kelvin-voigt", "constant-restitution", "bilinear"))
    assert (none > 0) == (law in ("kelvin-voigt", "cut", "compression", "constant-restitution", "bilinear"))


@pytest.mark.parametrize(("integrator", "status", "law"), SKIPPED)
@pytest.mark.parametrize("system", [System(), System(wall=True, clearance=0.2)], ids=["two", "wall"])
def test_what_is_recorded(system, integrator, status, law):
    method = TimeStepping(2500.0, 8.0, 2000, integrator, status, "keep", law, **law_numbers(law))
    options = {"periods": 2, "keep": 2, "record": Record(1, 500)}
    one, other = (simulate(system, 1.08, replace(method, every_step=every), **options) for every in (True, False))
    np.testing.assert_array_equal(steps_of(other), steps_of(one))
    assert len(one.impacts) > 2
    np.testing.assert_allclose(other.section, one.section, rtol=0, atol=1e-7)
    pairs = [[getattr(run.impacts, name) for run in (one, other)] for name in IMPACTS]
    pairs += [[getattr(run.trajectory, name) for run in (one, other)] for name in TRAJECTORY]
    for plain, skipped in pairs:
        np.testing.assert_allclose(skipped, plain, rtol=0, atol=1e-6 * max(1, np.abs(plain).max()))


@pytest.mark.parametrize("without", ["stop", "keep", "halve"])
@pytest.mark.parametrize("law", ["kelvin-voigt", "cut"])
def test_steps_without_a_solution_and_with_two_are_those_of_the_plain_loop(law, without):
    options = {"periods": 20, "keep": 1}
    for integrator in (NewmarkBeta(), HHTInterpolated(), Bathe(0.5)):
        method = TimeStepping(2500.0, 8.0, 500, integrator, "end", without, law)
        one, other = (simulate(System(), 1.08, replace(method, every_step=e), **options) for e in (True, False))
        assert counts_of(one) == counts_of(other)
        assert one.message == other.message
        assert one.steps_without_solution > 0
        assert (one.steps_with_two > 0) == (law == "kelvin-voigt")


def test_an_unstable_method_diverges_at_the_same_step():
    method, options = TimeStepping(1e6, 18.0, 400, NewmarkBeta(0.1, 0.5)), {"periods": 9, "keep": 1}
    one, other = (simulate(System(), 2.76, replace(method, every_step=every), **options) for every in (True, False))
    assert one.status == other.status == "diverged"
    assert one.message == other.message


def test_a_coarse_step_is_taken_by_the_plain_loop():
    for steps, skipped in ((60, False), (2000, True)):
        method, options = TimeStepping(100.0, 5.0, steps, HHT(0.0)), {"periods": 5, "keep": 1}
        kept = simulate(System(), 1.7, method, **options).checkpoint
        taken = simulate(System(), 1.7, replace(method, every_step=True), **options).checkpoint
        assert (kept.state != taken.state) == skipped


def bound_and_differences(tables, mode, r):
    """The bound of a watched row's second differences, and the largest of them within the level, (COLUMNS,) each."""
    stride, step = int(tables.strides[mode]), tables.columns[mode, 0, 0].T
    row, change, largest = tables.firsts[mode, r, 0], step - np.eye(len(step)), 0.0
    row = row @ change @ change
    for _ in range(tables.columns.shape[2] * stride):
        largest, row = np.maximum(largest, np.abs(row)), row @ step
    return tables.bounds[mode, r] * 8 / stride**2, largest


@pytest.mark.parametrize(("integrator", "status", "law"), SKIPPED)
def test_no_second_difference_exceeds_its_bound(integrator, status, law):
    method = TimeStepping(2500.0, 8.0, 2000, integrator, status, law=law, **law_numbers(law))
    p = parameters_of(System(clearance=0.3), 1.08, method)
    tables = skip_tables(linear_scheme(p, method), p)
    modes = {"kelvin-voigt": 2, "cut": 3, "limited": 4, "compression": 3, "bilinear": 3}.get(law, 1)
    assert len(tables.counts) == modes
    assert (tables.counts > 0).all()
    for mode in range(modes):
        assert tables.strides[mode] > 1
        for r in range(tables.counts[mode]):
            bound, largest = bound_and_differences(tables, mode, r)
            np.testing.assert_allclose(bound, largest, rtol=1e-6, atol=1e-9 * largest.max())


STATUSES = [(name, status) for name, kind in INTEGRATORS.items() for status in ("start", "end")[: 2 - kind.explicit]]


@pytest.mark.parametrize("law", ["kelvin-voigt", "cut", "limited", "compression", "bilinear"])
@pytest.mark.parametrize(("integrator", "status"), STATUSES)
def test_at_most_one_mode_takes_a_step(integrator, status, law):
    """Most states have one, whatever the gap and its rate are; the order in which modes are tried decides nothing."""
    kind = INTEGRATORS[integrator]
    method = TimeStepping(2500.0, 8.0, 2000, kind(), status, law=law, **law_numbers(law))
    p = parameters_of(System(), 1.08, method)
    m = linear_scheme(p, method)
    tables, rng = skip_tables(m, p), np.random.default_rng(5)
    states = rng.normal(size=(4000, 10)) * (1, 0.01, 1, 1, 1, 10, 0, 0, 0, 0)
    angle = rng.uniform(0, 6, len(states))
    states[:, 7:] = np.column_stack([np.cos(angle), np.sin(angle), np.ones(len(states))])
    takes = [
        (tables.firsts[mode, : tables.deciding[mode], AFTER_STEP] @ states.T > 0).all(axis=0)
        for mode in range(len(tables.counts))
    ]
    if not m.at_end:  # the gap at the start decides between flight and contact
        pressed = states[:, 1] <= 0
        takes = [one & (pressed if mode else ~pressed) for mode, one in enumerate(takes)]
    found = np.sum(takes, axis=0)
    assert found.max() == 1
    assert (found == 1).mean() > 0.9
