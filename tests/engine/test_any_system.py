"""Systems with clearance or preload, walls, phases and forces: what must hold whatever the numbers are."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from vibroscope.engine import (
    Cells,
    ExactPenalty,
    Excitation,
    Newmark,
    Record,
    Reference,
    Status,
    System,
    run_cells,
    simulate,
)
from vibroscope.engine.energy.balance import energy_balance
from vibroscope.engine.sweeps.eta_study import EtaStudy

from tests import naive
from tests.share import share
from tests.systems_strategy import amplitudes, excitations, general_systems, phases, two_bodies

REFERENCE = Reference("derived")
METHODS = (
    REFERENCE,
    ExactPenalty(700.0, 6.0),
    Newmark(700.0, 6.0, 400),
    Newmark(700.0, 6.0, 400, every_step=True),
    Newmark(700.0, 6.0, 400, located=True),
)
etas = st.floats(0.3, 3).map(lambda value: round(value, 3))
some = settings(max_examples=share(25))


def run(system, eta, method, periods=4, **more):
    return simulate(system, eta, method, periods=periods, keep=periods, **more)


@some
@given(general_systems, etas, st.sampled_from(METHODS[:2]))
def test_a_clearance_that_nothing_spans_leaves_linear_oscillators(system, eta, method):
    far = replace(system, clearance=1e4)
    start = (0.3, -0.2, *((0.0, 0.0) if system.wall else (-0.5, 0.7)))
    response = run(far, eta, method, initial=start)
    assert response.ok
    assert len(response.impacts) == len(response.contacts) == 0
    end = response.window[1]
    for body, (load, constant) in enumerate(naive.drive(far, eta)[: 1 if system.wall else 2]):
        frequency, damping = (1.0, far.d1) if body == 0 else (far.kappa, far.d2)
        assume(abs(frequency - eta) > 0.05)  # the textbook's steady amplitude loses its digits at resonance
        motion = naive.oscillator(frequency, damping, eta, 0.0, *start[2 * body : 2 * body + 2], load, constant)
        expected, size = motion(end), 1 + sum(map(abs, load)) + abs(constant)
        bound = 1e-13 * size * (1 + end) / min(abs(frequency - eta), 1.0)
        bound += body * np.finfo(float).eps * far.clearance  # body 2 is found from the gap, which is rounded
        np.testing.assert_allclose(response.section[-1][2 * body : 2 * body + 2], expected, rtol=0, atol=bound)


@pytest.mark.parametrize("method", METHODS, ids=str)
@pytest.mark.parametrize("clearance", [1e-9, -1e-9])
def test_a_vanishing_clearance_joins_on_to_none(method, clearance):
    without, with_it = (run(System(clearance=g), 2.76, method, periods=2) for g in (0.0, clearance))
    np.testing.assert_allclose(with_it.section, without.section, atol=2e-6)
    real, other = (each.impacts.closing_speed > 1e-3 for each in (with_it, without))
    assert real.sum() == other.sum() > 0


@some
@given(st.floats(0.01, 0.2), amplitudes, phases, amplitudes, amplitudes, etas, st.sampled_from(METHODS))
def test_mirrored_bodies_meet_as_one_body_meets_a_wall(damping, force, phase, constant, clearance, eta, method):
    """Two equal bodies driven against each other; the contact has half the stiffness, and twice the clearance."""
    drive = {"base": 0.0, "force1": force, "force1_phase": phase, "constant1": constant}
    wall = System(wall=True, d1=damping, clearance=clearance, excitation=Excitation(**drive))
    mirrored = {"force2": -force, "force2_phase": phase, "constant2": -constant}
    both = System(
        1.0, damping, damping, mu=1.0, d3=None, clearance=2 * clearance, excitation=Excitation(**drive, **mirrored)
    )
    if method is not REFERENCE:
        halved = replace(method, stiffness=method.stiffness / 2, damping=method.damping / 2)
    else:
        halved, method = Reference("derived", threshold=0.004), Reference("derived")
    one, two = run(wall, eta, method, periods=2), run(both, eta, halved, periods=2)
    np.testing.assert_allclose(two.section[:, :2], one.section[:, :2], atol=1e-9)
    np.testing.assert_allclose(two.section[:, 2:], -one.section[:, :2], atol=1e-9)
    assert len(one.impacts) == len(two.impacts)


def exchanged(system):
    """The same system with the bodies in each other's place, in units of the new body 1, mirrored."""
    e, k = system.excitation, system.kappa
    stiffness = system.mass_ratio * k**2  # k₂/k₁, by which forces are counted in new units
    return System(
        1 / k,
        system.d2,
        system.d1,
        mu=1 / system.mass_ratio,
        d3=None,
        restitution=system.restitution,
        clearance=system.clearance,
        excitation=Excitation(
            -e.base, e.base_phase, -e.force2 / stiffness, e.force2_phase, -e.force1 / stiffness, e.force1_phase,
            -e.constant2 / stiffness, -e.constant1 / stiffness,
        ),
    )  # fmt: skip


