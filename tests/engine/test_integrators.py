"""Order, stability and spectral radius of every integrator against textbook formulas."""

import cmath
import math
from dataclasses import replace

import numpy as np
import pytest
from vibroscope.engine import (
    HHT,
    TRBDF2,
    BackwardEuler,
    Bathe,
    CentralDifference,
    EulerImplicitDamper,
    ExactPenalty,
    GeneralisedAlpha,
    HHTInterpolated,
    NewmarkBeta,
    SemiImplicitEuler,
    System,
    TimeStepping,
    simulate,
)
from vibroscope.engine.drivers.parameters import parameters_of
from vibroscope.engine.drivers.step_maps import bodies_of, is_stable, spectral_radius, stage_maps

from tests.share import every

SECOND_ORDER = (
    NewmarkBeta(),
    NewmarkBeta(1 / 6, 0.5),
    HHT(-0.1),
    HHTInterpolated(-0.2),
    GeneralisedAlpha(0.4),
    TRBDF2(),
    Bathe(0.3),
)
FLIGHT = System(clearance=1000.0)
PRESSED = System(clearance=-1000.0, d1=0.05, d2=0.08)


def bodies(damping=0.0):
    """One body and a wall, of frequency 1: what a textbook's single degree of freedom is."""
    method = TimeStepping(1.0, 0.0, 100)
    return bodies_of(parameters_of(System(wall=True, d1=damping), 1.0, method))


def radius(integrator, size, damping=0.0):
    """Spectral radius of a step ωΔτ = ``size`` without contact."""
    return spectral_radius(stage_maps(bodies(damping), integrator, size))


def errors(system, integrator, status, eta=1.3, steps=(200, 400, 800)):
    """Errors at the end of two periods with so many steps in each; contact does not change."""
    options = {"periods": 2, "keep": 1, "initial": (1.0, 0.3, -0.5, 0.2) if system.clearance > 0 else None}
    truth = simulate(system, eta, ExactPenalty(20.0, 3.0), **options).section[-1]
    found = [simulate(system, eta, TimeStepping(20.0, 3.0, n, integrator, status), **options) for n in steps]
    assert all(run.ok for run in found)
    return [np.abs(run.section[-1] - truth).max() for run in found]


def slopes(values):
    return np.diff(-np.log2(values))


@pytest.mark.parametrize("integrator", SECOND_ORDER, ids=repr)
@pytest.mark.parametrize("system", [FLIGHT, PRESSED], ids=["flight", "contact"])
@pytest.mark.parametrize("status", ["start", "end"])
def test_second_order(integrator, system, status):
    assert slopes(errors(system, integrator, status)) == pytest.approx([2.0, 2.0], abs=0.1)


@pytest.mark.parametrize(
    ("integrator", "damping", "order"),
    [
        (NewmarkBeta(0.3025, 0.6), 0.01, 1.0),
        (SemiImplicitEuler(), 0.0, 1.0),
        (EulerImplicitDamper(), 0.2, 1.0),
        (BackwardEuler(), 0.01, 1.0),
        (CentralDifference(), 0.2, 1.0),  # the damper feels the velocity of half a step before
        (CentralDifference(), 0.0, 2.0),
    ],
    ids=repr,
)
def test_order_of_the_others(integrator, damping, order):
    system, steps = replace(FLIGHT, d1=damping, d2=damping), (800, 1600, 3200)
    assert slopes(errors(system, integrator, "start", steps=steps)) == pytest.approx([order, order], abs=0.1)


def one_stage_radius(integrator, size):
    """Largest root λ of the characteristic polynomial of Eqs. (14) and (15) with one stage, without damping."""
    (s,) = integrator.stages
    inertia, spring = [1 - s.alpha_m, s.alpha_m], [1 - s.alpha_f, s.alpha_f]
    moved = np.polyadd([s.gamma, 1 - s.gamma], np.polymul([s.beta, 0.5 - s.beta], [1, -1]))
    polynomial = np.polyadd(np.polymul(inertia, [1, -2, 1]), size**2 * np.polymul(spring, moved))
    return np.abs(np.roots(polynomial)).max()


