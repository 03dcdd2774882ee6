"""Restitution of each contact law and its damping: closed forms, published promises, inverse, bad input."""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from vibroscope.engine import (
    CONTACT_LAWS,
    LAWS_BY_RESTITUTION,
    ExactPenalty,
    System,
    TimeStepping,
    damping_of_restitution,
    effective_restitution,
    restitution_of_damping,
    simulate,
    stiffness_of_step,
)
from vibroscope.engine.law_table import RATIO_LAWS

from tests.law_numbers import law_numbers
from tests.naive_laws import force, gain_of

K, MASS = 900.0, 0.7
EXTRA = {law: law_numbers(law, {"impact": 2.2, "constant-restitution": 2.2}.get(law)) for law in CONTACT_LAWS}


def by_integration(method, gain, closing):
    """−δ′/v₀ where δ is zero again, of the reduced mass alone."""

    def rates(t, y):
        return [y[1], -force(method, gain, y[0], y[1]) / MASS]

    def depth(t, y):
        return y[0] if t > 0 else 1.0

    depth.terminal, depth.direction = True, -1
    end = solve_ivp(rates, (0, 50), [0.0, closing], events=depth, method="DOP853", rtol=1e-12, atol=1e-15)
    assert end.status == 1
    return -end.y[1, -1] / closing


@pytest.mark.parametrize("closing", [0.02, 3.0])
@pytest.mark.parametrize("law", CONTACT_LAWS)
def test_it_is_what_an_integration_gives(law, closing):
    damping = 0.2 * K if law in RATIO_LAWS else 9.0
    method = ExactPenalty(K, damping, law, **EXTRA[law])
    gain = 2 * damping / (K if damping > 9.0 else 1.0)
    found = restitution_of_damping(law, damping, K, mass=MASS, closing_speed=closing, **EXTRA[law])
    assert found == pytest.approx(by_integration(method, gain, closing), rel=1e-8)
    again = damping_of_restitution(law, found, K, mass=MASS, closing_speed=closing, **EXTRA[law])
    assert again == pytest.approx(damping, rel=1e-6)


@pytest.mark.parametrize("exponent", [1.0, 1.5, 3.0])
@pytest.mark.parametrize("promised", [0.2, 0.9])
def test_constant_restitution_gives_what_its_formula_promises_at_any_exponent(promised, exponent):
    """Its damper by its formula, an integration with it, and both ways between damping and restitution."""
    law, closing = "constant-restitution", 1.3
    method, system = ExactPenalty(K, None, law, exponent=exponent), System(wall=True, restitution=promised)
    gain = gain_of(method, promised, MASS, closing)
    assert by_integration(method, gain, closing) == pytest.approx(promised, rel=1e-9)
    numbers = {"mass": MASS, "exponent": exponent}
    assert restitution_of_damping(law, gain / 2, K, **numbers) == pytest.approx(promised, rel=1e-12)
    assert damping_of_restitution(law, promised, K, **numbers) == pytest.approx(gain / 2, rel=1e-12)
    assert effective_restitution(system, method, closing) == pytest.approx(promised, rel=1e-12)


def test_limited_damper_in_closed_form():
    """From touch with 2Kδ to cv = Kδ, then a damped oscillator until cv = −Kδ."""
    zeta = 0.3
    root = math.sqrt(1 - zeta**2)
    first = math.sin(math.atan(2 * math.sqrt(2) * zeta)) / math.sqrt(2)  # ωδ/v₀
    begin, end = (math.atan((-sign / (2 * zeta) - zeta) / root) for sign in (1, -1))
    second = first * math.exp(-zeta / root * (end - begin)) * math.cos(end) / math.cos(begin)
    damping = zeta * math.sqrt(K * MASS)
    assert restitution_of_damping("limited", damping, K, mass=MASS) == pytest.approx(second / (2 * zeta), rel=1e-11)


def test_a_cut_damper_parts_faster():
    damping = 0.241 * math.sqrt(K)
    assert restitution_of_damping("kelvin-voigt", damping, K) == pytest.approx(0.459, abs=1e-3)
    assert restitution_of_damping("cut", damping, K) == pytest.approx(0.518, abs=1e-3)


