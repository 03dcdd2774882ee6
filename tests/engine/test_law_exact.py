"""Exact penalty solutions with each contact law: their plain twin, impulses and energy, checkpoints, bad input."""

import numpy as np
import pytest
from vibroscope.engine import (
    CONTACT_LAWS,
    LAWS_BY_RESTITUTION,
    Cells,
    ComparisonQuestion,
    ExactPenalty,
    Excitation,
    Newmark,
    Record,
    System,
    TimeStepping,
    compare,
    lyapunov,
    motion,
    run_cells,
    simulate,
    steady,
)
from vibroscope.engine.energy.balance import energy_balance
from vibroscope.engine.motions.description import peak_force

from tests.law_numbers import law_numbers
from tests.naive_laws import Motion, force, gain_of
from tests.share import every

OTHER = CONTACT_LAWS[1:]
SECOND_ORDER = "limited", "constant-restitution", "impact"
APART = (0.0, 0.0, 1.0, -1.0)


def method_of(law, stiffness=1200.0, damping=8.0, kind=ExactPenalty, **more):
    """A method with this law, its D None where the law has a formula for it."""
    numbers = law_numbers(law, {"impact": 2.2, "constant-restitution": 2.0}.get(law))
    steps = {} if kind is ExactPenalty else {"steps": more.pop("steps")}
    damping = None if law in LAWS_BY_RESTITUTION else damping
    return kind(stiffness, damping, **steps, law=law, **numbers, **more)


def near_wall():
    """A body and a wall with a clearance, moved by a force with a constant part."""
    return System(wall=True, d1=0.05, clearance=0.4, excitation=Excitation(base=0.0, force1=2.0, constant1=0.3))


@pytest.mark.parametrize("wall", [False, True], ids=["two bodies", "wall"])
@pytest.mark.parametrize("law", every(CONTACT_LAWS))
def test_the_motion_is_that_of_the_twin(law, wall):
    system, start, eta = (near_wall(), (0.0, 0.5, 0.0, 0.0), 1.3) if wall else (System(), APART, 2.76)
    method = method_of(law)
    run = simulate(system, eta, method, periods=2, keep=2, initial=start)
    twin = Motion(system, eta, method)
    expected = twin.run(start, 2 * run.period)
    np.testing.assert_allclose(run.section[-1], expected, atol=1e-10)
    assert len(twin.contacts) >= 2
    np.testing.assert_allclose(run.contacts[: len(twin.contacts)], twin.contacts, atol=1e-10)
    np.testing.assert_allclose(run.impacts.impulse[: len(twin.impulses)], twin.impulses, rtol=1e-9)


@pytest.mark.parametrize("wall", [False, True], ids=["two bodies", "wall"])
@pytest.mark.parametrize(
    ("penetration", "exponent", "damping"),
    every(
        [
            (0.01, 1.5, 8.0),
            (0.02, 1.5, 30.0),
            (0.003, 3.0, 2.0),
            (0.01, 2.2, 8.0),
            (0.001, 1.5, 18.0),
            (1e-5, 1.5, 18.0),
        ]
    ),
)
def test_steps_end_at_the_kinks_of_impact(penetration, exponent, damping, wall):
    """The penetration of full damping is passed both ways; the force is cut, and sets in again before the end."""
    system, start, eta = (near_wall(), (0.0, 0.5, 0.0, 0.0), 1.3) if wall else (System(), APART, 2.76)
    method = ExactPenalty(1200.0, damping, "impact", exponent=exponent, penetration=penetration)
    run = simulate(system, eta, method, periods=1, keep=1, initial=start)
    twin = Motion(system, eta, method)
    np.testing.assert_allclose(run.section[-1], twin.run(start, run.period), rtol=0, atol=2e-12)
    assert len(twin.contacts) == len(run.contacts) > 0


@pytest.mark.parametrize("damping", [34.0, 34.1])
def test_a_cut_within_one_step_is_seen(damping):
    """The force of "impact" pulls for less than a step, in which both ends push."""
    method = ExactPenalty(12000.0, damping, "impact", exponent=1.5, penetration=0.003)
    run = simulate(System(), 2.76, method, periods=1, keep=1, initial=APART)
    expected = Motion(System(), 2.76, method).run(APART, run.period)
    np.testing.assert_allclose(run.section[-1], expected, rtol=0, atol=1e-11)


@pytest.mark.parametrize(("stiffness", "damping"), [(1200.0, None), (1200.0, 60.0), (40000.0, 30.0)])
def test_where_the_damper_of_jankowski_ends_no_digit_is_lost(stiffness, damping):
    """The twin's steps end where the bodies begin to part."""
    method = ExactPenalty(stiffness, damping, "jankowski")
    run = simulate(System(), 2.76, method, periods=1, keep=1, initial=APART)
    expected = Motion(System(), 2.76, method).run(APART, run.period)
    np.testing.assert_allclose(run.section[-1], expected, rtol=0, atol=4e-12)


@pytest.mark.parametrize(
    ("law", "eta", "stiffness", "damping"),
    [("limited", 1.4, 30.0, 6.0), ("cut", 1.4, 100.0, 6.0), ("compression", 0.7, 100.0, 3.0)],
)
def test_a_contact_enters_pieces_again(law, eta, stiffness, damping):
    """The force sets in again, the damper reaches its limit again, the bodies close again before they have parted."""
    system, start = System(clearance=-0.3, d1=0.05, d2=0.05), (-1.0, 0.0, 1.0, 0.0)
    method = method_of(law, stiffness, damping)
    run = simulate(system, eta, method, periods=3, keep=3, initial=start)
    expected = Motion(system, eta, method).run(start, 3 * run.period)
    np.testing.assert_allclose(run.section[-1], expected, atol=1e-9)