@some
@given(two_bodies, etas)
def test_exchanged_bodies_mirror_the_motion(system, eta):
    k = system.kappa
    # a penalty contact: a chain of impacts would amplify rounding
    method, other = (
        ExactPenalty(300.0, 9.0),
        ExactPenalty(300.0 / (system.mass_ratio * k**2), 9.0 / (system.mass_ratio * k)),
    )
    one, two = run(system, eta, method, periods=2), run(exchanged(system), eta / k, other, periods=2)
    mirrored = -two.section[:, [2, 3, 0, 1]] * [1, k, 1, k]
    size = 1 + np.abs(one.section).max()
    np.testing.assert_allclose(mirrored, one.section, atol=1e-8 * size)


@some
@given(general_systems, etas, st.integers(1, 63), st.sampled_from(METHODS[:2]))
def test_phases_say_where_time_begins(system, eta, lag, method):
    """A run that starts from a later state of another one goes on as that one, all phases being later by as much."""
    record, e, angle = Record(2, 64), system.excitation, 2 * math.pi * lag / 64
    first = run(system, eta, method, periods=2, record=record)
    (x1, x2), (v1, v2) = first.trajectory.displacement[:, lag], first.trajectory.velocity[:, lag]
    assume(first.ok and (method is not REFERENCE or system.gap(x1, x2) > 1e-6))  # at g = 0 rounding decides
    later = {name: getattr(e, name) + angle for name in ("base_phase", "force1_phase", "force2_phase")}
    shifted = replace(system, excitation=replace(e, **later))
    again = run(shifted, eta, method, periods=1, initial=(x1, v1, x2, v2), record=Record(1, 64))
    expected, found = first.trajectory.displacement[:, lag : lag + 65], again.trajectory.displacement
    np.testing.assert_allclose(found, expected, atol=1e-8 * (1 + np.abs(expected).max()))


@some
@given(general_systems, etas)
def test_every_step_is_that_of_the_textbook(system, eta):
    n, periods = 120, 2
    states, _ = naive.newmark(system, eta, 700.0, 6.0, n, periods * n)
    for method in (Newmark(700.0, 6.0, n, every_step=True), Newmark(700.0, 6.0, n)):
        response = run(system, eta, method, periods=periods, record=Record(periods, n))
        assume(response.ok)
        size = 1 + np.abs(states).max()
        np.testing.assert_allclose(response.trajectory.displacement.T, states[:, [0, 2]], atol=1e-8 * size)


@some
@given(general_systems, etas, st.sampled_from(METHODS[:2]))
def test_the_energy_balance_closes(system, eta, method):
    response = run(system, eta, method, periods=6)
    assume(response.ok)
    balance = energy_balance(response)
    assert np.abs(balance.residual).max() <= 1e-11 * max(balance.size, 1e-12)


@some
@given(general_systems, etas, st.sampled_from(METHODS[:3]))
def test_many_cells_are_single_runs(system, eta, method):
    response = simulate(system, eta, method, periods=12, keep=3)
    found = run_cells(Cells(system, [eta], method), transient=9, sample=3, threads=1, recurrence=0)
    assert found.ok[0] == response.ok
    if response.ok:
        np.testing.assert_array_equal(found.section[0], response.section)


@some
@given(general_systems, excitations)
def test_rest_is_a_static_equilibrium(system, excitation):
    """Without what changes with time nothing moves, pressed together or not."""
    still = replace(excitation, base=0.0, force1=0.0, force2=0.0)
    resting = replace(system, excitation=still)
    response = run(resting, 1.3, REFERENCE, periods=3)
    np.testing.assert_allclose(response.section, np.tile(resting.rest, (3, 1)), atol=1e-12)
    assert (len(response.contacts) == 1) == (resting.static_gap <= 0)


