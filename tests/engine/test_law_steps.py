"""Steps with other laws than spring and damper, every integrator and status, beside a twin that brackets λ."""

import numpy as np
import pytest
from vibroscope.engine import CONTACT_LAWS, INTEGRATORS, LAWS_BY_RESTITUTION, System, TimeStepping, simulate
from vibroscope.engine.drivers.parameters import parameters_of
from vibroscope.engine.kernels.equations.contact_law import ContactLaw, law_force, law_slopes
from vibroscope.engine.kernels.time_stepping import law_step, newmark

from tests.law_numbers import law_numbers
from tests.naive_law_stepping import LawTwin
from tests.share import every

PERIODS = 4
EXPONENTS = {"impact": 2.2, "hunt-crossley": 1.0, "constant-restitution": 2.0}


def cases():
    """Integrator, status and law, each with its formula's damper where it has one."""
    for turn, law in enumerate(CONTACT_LAWS[2:]):
        for kind in INTEGRATORS.values():
            for status in ("start", "end")[: 1 if kind.explicit else 2]:
                yield kind, status, law, bool(turn % 2)


@pytest.mark.parametrize(("kind", "status", "law", "wall"), every(cases()))
def test_every_step_is_that_of_the_twin(kind, status, law, wall):
    system = System(wall=wall, mu=None if wall else 0.7, kappa=2.0, d1=0.4, d2=0.5, clearance=0.1)
    steps = 120 if kind.explicit else 50
    damping, numbers = None if law in LAWS_BY_RESTITUTION else 2.0, law_numbers(law, EXPONENTS.get(law), 0.05)
    method = TimeStepping(80.0, damping, steps, kind(), status, "keep", law, every_step=True, **numbers)
    run = simulate(system, 1.3, method, periods=PERIODS, keep=PERIODS)
    twin = LawTwin(system, 1.3, method)
    expected = twin.run(PERIODS)
    assert run.ok
    assert twin.contacts == len(run.contacts) >= PERIODS - 1
    np.testing.assert_allclose(run.section, expected, rtol=0, atol=1e-12 * max(1.0, np.abs(expected).max()))
    assert (run.steps_without_solution, run.steps_with_two) == (twin.none, twin.two)


@pytest.mark.parametrize("law", every(["compression", "constant-restitution"]))
def test_steps_without_a_solution_of_a_damper_that_jumps(law):
    numbers = law_numbers(law, 1.0)
    system = System(d1=0.4, d2=0.5, clearance=0.1)
    method = TimeStepping(300.0, 30.0, 60, status="end", without_solution="keep", law=law, every_step=True, **numbers)
    run = simulate(system, 1.1, method, periods=6, keep=6)
    twin = LawTwin(system, 1.1, method)
    np.testing.assert_allclose(run.section, twin.run(6), rtol=0, atol=1e-11)
    assert run.steps_without_solution == twin.none > 0
    assert run.steps_with_two == twin.two


@pytest.mark.parametrize("law", CONTACT_LAWS[4:10])
def test_newton_s_method_finds_the_force_of_the_bracket(law):
    method = TimeStepping(700.0, 4.0, 60, law=law, **law_numbers(law, 1.7 if law == "impact" else None))
    m, found = newmark.scheme_of(parameters_of(System(), 1.3, method)), 0
    for numbers in np.random.default_rng(11).uniform((-1, -1, 0, 0), (0, 1, 2e-3, 0.1), (200, 4)):
        one, other = law_step.newton_root(m.law, 0.3, *numbers), law_step.bracketed_root(m.law, 0.3, *numbers)
        if not np.isnan(one):
            assert one == pytest.approx(other, rel=1e-14, abs=1e-15)
            found += 1
    assert found > 180


@pytest.mark.parametrize("law", CONTACT_LAWS[4:10])
@pytest.mark.parametrize("exponent", [1.5, 2.2])
def test_the_slopes_of_a_law_are_its_derivatives(law, exponent):
    law, step = CONTACT_LAWS.index(law), 1e-6
    for depth, speed in np.random.default_rng(12).uniform((0.05, -1.5), (2.0, 1.5), (50, 2)):
        at = ContactLaw(law, 7.0, exponent, 0.8, 0.0, 0.3, 0.0), 0.3
        by_depth, by_speed = law_slopes(*at, depth, speed)
        expected = (law_force(*at, depth + step, speed) - law_force(*at, depth - step, speed)) / (2 * step)
        assert by_depth == pytest.approx(expected, rel=1e-6, abs=1e-6)
        expected = (law_force(*at, depth, speed + step) - law_force(*at, depth, speed - step)) / (2 * step)
        assert by_speed == pytest.approx(expected, rel=1e-6, abs=1e-6)