@pytest.mark.parametrize("law", OTHER)
def test_what_the_excitation_gives_is_stored_or_lost(law):
    system = System(clearance=-0.05, excitation=Excitation(base=0.3))  # preloaded: it starts in contact
    run = simulate(system, 1.4, method_of(law), periods=12, keep=4)
    balance = energy_balance(run)
    assert balance.contact.max() > 0
    assert np.abs(balance.residual).max() < 1e-11 * balance.size


@pytest.mark.parametrize("law", OTHER)
def test_samples_have_the_force_of_the_law(law):
    system, method = System(), method_of(law)
    run = simulate(system, 2.76, method, periods=2, keep=2, initial=APART, record=Record(2, 4000))
    sampled, closing = run.trajectory, run.impacts.closing_speed
    depth, speed = -np.diff(sampled.displacement, axis=0)[0], -np.diff(sampled.velocity, axis=0)[0]
    last = np.searchsorted(run.impacts.time, sampled.time) - 1
    pressed = np.flatnonzero(depth > 0)[::7]
    assert len(pressed) > 3
    for i in pressed:
        gain = gain_of(method, system.restitution, system.mass_share, closing[last[i]])
        assert sampled.force[i] == pytest.approx(force(method, gain, depth[i], speed[i]), rel=1e-9, abs=1e-9)
    assert not sampled.force[depth < 0].any()
    assert peak_force(run) >= sampled.force.max()
    total = np.trapezoid(sampled.force, sampled.time)
    assert run.impacts.impulse.sum() == pytest.approx(total, rel=0.02)


@pytest.mark.parametrize("law", OTHER)
def test_steps_tend_to_it(law):
    """Of second order where force and damper begin at zero, else of first, by when a touch is seen."""
    exact = simulate(System(), 2.76, method_of(law), periods=1, keep=1, initial=APART).section[-1]
    errors = []
    for steps in (1600, 3200, 25600, 51200):
        method = method_of(law, kind=TimeStepping, steps=steps, status="end", without_solution="keep")
        assert method.limit == method_of(law)
        found = simulate(System(), 2.76, method, periods=1, keep=1, initial=APART).section[-1]
        errors.append(np.abs(found - exact).max())
    assert max(errors[2:]) < max(errors[:2]) / (100 if law in SECOND_ORDER else 4)


def test_the_steady_motion_is_where_a_run_comes_to():
    method = method_of("cut", 2500.0)
    found = steady(System(), 1.08, method)
    run = simulate(System(), 1.08, method, periods=400, keep=1)
    assert found.stable
    np.testing.assert_allclose(found.state, run.section[-1], atol=1e-9)
    described = motion(System(), 1.08, method)
    assert described.period == 1
    assert described.energy_lost > 0
    near = lyapunov(System(), 1.08, method, initial=found.state, periods=256)
    assert near.exponent == pytest.approx(np.log(np.abs(found.multipliers[0])), abs=0.02)


def test_a_law_that_remembers_the_closing_speed_has_no_map():
    method = method_of("flores", 200.0)
    described = motion(System(), 2.76, method)
    assert described.near_period
    assert described.energy_lost > 0
    with pytest.raises(ValueError, match=r"^the damper of the law 'flores' depends .*; give D$"):
        steady(System(), 2.76, method)
    assert steady(System(), 2.76, ExactPenalty(1200, 200, "flores")).periodic


def test_without_a_damper_the_piecewise_linear_laws_are_one():
    runs = [simulate(System(), 2.76, ExactPenalty(900, 0, law), periods=9, keep=9) for law in CONTACT_LAWS[:4]]
    for run in runs[1:]:
        np.testing.assert_array_equal(run.section, runs[0].section)


def test_comparison_and_cells_know_the_law():
    found = compare(ComparisonQuestion(System(), 1.08, Newmark(2500, 8, 2000, law="cut"), periods=300, keep=4))
    assert found.runs.exact.method == ExactPenalty(2500, 8, "cut")
    assert found.residual < 1e-9
    assert 0 < np.abs(found.parts.time_step).max() < 0.1
    cells = Cells(System(), [1.08, 1.08], ExactPenalty(1, 1, "limited"), [2500, 2400], [8, 9])
    cells = run_cells(cells, transient=300, sample=4)
    alone = simulate(System(), 1.08, ExactPenalty(2400, 9, "limited"), periods=304, keep=4)
    np.testing.assert_allclose(cells.section[1], alone.section, atol=1e-12)


def test_a_method_is_written_as_before():
    assert str(ExactPenalty(100, 1)) == "ExactPenalty(stiffness=100.0, damping=1.0)"
    assert str(ExactPenalty(100, None, "flores")) == "ExactPenalty(stiffness=100.0, damping=None, law='flores')"


@pytest.mark.parametrize("penetration", [1e-8, 1e-4, 1e-3])
@pytest.mark.parametrize("damping", [1.0, 18.0, 60.0])
def test_a_cut_that_ends_just_before_the_contact_does_is_passed(penetration, damping):
    """The force sets in again so late, or later than rounding shows, that the step to there is all but the last."""
    method = ExactPenalty(12000.0, damping, "impact", exponent=1.5, penetration=penetration)
    assert simulate(System(), 2.76, method, periods=30, keep=1).ok