@pytest.mark.parametrize("periods", [3, 300])
def test_a_preload_that_never_opens_is_one_contact_in_closed_form(periods):
    """At a wall nothing moves; two bodies swing as one, of frequency κ₃, about where they rest."""
    for system in (System(clearance=-60.0), System(wall=True, clearance=-60.0)):
        response = simulate(system, 1.4, Reference(), periods=periods, keep=3)
        assert response.ok
        assert len(response.impacts) == 0
        np.testing.assert_array_equal(response.contacts, [[0.0, response.window[1]]])
        from_rest = np.zeros(2)
        if not system.wall:
            from_rest = naive.oscillator(system.kappa3, system.d3, 1.4, 0.0, 0.0, 0.0)(response.window[1])
        expected = np.add(system.rest, np.tile(from_rest, 2))
        np.testing.assert_allclose(response.section[-1], expected, rtol=0, atol=1e-13 * (60 + response.window[1]))


@pytest.mark.parametrize("threshold", [0.0, 0.002])
@pytest.mark.parametrize(("eta", "phase"), [(0.5, 1.0), (1.0, 1.0), (3.0, -1000.0)])
def test_a_force_that_just_reaches_the_preload_leaves_the_body_at_the_wall(eta, phase, threshold):
    """Once a period the contact force is zero, where rounding decides its sign."""
    pull = Excitation(base=0.0, force1=-1.0, force1_phase=phase)
    held = System(wall=True, clearance=-1.0, d1=0.0, excitation=pull)
    response = simulate(held, eta, Reference("derived", threshold=threshold), periods=400, keep=400)
    assert response.ok, response.message
    np.testing.assert_allclose(response.section, np.tile(held.rest, (400, 1)), rtol=0, atol=1e-12)
    assert response.impacts.closing_speed.max(initial=0.0) < 1e-7
    apart = 400 * response.period - np.diff(response.contacts).sum()
    assert 0.0 <= apart < 1e-4 * response.period


def test_a_time_step_may_feed_a_free_vibration_that_dies_away_without():
    """So that Newmark's cells that nothing drives cannot be taken to come to rest (`engine.motions.trapping`)."""
    body = System(wall=True, d1=0.01, clearance=0.2, excitation=Excitation(base=0.0))
    start = {"periods": 400, "initial": (-1.0, 0.5, 0.0, 0.0)}
    assert run(body, 1.0, Newmark(12000.0, 18.0, 100), **start).status is Status.DIVERGED
    without = run(body, 1.0, ExactPenalty(12000.0, 18.0), **start)
    np.testing.assert_allclose(without.section[-1], body.rest, atol=1e-9)


def test_a_joint_damping_that_the_dampers_contradict_ends_the_run_with_a_line_on_any_bodies():
    """No joint damper, and a strong one on body 2 alone: while it is joined to body 1, it pulls."""
    system = System.from_mass_ratio(1.0, kappa=2.0, d1=0.0, d2=0.9, d3=0.0)
    ended = run(system, 0.7, Reference("table"), periods=40)
    assert not ended.ok
    assert "the joined bodies would part into each other" in ended.message
    assert "take the derived joint damping" in ended.message
    assert "\n" not in ended.message
    assert run(system, 0.7, Reference("derived"), periods=40).ok


def test_a_reference_cannot_start_in_an_overlap():
    with pytest.raises(ValueError, match=r"clearance \+ ξ₂ − ξ₁ = -0\.5 is negative"):
        run(System(clearance=-0.5), 1.0, REFERENCE, initial=(0.0, 0.0, 0.0, 0.0))
    with pytest.raises(ValueError, match=r"clearance − ξ₁ = -1\.5 is negative"):
        run(System(clearance=0.5, wall=True), 1.0, REFERENCE, initial=(2.0, 0.0, 0.0, 0.0))


@pytest.mark.parametrize(("start", "name"), [((0.0, 0.0, 1.0, 0.0), "ξ₂ = 1"), ((0.0, 0.0, 0.0, -2.0), "ξ₂′ = -2")])
def test_a_wall_has_no_start(start, name):
    with pytest.raises(ValueError, match=f"initial {name}: a wall does not move"):
        run(System(wall=True, clearance=0.5), 1.0, REFERENCE, initial=start)


def test_a_continued_sweep_goes_on_from_a_motion_that_has_grown_beyond_any_start():
    """In one piece or in two: the border between them changes nothing."""
    system = System(clearance=1e6, d1=1e-4, d2=1e-4, excitation=Excitation(base=0.0, force1=1e6))
    study = EtaStudy(system, REFERENCE, values=[1.0, 1.001, 1.002], transient=400, sample=2, direction="up")
    whole = study.compute((slice(0, 3),))
    assert np.abs(whole["end"][1]).max() > 1e6
    before = study.compute((slice(0, 2),))
    after = study.compute((slice(2, 3),), before=before)
    np.testing.assert_array_equal(after["end"][0], whole["end"][2])