@pytest.mark.parametrize("size", [0.01, 0.3, 1.0, 3.0, 10.0, 300.0])
@pytest.mark.parametrize(
    "integrator",
    [
        NewmarkBeta(0.3025, 0.6),
        HHT(-0.05),
        HHT(-0.3),
        HHTInterpolated(-0.1),
        GeneralisedAlpha(0.4),
        NewmarkBeta(0.1, 0.5),
    ],
    ids=repr,
)
def test_spectral_radius_of_one_stage(integrator, size):
    assert radius(integrator, size) == pytest.approx(one_stage_radius(integrator, size), rel=1e-7)


@pytest.mark.parametrize(("beta", "gamma", "damping"), [(0.25, 0.5, 0.1), (0.3, 0.6, 0.02), (0.1, 0.5, 0.2)])
@pytest.mark.parametrize("size", [0.1, 1.0, 2.5])
def test_spectral_radius_of_newmarks_method_with_damping(beta, gamma, damping, size):
    """λ² − 2A₁λ + A₂ = 0 with Hughes' A₁ and A₂."""
    divisor = 1 + 2 * gamma * damping * size + beta * size**2
    a1 = 1 - (damping * size + size**2 * (gamma + 0.5) / 2) / divisor
    a2 = 1 - (2 * damping * size + size**2 * (gamma - 0.5)) / divisor
    expected = np.abs(np.roots([1, -2 * a1, a2])).max()
    assert radius(NewmarkBeta(beta, gamma), size, damping) == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize("size", [0.01, 0.3, 1.0, 3.0, 10.0, 300.0])
@pytest.mark.parametrize(
    ("integrator", "share", "rho"),
    [(TRBDF2(), 0.5, 0.0), (Bathe(0.0), 2 - math.sqrt(2), 0.0), (Bathe(0.6), (2 - math.sqrt(3.2)) / 0.4, 0.6)],
)
def test_spectral_radius_of_two_stages(integrator, share, rho, size):
    """|y₁/y₀| of y′ = iωy: trapezoidal rule, then y₁ = y₀ + Δτ(q₀y₀′ + q₁y′ + q₂y₁′)."""
    z = 1j * size
    q1 = (rho + 1) / (2 * share * (rho - 1) + 4)
    q0, q2 = (share - 1) * q1 + 0.5, 0.5 - share * q1
    middle = (1 + share * z / 2) / (1 - share * z / 2)
    assert radius(integrator, size) == pytest.approx(abs((1 + q0 * z + q1 * z * middle) / (1 - q2 * z)), rel=1e-12)


@pytest.mark.parametrize("rho", [0.0, 0.5, 1.0])
@pytest.mark.parametrize("kind", [GeneralisedAlpha, Bathe])
def test_rho_is_the_spectral_radius_at_high_frequencies(kind, rho):
    assert radius(kind(rho), 1e6) == pytest.approx(rho, abs=1e-3)  # a triple root at ρ = 0


UNCONDITIONAL = [
    *(kind(alpha) for kind in (HHT, HHTInterpolated) for alpha in (-1 / 3, -0.2, -0.05, 0.0)),
    *(kind(rho) for kind in (GeneralisedAlpha, Bathe) for rho in (0.0, 0.3, 0.7, 1.0)),
    NewmarkBeta(0.25, 0.5),
    NewmarkBeta(0.4, 0.6),
    TRBDF2(),
    BackwardEuler(),
]


@pytest.mark.parametrize("damping", [0.0, 0.05, 0.9])
@pytest.mark.parametrize("integrator", every(UNCONDITIONAL), ids=repr)
def test_unconditional_stability(integrator, damping):
    """Up to ωΔτ = 1e6, where ρ∞ = 1 has a double root 1 of generalised-α, with half the digits."""
    rounding = 1e-5 if integrator == GeneralisedAlpha(1.0) else 1e-12
    assert max(radius(integrator, size, damping) for size in np.logspace(-3, 6, 37)) <= 1 + rounding


def test_both_stages_of_the_bathe_method_have_one_effective_stiffness():
    for rho in (0.0, 0.7, 1.0):
        first, second = Bathe(rho).stages
        assert first.gamma == pytest.approx(second.gamma, rel=1e-14)


