"""The formulas of periodic motions and of a measurement are what the engine computes, read as in `test_formulas.py`."""

import math
import re

import numpy as np
import pytest
from scipy.linalg import expm
from vibroscope.engine import ExactPenalty, Reference, System, fit, steady, synthetic_measurement
from vibroscope.engine.drivers.orbit import OrbitEquations
from vibroscope.engine.drivers.parameters import parameters_of
from vibroscope.engine.kernels.equations.motion import pressed_generator, separated_generator
from vibroscope.engine.kernels.event_driven.orbit import IMPACT, PART, TOUCH
from vibroscope.engine.kernels.linear.tables import full_generator
from vibroscope.engine.measurement.cycle import align, reference_cycle
from vibroscope.engine.measurement.fit import FitProblem
from vibroscope.engine.motions.poincare_map import PoincareMap
from vibroscope.engine.motions.steady import Contraction, FixedPoint, norm_factor

from tests.displayed import Matrix, compares, of_pages, sides, value

PAGES = of_pages()
RANDOM = np.random.default_rng(24)


def column(numbers):
    return Matrix(np.reshape(numbers, (4, 1)))


def stable_orbit(eta, method):
    """A point of a stable cycle, ψ, and the factor of the norm in which DP shrinks by ψ."""
    poincare, found = PoincareMap(System(), eta, method, None), steady(System(), eta, method)
    y = poincare.coordinates(found.state)
    orbit = FixedPoint(found.period, y, poincare(y, found.period), 0)
    rate = (1 + np.abs(np.linalg.eigvals(orbit.returned.jacobian)).max()) / 2
    return orbit, rate, norm_factor(orbit.returned.jacobian / rate)


@compares(47, 48)
def test_a_state_that_comes_nearer():
    """An image just within the displayed limit, and one just beyond it; (47) in coordinates whose norm is |F·|."""
    orbit, rate, F = stable_orbit(2.76, ExactPenalty(12000.0, 18.0))
    jacobian, inverse = orbit.returned.jacobian, np.linalg.inv(F)
    for away in RANDOM.uniform(-1, 1, (10, 4)):
        y, turned = orbit.state + away, RANDOM.uniform(-1, 1, 4)
        limit = value(
            PAGES[48].partition(" ≤ ")[2], {"F": Matrix(F), "ψ": rate, "y*": column(0 * away), "y": column(away)}
        )
        for share in (0.999, 1.001):
            beside = jacobian @ away + turned * share * limit / np.linalg.norm(F @ turned)
            returned = orbit.returned._replace(state=orbit.state + beside)
            symbols = {"ψ": rate, "F": Matrix(F), "DP": Matrix(jacobian)}
            symbols |= {"P(y)": column(returned.state), "y*": column(orbit.state), "y": column(y)}
            own = {"ψ": rate, "DP": Matrix(F @ jacobian @ inverse)}
            own |= {"P(y)": column(F @ returned.state), "y*": column(F @ orbit.state), "y": column(F @ y)}
            for number, numbers in ((48, symbols), (47, own)):
                left, right = (value(side.strip(" ,"), numbers) for side in PAGES[number].split(" ≤ "))
                assert (left <= right) == (share < 1) == Contraction(rate, F).contracts(orbit, away, returned)


@pytest.mark.parametrize(
    ("method", "kinds"), [(Reference(), [IMPACT] * 3), (ExactPenalty(500.0, 3.0), [TOUCH, PART] * 2)]
)
@compares(52)
def test_the_equations_of_an_orbit(method, kinds):
    """The motion by matrix exponentials of the whole phases."""
    system, eta, period = System(), 1.3, 2
    p = parameters_of(system, eta, method)
    flight = full_generator(separated_generator(p), eta)
    touching = None if method.name == "reference" else full_generator(pressed_generator(p), eta)
    for y0 in RANDOM.uniform(0.1, 1, (3, 4)):
        instants = np.sort(RANDOM.uniform(0.1, period - 0.1, len(kinds)))
        found = OrbitEquations(system, eta, method)((tuple(kinds), 0, period), np.append(y0, instants)).residual
        y, turn, a, divided = y0, 0.0, flight, False
        for k, (kind, end) in enumerate(zip([*kinds, None], [*instants, period], strict=True)):
            angle = 2 * math.pi * turn
            z = np.array([*y, math.cos(angle), math.sin(angle)])
            y = (expm(a * (end - turn) * 2 * math.pi / eta) @ z)[:4]
            if kind is None:
                break
            equation = value(sides(PAGES[52])[0], {"f_k": lambda state, _: state[2], "y_k⁻": y, "θ_k": end})  # the gap
            trivial = end - turn if divided else 1.0  # the zero of the phase's own beginning is divided out
            assert found[4 + k] * trivial == pytest.approx(equation, rel=1e-9, abs=1e-11)
            y, turn, divided = np.array([*y[:2], 0.0, y[3]]), end, True
            if kind == IMPACT:
                y[1] += (1 + system.restitution) * system.mass_share * y[3]
                y[3] *= -system.restitution
            a = touching if kind == TOUCH else flight
        returns = value(sides(PAGES[52], 2)[0], {"y(pT)": column(y), "y₀": column(y0)})
        np.testing.assert_allclose(found[:4], returns.rows[:, 0], rtol=1e-9, atol=1e-11)


@pytest.mark.parametrize("frame", ["absolute", "relative"])
@compares(58)
def test_the_phase_of_a_measurement(frame):
    measured = synthetic_measurement(System(), 2.76, noise=0.05, phase=1.234, frame=frame)
    cycle = reference_cycle(System(), 2.76, Reference()).cycle
    found = align(cycle, measured)
    summed = PAGES[58].partition(" of ")[2].strip(" ,")
    summed = re.sub(r" \[(.*?)\]", r" \1" if frame == "absolute" else "", summed)  # the bracket for fixed sensors

    def squares(phase):
        symbols = {"x": lambda _: measured.displacement, "ξ": cycle.displacement, "tᵢ": measured.time, "τ₀": phase}
        return value(summed, symbols | {"η": 2.76, "cos": np.cos, "Σ": np.sum})

    least = squares(found.phase)
    assert 0 <= found.phase < cycle.length
    assert least == pytest.approx((found.rms**2) * np.sum(measured.displacement**2), rel=1e-9)
    assert all(least <= squares(phase) * (1 + 1e-9) for phase in np.linspace(0, cycle.length, 500))


@compares(59)
def test_the_standard_errors_of_a_fit():
    measured = synthetic_measurement(System(restitution=0.45), 2.76, noise=0.03)
    names = ("restitution", "d2")
    found = fit(System(), 2.76, measured, names=names)
    problem = FitProblem(System(), 2.76, measured, names, Reference(threshold=0.0), None)
    best = np.array([*found.values.values(), found.phase])
    J, r = Matrix(problem.jacobian(best)), problem.residuals(best)
    symbols = {"n": len(measured.time), "k": len(best), "r": r, "Σ": np.sum}
    squared = value(sides(PAGES[59], 1)[1], symbols)
    assert math.sqrt(squared) == pytest.approx(found.deviation, rel=1e-6)
    covariance = value(sides(PAGES[59])[1], {"σ_n": math.sqrt(squared), "J": J, "Jᵀ": Matrix(J.rows.T)})
    errors = np.sqrt(np.diag(covariance.rows))[: len(names)]
    np.testing.assert_allclose(errors, list(found.errors.values()), rtol=1e-4)
