"""The numbered formulas of the methods, of chatter, derivatives, energy and comparison are what the engine computes.

As in `tests/test_formulas.py` each is read from the page as it is displayed there.
"""

import math
import re
from dataclasses import replace

import numpy as np
import pytest
from vibroscope.engine import (
    CONTACT_LAWS,
    HHT,
    BackwardEuler,
    ComparisonQuestion,
    EulerImplicitDamper,
    ExactPenalty,
    GeneralisedAlpha,
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
from vibroscope.engine.contact import spring_energy
from vibroscope.engine.divergence.grid import samples_on_grid
from vibroscope.engine.divergence.parts import PARTS
from vibroscope.engine.drivers.event_driven import set_up
from vibroscope.engine.drivers.located import scheme_of_run
from vibroscope.engine.drivers.parameters import parameters_of
from vibroscope.engine.drivers.step_maps import bodies_of, stage_ends, stage_maps
from vibroscope.engine.energy.balance import energy_balance
from vibroscope.engine.energy.events import energy_forms, phase_integrals
from vibroscope.engine.hardcases.cases import EPSILON, SimulationSetup, accumulated_rounding, sensitivity
from vibroscope.engine.hardcases.cases import attainable_error as attainable
from vibroscope.engine.kernels.compile.options import uncompiled
from vibroscope.engine.kernels.equations.contact_law import contact_rate, law_force
from vibroscope.engine.kernels.equations.motion import accelerations, coefficients, separated_generator
from vibroscope.engine.kernels.time_stepping import contact_location, law_step, located, newmark, stage

from tests.displayed import Matrix, compares, of_pages, sides, value
from tests.law_numbers import law_numbers

PAGES = of_pages()
SYSTEM, ETA = System(mu=0.7, kappa=1.8, d1=0.1, d2=0.2, clearance=0.1), 1.3
RANDOM = np.random.default_rng(21)
REFERENCE = set_up(SYSTEM, ETA, Reference()).views
PARAMETERS = parameters_of(SYSTEM, ETA, Reference())


def states(count, size):
    """Random states whose last two numbers are a cosine and a sine."""
    turn = RANDOM.uniform(0, 6, count)
    return np.column_stack([RANDOM.uniform(-2, 2, (count, size - 2)), np.cos(turn), np.sin(turn)])


def spelled_out(formula, count):
    """Sums over j written term by term."""
    return re.sub(
        "Σ (.)ⱼ(.)ⱼ", lambda m: "(" + " + ".join(f"{m[1]}{j}_{m[2]}{j}_" for j in range(count)) + ")", formula
    )


@pytest.mark.parametrize("pressed", [False, True])
@compares(12)
def test_accelerations_of_a_located_step(pressed):
    method = Newmark(700.0, 4.0, 60, located=True)
    m = scheme_of_run(parameters_of(SYSTEM, ETA, method), method)
    e = contact_location.side(m, pressed)
    for x, v, g, u, cosine, sine in states(5, 6):
        forcing = stage.forcing_with(m.forcing, cosine, sine)
        _, _, a, _, _, b = stage.with_accelerations(e, (x, v, 0.0, g, u, 0.0), forcing)
        symbols = {"x": x, "v": v, "g": g, "u": u, "η": ETA, "τ": math.atan2(sine, cosine) / ETA}
        names = ("₂ₓ", "₂ᵥ", "₂g", "₂ᵤ", "₄ₓ", "₄ᵥ", "₄g", "₄ᵤ")
        symbols |= {f"A{name}": number for name, number in zip(names, e[:8], strict=True)}
        constants = m.forcing[0][2], m.forcing[1][2]  # of an equilibrium that is not at zero
        for which, found in enumerate((a, b)):
            assert value(sides(PAGES[12], which)[1], symbols) + constants[which] == pytest.approx(found, rel=1e-12)


@pytest.mark.parametrize("stiffness", [50.0, 3e4])
@compares(13)
def test_steps_in_contact_are_as_long_as_they_may_be(stiffness):
    method = Newmark(stiffness, 4.0, 60, located=True)
    p = parameters_of(SYSTEM, ETA, method)
    m = scheme_of_run(p, method)
    fast = contact_rate(p.stiffness, p.damping, 1 / p.mass_share)
    symbols = {"Δτ": m.h, "T_c": 2 * math.pi / fast, "T_f": 2 * math.pi / max(1.0, SYSTEM.kappa, ETA)}
    for t in (0.0, 0.03, 0.4, 2.0):
        limit = value(PAGES[13].partition(" ≤ ")[2], symbols | {"t": t})
        _, pieces = located.halvings_at(m, True, t)
        assert m.h / pieces <= limit * (1 + 2e-6)
        assert pieces == 1 or 2 * m.h / pieces > limit


def of_bodies(u):
    """Displacements from the equilibrium, velocities and accelerations of both bodies, (3, 2), of a state u."""
    rest = np.array([PARAMETERS.free_position, PARAMETERS.free_position + PARAMETERS.free_gap])
    motion = np.array([[one, one + gap] for one, gap in u[:6].reshape(3, 2)])
    motion[0] -= rest
    return motion


METHODS = NewmarkBeta(0.3, 0.6), HHT(-0.2), HHTInterpolated(-0.2), GeneralisedAlpha(0.6)
METHODS += EulerImplicitDamper(), BackwardEuler()


@pytest.mark.parametrize("status", [0, 1])
@pytest.mark.parametrize("integrator", METHODS, ids=lambda kind: kind.name)
@compares(14, 15)
def test_a_stage_of_an_integrator(integrator, status):
    p, h, (one,) = parameters_of(SYSTEM, ETA, TimeStepping(700.0, 4.0, 60)), 0.07, integrator.stages
    b, c = bodies_of(p), uncompiled(coefficients)(p)
    mass, damping, springs = np.array([1.0, c.mu]), (c.c1, c.c2 * c.mu), (c.k1, c.k2 * c.mu)
    loads = mass[:, None] * [c.load1, np.add(c.load1, c.push)]
    ((*_, end),) = stage_ends(stage_maps(b, integrator, h), [b.contact if status else None])
    for start in np.column_stack([RANDOM.uniform(-2, 2, (5, 7)), states(5, 3)[:, 1:], np.ones(5)]):
        (q0, v0, a0), found = of_bodies(start), end @ start
        (q, v, a), force = of_bodies(found), found[6]
        assert force == pytest.approx(status * (-700.0 * found[7] - 2 * 4.0 * found[8]), rel=1e-9)  # Eq. (5)
        angles = math.atan2(start[8], start[7]) + ETA * h * np.array([0.0, 1.0 - one.alpha_f, 1.0])
        load = loads @ np.array([np.cos(angles), np.sin(angles)])
        averaged = integrator.averaged
        push = force * (1 - one.alpha_f) + one.alpha_f * start[6] if averaged else force
        acting = load[:, 2] * (1 - one.alpha_f) + one.alpha_f * load[:, 0] if averaged else load[:, 1]
        for i in range(2):
            symbols = {"q₀": q0[i], "v₀": v0[i], "a₀": a0[i], "q": q[i], "v": v[i], "a": a[i], "Δτ": h}
            symbols |= {"β": one.beta, "γ": one.gamma, "α_m": one.alpha_m, "α_f": one.alpha_f}
            symbols["α_v"] = one.velocity_share
            symbols |= {"d0_": one.velocities[0], "e0_": one.accelerations[0], "f0_": one.rates[0]}
            symbols |= {"v0_": v0[i], "a0_": a0[i], "r": (-1.0, 1.0)[i], "λ": push, "l": acting[i]}
            symbols |= {"M": mass[i], "C": damping[i], "K": springs[i]}
            for which, found in enumerate((q[i], v[i])):
                assert value(spelled_out(sides(PAGES[14], which)[1], 1), symbols) == pytest.approx(found, rel=1e-11)
            left, right = (value(side, symbols) for side in sides(PAGES[15]))
            assert left == pytest.approx(right, rel=1e-10, abs=1e-10)


@pytest.mark.parametrize("law", [law for law in CONTACT_LAWS if law not in ("kelvin-voigt", "cut")])
@compares(27)
def test_the_force_of_a_step(law):
    numbers = law_numbers(law, 1.7 if law == "impact" else None)
    method = TimeStepping(700.0, 4.0, 60, law=law, **numbers)
    m = newmark.scheme_of(parameters_of(SYSTEM, ETA, method))
    for gap, rate, a, b in RANDOM.uniform((-1, -1, 0, 0), (0, 1, 1, 1), (5, 4)):
        found = law_step.solve_force(m.law, 0.3, gap, rate, a, b)
        symbols = {"g₀": gap, "r₀": rate, "a": a, "b": b, "λ": found}
        symbols["L"] = lambda depth, speed: law_force(m.law, 0.3, depth, speed)
        assert value(sides(PAGES[27])[1], symbols) == pytest.approx(found, rel=1e-9, abs=1e-9)


@compares(43)
def test_the_error_that_can_be_attained():
    setup = SimulationSetup(SYSTEM, ETA, Reference(), 3)
    symbols = {"ε_m": EPSILON, "sensitivity": sensitivity(setup), "accumulated rounding": accumulated_rounding(setup)}
    assert EPSILON == 2.0**-52
    assert value(sides(PAGES[43])[1], symbols) == pytest.approx(attainable(setup), rel=1e-12, abs=0)


@pytest.mark.parametrize("method", [Reference(), ExactPenalty(300.0, 2.0)], ids=["reference", "penalty"])
@compares(49)
def test_the_mechanical_energy(method):
    system = System(mu=0.7, kappa=1.8, d1=0.1, d2=0.2)
    forms = energy_forms(system, ETA, method)
    for x1, v1, g, u, *_ in states(8, 6):
        symbols = {"ξ₁": x1, "ξ₁′": v1, "ξ₂": x1 + g, "ξ₂′": v1 + u, "μ": 0.7, "κ": 1.8, "g": g}
        spring = 0.0 if method.name == "reference" else float(spring_energy(method, np.array([g]))[0])
        z = np.array([x1, v1, g, u, 0.0, 0.0, 1.0])
        for_method = symbols | {"K": getattr(method, "stiffness", 0.0)}
        assert value(sides(PAGES[49])[1], for_method) == pytest.approx(z @ forms.stored @ z + spring, rel=1e-12)


@compares(50)
def test_the_integral_of_a_power_over_twice_a_time():
    generator = np.zeros((7, 7))
    generator[:4] = separated_generator(PARAMETERS)
    powers = energy_forms(SYSTEM, ETA, Reference()).powers[0]
    changes, integrals = phase_integrals(generator, powers, np.array([0.7, 1.4]))
    moved = changes[0] + np.eye(7)
    for once, twice in zip(*integrals, strict=True):
        symbols = {"G(s)": Matrix(once), "E(s)ᵀ": Matrix(moved.T), "E(s)": Matrix(moved)}
        np.testing.assert_allclose(value(sides(PAGES[50], 2)[1], symbols).rows, twice, rtol=1e-10, atol=1e-12)


@compares(51)
def test_the_energy_that_steps_create():
    method = TimeStepping(700.0, 4.0, 80, HHT(-0.3))
    record = Record(3, method.steps)
    run = simulate(SYSTEM, ETA, method, periods=3, keep=3, record=record)
    x, v, force = run.trajectory.displacement, run.trajectory.velocity, run.trajectory.force
    c = uncompiled(coefficients)(parameters_of(SYSTEM, ETA, method))
    angle = ETA * run.trajectory.time
    found = np.array(
        [
            uncompiled(accelerations)(c, x1, v1, x2, v2, push, math.cos(w), math.sin(w))
            for x1, v1, x2, v2, push, w in zip(x[0], v[0], x[1], v[1], force, angle, strict=True)
        ]
    ).T
    created = 0.0
    for mass, *rows in zip((1.0, SYSTEM.mass_ratio), x, v, found, strict=True):
        position, speed, acceleration = rows
        symbols = {
            "mean ξ′": 0.5 * (speed[1:] + speed[:-1]),
            "Δξ′": np.diff(speed),
            "mean ξ″": 0.5 * (acceleration[1:] + acceleration[:-1]),
            "Δξ": np.diff(position),
        }
        created += mass * value(sides(PAGES[51])[1], symbols)
    per_period = created.reshape(3, -1).sum(axis=1)
    np.testing.assert_allclose(per_period, energy_balance(run).residual, rtol=1e-9, atol=1e-12)


def brackets(number):
    """The brackets of a difference of solutions, each an expression, and its left-hand side."""
    left, _, right = PAGES[number].partition(" = ")
    return left, re.findall(r"\[(.*?)\]", right)


def on_grid(found, system, method):
    """A run beside those of a comparison, (4, n) on their grid."""
    run = simulate(system, 1.08, method, periods=found.runs.penalty.periods, keep=6, initial=found.question.initial)
    return samples_on_grid(run, replace(found.grid, periods=6)).reshape(4, -1)


@compares(53, 56, 57)
def test_the_parts_of_a_difference():
    found = compare(ComparisonQuestion(System(), 1.08, Newmark(2500.0, 8.0, 2000), periods=300, keep=6))
    series, status, split = found.parts, found.split_time_step(), found.split()
    runs = series.runs
    names = {"Newmark(K, D, Δτ)": runs.penalty, "penalty(K, D, Δτ)": runs.penalty, "reference(e)": runs.derived}
    names |= {"exact penalty(K, D)": runs.exact, "reference(derived d₃)": runs.derived, "reference(d₃)": runs.reference}
    names |= {
        "steps with their status": runs.penalty,
        "the same steps located": on_grid(found, System(), status.located),
    }
    derived = Reference(joint_damping="derived")
    for name, e in (("e(ζ)", split.restitution), ("e°(ζ)", split.without_pull)):
        names[f"reference({name})"] = on_grid(found, System(restitution=e), derived)
    computed = {53: [getattr(series, part) for part in PARTS], 56: [status.status]}
    computed[57] = [split.contact_time, split.pulling, split.damper]
    for number, whole in ((53, series.total), (56, series.time_step), (57, series.regularisation)):
        left, each = brackets(number)
        np.testing.assert_allclose(value(left, names), whole, atol=1e-9)
        for bracket, part in zip(each, computed[number], strict=True):
            np.testing.assert_allclose(value(bracket, names), part, atol=1e-9)
    np.testing.assert_allclose(status.status + status.integrator, series.time_step, atol=1e-12)  # the rest