@pytest.mark.parametrize("damping", [0.0, 0.1, 0.5])
@pytest.mark.parametrize("integrator", [CentralDifference(), SemiImplicitEuler()], ids=repr)
def test_stability_limit_of_explicit_methods(integrator, damping):
    """2(√(1 + ζ²) − ζ), and below it the roots of λ² − (2 − Ω² − 2ζΩ)λ + 1 − 2ζΩ = 0."""
    limit = 2 * (math.sqrt(1 + damping**2) - damping)
    assert radius(integrator, 0.999 * limit, damping) <= 1 + 1e-12 < 1.01 < radius(integrator, 1.01 * limit, damping)
    trace, determinant = 2 - 0.25 - damping, 1 - damping  # of Ω = ½
    root = (trace + cmath.sqrt(trace**2 - 4 * determinant)) / 2
    expected = max(abs(root), abs(trace - root))
    assert radius(integrator, 0.5, damping) == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize("damping", [0.0, 0.1, 0.5, 0.95])
def test_stability_limit_with_implicit_dampers(damping):
    """2(√(1 + ζ²) + ζ), and below it the roots of (1 + 2ζΩ)λ² − (2 + 2ζΩ − Ω²)λ + 1 = 0."""
    limit, kind = 2 * (math.sqrt(1 + damping**2) + damping), EulerImplicitDamper()
    assert radius(kind, 0.999 * limit, damping) <= 1 + 1e-12 < radius(kind, 1.01 * limit, damping)
    for size in (0.1, 0.5, 1.5, 4.0):
        roots = np.roots([1 + 2 * damping * size, size**2 - 2 - 2 * damping * size, 1])
        assert radius(kind, size, damping) == pytest.approx(np.abs(roots).max(), rel=1e-12)


@pytest.mark.parametrize("damping", [0.0, 0.1, 0.5, 0.95])
@pytest.mark.parametrize("size", [0.01, 0.5, 3.0, 300.0])
def test_spectral_radius_of_backward_euler(damping, size):
    """|1/(1 − z)| of y′ = zy/Δτ, z/ωΔτ the eigenvalues of the oscillator."""
    root = cmath.sqrt(damping**2 - 1)
    expected = max(abs(1 / (1 - size * (-damping + sign * root))) for sign in (1, -1))
    assert radius(BackwardEuler(), size, damping) == pytest.approx(expected, rel=1e-7)


def test_without_dampers_it_is_semi_implicit_euler():
    """From the same start; the forces of one are those at the end of a step, of the other at its beginning."""
    system, eta = System(wall=True, d1=0.0, clearance=0.5), 0.8
    runs = [
        simulate(system, eta, TimeStepping(50.0, 0.0, 200, kind()), periods=3, keep=3, initial=(0.0, 0.1, 0.0, 0.0))
        for kind in (SemiImplicitEuler, EulerImplicitDamper)
    ]
    assert len(runs[0].impacts) > 2
    np.testing.assert_allclose(runs[1].section, runs[0].section, rtol=0, atol=1e-10)


def test_stability_limit_of_newmarks_method():
    """ωΔτ = 1/√(γ/2 − β) for γ = ½, 2β < γ; none for 2β ≥ γ."""
    limit, b = 1 / math.sqrt(0.25 - 1 / 6), bodies()
    assert is_stable(b, NewmarkBeta(1 / 6, 0.5), 0.999 * limit, 0)
    assert not is_stable(b, NewmarkBeta(1 / 6, 0.5), 1.01 * limit, 0)
    assert is_stable(b, NewmarkBeta(0.25, 0.5), 1e3, 0)


def test_semi_implicit_euler_has_the_displacements_of_central_differences():
    """Its velocity at a step is that of half a step before; both feel the contact damper there."""
    system, eta, n = System(wall=True, d1=0.0, clearance=0.5), 0.8, 200
    half = math.pi / eta / n
    runs = [
        simulate(system, eta, TimeStepping(50.0, 1.0, n, kind()), periods=3, keep=3, initial=(0.0, v, 0.0, 0.0))
        for kind, v in ((CentralDifference, 0.1), (SemiImplicitEuler, 0.1 - half * eta**2))
    ]
    assert len(runs[0].impacts) > 2
    np.testing.assert_allclose(runs[1].section[:, 0], runs[0].section[:, 0], rtol=0, atol=1e-10)