def test_what_the_formulas_promise_and_give():
    """Restitution 0.2: the formulas of Hunt & Crossley and of Lankarani & Nikravesh hold near 1 alone."""
    system, speeds = System(restitution=0.2), [1e-3, 1.0, 100.0]
    given = {
        law: effective_restitution(system, ExactPenalty(K, None, law, **EXTRA[law]), speeds)
        for law in LAWS_BY_RESTITUTION
    }
    for values in given.values():
        np.testing.assert_allclose(values, values[0], rtol=1e-9)  # at any closing speed
    assert given["lankarani-nikravesh"][0] == pytest.approx(0.672, abs=1e-3)
    assert given["hunt-crossley"][0] == pytest.approx(0.547, abs=1e-3)
    assert given["flores"][0] == pytest.approx(0.156, abs=1e-3)
    assert given["jankowski"][0] == pytest.approx(0.191, abs=1e-3)
    np.testing.assert_allclose(given["constant-restitution"], 0.2, rtol=1e-12)
    high = System(restitution=0.99)
    for law in LAWS_BY_RESTITUTION:
        assert effective_restitution(high, ExactPenalty(K, None, law), 1.0) == pytest.approx(0.99, abs=2e-3)


def test_a_run_has_it():
    """A free body on a wall that a constant force presses: its impacts lose what the law says."""
    system = System(wall=True, d1=0.0, restitution=0.7)
    method = ExactPenalty(1e8, None, "constant-restitution", exponent=2.0)
    run = simulate(system, 3e-3, method, periods=1, keep=1, initial=(-1.0, 0.0, 0.0, 0.0))
    speeds = run.impacts.closing_speed[:5]
    np.testing.assert_allclose(speeds[1:] / speeds[:-1], 0.7, rtol=1e-3)


def test_stiffness_that_follows_the_step():
    system, eta = System(), 2.76
    stiffness = stiffness_of_step(system, eta, 2000, 0.1)
    step = 2 * math.pi / eta / 2000
    assert stiffness == pytest.approx(0.1 * min(1.0, system.mass_ratio) / step**2)  # of the lighter body
    heavy = System.from_mass_ratio(3.0)
    assert stiffness_of_step(heavy, eta, 2000, 0.1) == pytest.approx(0.1 / step**2)
    assert stiffness_of_step(system, eta, 4000, 0.1) == pytest.approx(4 * stiffness)


@pytest.mark.parametrize(
    ("call", "text"),
    [
        (lambda: restitution_of_damping("cut", -1, K), r"D = -1 is outside \[0"),
        (lambda: restitution_of_damping("hertz", 1, K), "law = 'hertz' is not one of"),
        (lambda: damping_of_restitution("cut", 1.2, K), r"restitution = 1.2 is outside \[0, 1\]"),
        (lambda: damping_of_restitution("flores", 0.0, K), "restitution = 0 is less than any damping gives"),
        (
            lambda: effective_restitution(System(), ExactPenalty(K, 1, "cut"), 0.0),
            r"closing_speed = 0.0 is outside \(0",
        ),
        (lambda: effective_restitution(System(restitution=0), ExactPenalty(K, None, "flores"), 1.0), "give D"),
        (lambda: stiffness_of_step(System(), 1.0, 100, 0.0), r"stiffness_of_step = 0.0 is outside \(0"),
        (lambda: TimeStepping(K, None, 100, law="limited"), "D = None is outside"),
    ],
)
def test_bad_numbers_are_named(call, text):
    with pytest.raises(ValueError, match=text):
        call()


@pytest.mark.parametrize("law", CONTACT_LAWS)
def test_no_damper_loses_nothing_and_none_gains(law):
    assert restitution_of_damping(law, 0.0, K, mass=MASS, **EXTRA[law]) == 1.0
    for damping in (1e-300, 1e-15, 1e-12, 1e-9):
        assert restitution_of_damping(law, damping, K, mass=MASS, **EXTRA[law]) <= 1.0
