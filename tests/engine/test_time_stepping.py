"""One-step methods with contact: their plain twins, OpenSees' states, steps without a solution, refusals."""

from dataclasses import replace

import numpy as np
import pytest
from vibroscope.engine import (
    HHT,
    INTEGRATORS,
    TRBDF2,
    Bathe,
    CentralDifference,
    ComparisonQuestion,
    Excitation,
    HHTInterpolated,
    Newmark,
    NewmarkBeta,
    Record,
    Reference,
    System,
    TimeStepping,
    compare,
    simulate,
)

from tests.naive_stepping import Twin
from tests.share import every

TEN = {"periods": 10, "keep": 10}
BENCHMARKS = [(1.08, 2500.0, 8.0), (2.76, 12000.0, 18.0), (3.25, 12000.0, 18.0), (2.2, 40000.0, 30.0)]


def random_case(seed, integrator, explicit):
    """A damped system, so that rounding does not grow: two bodies or a wall, with clearance and constant forces."""
    rng = np.random.default_rng(seed)
    wall = bool(seed % 2)
    system = System(
        kappa=rng.uniform(1.5, 3),
        d1=rng.uniform(0.3, 0.6),
        d2=rng.uniform(0.3, 0.6),
        mu=None if wall else rng.uniform(0.3, 3),
        wall=wall,
        clearance=rng.uniform(-0.3, 0.5),
        excitation=Excitation(base=1.0, force1=rng.uniform(0, 1), force1_phase=1.0, constant1=rng.uniform(-0.2, 0.3)),
    )
    status = "start" if explicit else ("end", "start")[seed // 2 % 2]
    law = "cut" if seed % 3 == 0 else "kelvin-voigt"
    steps = 100 if explicit else 40
    method = TimeStepping(rng.uniform(20, 200), rng.uniform(0.5, 3), steps, integrator, status, "keep", law)
    return system, rng.uniform(0.7, 2.5), method


@pytest.mark.parametrize(
    ("kind", "seed"),
    every((kind, (turn + first) % 4) for turn, kind in enumerate(INTEGRATORS.values()) for first in range(4)),
)
def test_every_step_is_that_of_the_twin(kind, seed):
    system, eta, method = random_case(seed, kind(), kind.explicit)
    run = simulate(system, eta, method, periods=12, keep=12)
    twin = Twin(system, eta, method)
    expected = twin.run(12)
    assert run.ok
    assert twin.contacts > 5
    np.testing.assert_allclose(run.section, expected, rtol=0, atol=1e-12 * np.abs(expected).max())
    assert (run.steps_without_solution, run.steps_with_two) == (twin.none, twin.two)


@pytest.mark.parametrize("law", ["kelvin-voigt", "cut"])
@pytest.mark.parametrize("system", [System(), System(wall=True, clearance=0.2)], ids=["two", "wall"])
def test_the_loop_of_matrices_is_newmarks_own(system, law):
    """HHT-α with α = 0 is Newmark's method, and takes the loop of all integrators."""
    options = {"periods": 3, "keep": 3, "record": Record(1, 2000)}
    one = simulate(system, 1.3, TimeStepping(400.0, 5.0, 2000, HHT(0.0), law=law), **options)
    other = simulate(system, 1.3, Newmark(400.0, 5.0, 2000, every_step=True, law=law), **options)
    assert len(one.impacts) == len(other.impacts) > 2
    for name in ("section", "contacts"):
        np.testing.assert_allclose(getattr(one, name), getattr(other, name), rtol=0, atol=1e-9)
    for name in ("time", "position", "velocity_before", "velocity_after", "impulse", "closing_speed"):
        np.testing.assert_allclose(getattr(one.impacts, name), getattr(other.impacts, name), rtol=0, atol=1e-8)
    for name in ("time", "displacement", "velocity", "force"):
        np.testing.assert_allclose(getattr(one.trajectory, name), getattr(other.trajectory, name), rtol=0, atol=1e-7)


@pytest.mark.parametrize(
    ("integrator", "steps", "expected"),
    [
        (NewmarkBeta(0.25, 0.5), 2000, (-7.0964901547, -1.7410846190, -0.2651140582, 3.6636479045)),
        (NewmarkBeta(0.3025, 0.6), 2000, (-6.7505921473, -1.5864255120, -0.2212238644, 4.1217242958)),
        (HHTInterpolated(-0.1), 2000, (-6.6147833022, -1.1930291529, 0.1486153957, 4.2154763072)),
        (TRBDF2(), 1000, (-6.7734854497, -1.5231951307, -0.2079259734, 3.9439111597)),  # two stages are its two steps
    ],
    ids=repr,
)
def test_states_of_opensees(integrator, steps, expected):
    """OpenSeesPy 3.7.1, ten periods from rest, accelerations zero at the start; contact ViscoelasticGap(K, 2D)."""
    method = TimeStepping(12000.0, 18.0, steps, integrator, "end", initial_acceleration="zero")
    np.testing.assert_allclose(simulate(System(), 2.76, method, **TEN).section[-1], expected, rtol=0, atol=1e-8)


@pytest.mark.parametrize(("steps", "periods"), [(500, (5, 4, None, 5)), (2000, (10, None, None, None))])
def test_first_steps_without_a_solution_are_those_in_which_opensees_stops(steps, periods):
    for (eta, k, d), period in zip(BENCHMARKS, periods, strict=True):
        run = simulate(System(), eta, TimeStepping(k, d, steps, status="end", initial_acceleration="zero"), **TEN)
        assert run.status == ("ok" if period is None else "without-solution")
        assert run.steps_without_solution == (period is not None)
        if period is not None:
            assert f"(period {period}) has no solution" in run.message
            assert len(run.section) == period - 1


def test_steps_with_two_solutions_are_counted():
    method = TimeStepping(2500.0, 8.0, 500, status="end", initial_acceleration="zero")
    assert simulate(System(), 1.08, method, **TEN).steps_with_two == 2


def test_two_hht_methods_differ_with_contact_only():
    runs = {}
    for clearance in (0.0, 1e3):
        methods = [TimeStepping(12000.0, 18.0, 2000, kind(-0.1), "end", "keep") for kind in (HHT, HHTInterpolated)]
        one, other = (simulate(System(clearance=clearance), 2.76, method, **TEN).section[-1] for method in methods)
        runs[clearance] = np.abs(one - other).max()
    assert runs[1e3] < 1e-5 < 1e-2 < runs[0.0]


@pytest.mark.parametrize("choice", ["keep", "halve"])
def test_a_run_goes_on_where_a_step_has_no_solution(choice):
    method = TimeStepping(2500.0, 8.0, 500, status="end", without_solution=choice)
    run = simulate(System(), 1.08, method, **TEN)
    assert run.ok
    assert run.steps_without_solution > 0
    stopped = simulate(System(), 1.08, replace(method, without_solution="stop"), **TEN)
    assert np.array_equal(run.section[: len(stopped.section)], stopped.section)


@pytest.mark.parametrize("integrator", every([TRBDF2(), NewmarkBeta(), HHT()]), ids=repr)
def test_halved_steps_are_those_of_the_twin(integrator):
    system = System(d1=0.3, d2=0.4, clearance=0.1)
    method = TimeStepping(2000.0, 30.0, 60, integrator, "end", "halve")
    run = simulate(system, 1.1, method, periods=15, keep=15)
    twin = Twin(system, 1.1, method)
    np.testing.assert_allclose(run.section, twin.run(15), rtol=0, atol=1e-11)
    assert run.steps_without_solution == twin.none > 0
    assert run.steps_with_two == twin.two


@pytest.mark.parametrize("integrator", [NewmarkBeta(), HHT(), HHTInterpolated(), TRBDF2(), Bathe(0.5)], ids=repr)
def test_impulse_is_the_change_of_momentum(integrator):
    """A body that hits a wall; its own spring takes its share, a mean position of 0.1035 over the contact."""
    system = System(wall=True, d1=0.0, clearance=0.1, excitation=Excitation(base=0.0))
    method = TimeStepping(2e4, 10.0, 20_000, integrator, "end", "keep")
    run = simulate(system, 1.0, method, periods=1, keep=1, initial=(0.0, 1.0, 0.0, 0.0))
    change = run.impacts.velocity_before[0, 0] - run.impacts.velocity_after[0, 0]
    spring = 0.1035 * np.diff(run.contacts[0])[0]
    assert run.impacts.impulse[0] == pytest.approx(change - spring, abs=3e-4)


@pytest.mark.parametrize(
    ("integrator", "steps", "words"),
    [
        (CentralDifference(), 100, "the method is unstable in contact with fewer than"),
        (NewmarkBeta(0.1, 0.5), 60, "the method is unstable in contact with fewer than"),
        (NewmarkBeta(0.25, 0.3), 100, "the method amplifies with every step, since gamma is below 1/2"),
    ],
    ids=repr,
)
def test_an_unstable_method_diverges_and_names_its_limit(integrator, steps, words):
    run = simulate(System(), 2.76, TimeStepping(12000.0, 18.0, steps, integrator), periods=400, keep=1)
    assert run.status == "diverged"
    assert f"the solution by {integrator.short_title()} blew up" in run.message
    assert words in run.message


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: TimeStepping(1.0, 1.0, 100, "hht"), "integrator = 'hht' is not an Integrator"),
        (
            lambda: TimeStepping(1.0, 1.0, 100, CentralDifference(), "end"),
            "central-difference knows the gap before the force",
        ),
        (lambda: TimeStepping(1.0, 1.0, 100, status="within"), "status = 'within' is not one of start, end, located"),
        (lambda: TimeStepping(1.0, 1.0, 100, without_solution="skip"), "is not one of stop, keep, halve"),
    ],
)
def test_bad_numbers_are_one_clear_line(make, words):
    with pytest.raises(ValueError, match=words) as caught:
        make()
    assert "\n" not in str(caught.value)


def test_a_comparison_has_its_parts():
    method = TimeStepping(2500.0, 8.0, 2000, HHT(-0.1), "end", "keep")
    found = compare(ComparisonQuestion(System(), 1.08, method, reference=Reference(), periods=300, keep=10))
    assert found.residual < 1e-9
    assert 0 < found.time_step < found.total
