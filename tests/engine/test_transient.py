"""Runs under pulses, sweeps and records: closed forms, a plain twin, convergence of steps, energy, and refusals."""

import math
from dataclasses import replace

import numpy as np
import pytest
from vibroscope import engine
from vibroscope.engine import (
    CONTACT_LAWS,
    HHT,
    LAWS_BY_RESTITUTION,
    TRBDF2,
    Bathe,
    CentralDifference,
    ExactPenalty,
    Excitation,
    GeneralisedAlpha,
    Load,
    Newmark,
    NewmarkBeta,
    Reference,
    System,
    TimeStepping,
    simulate,
    transient,
)

from tests import naive_load
from tests.law_numbers import law_numbers
from tests.naive_laws import Motion
from tests.naive_stepping import Twin
from tests.share import every

WALL = System(wall=True, d1=0.03, clearance=0.4, restitution=0.6)
PAIR = System(kappa=1.6, mu=0.7, d1=0.03, d2=0.02, d3=None, clearance=0.3, restitution=0.5)
PRESSED = System(
    kappa=1.6, mu=0.7, d1=0.03, d2=0.02, d3=None, clearance=-0.2, excitation=Excitation(constant1=0.1, constant2=-0.1)
)
TOUCHING = replace(PAIR, clearance=0.0)
RANDOM = np.random.default_rng(5)
TIMES = np.concatenate([[0.0], np.cumsum(RANDOM.uniform(0.05, 0.4, 60))])
LOADS = {
    "half-sine": Load.half_sine(-1.3, 2.2),
    "half-sine short": Load.half_sine(-9.0, 0.15),
    "trapezoid": Load.trapezoid(-1.1, 2.0, 0.3),
    "rectangle": Load.trapezoid(1.1, 2.0, 0.0),
    "sawtooth": Load.sawtooth(-1.5, 2.0),
    "record": Load.record(TIMES, RANDOM.normal(size=len(TIMES)) * 1.5),
    "late record": Load.record([0.0, 1.0, 1.5, 2.5], [0.0, 0.0, -3.0, 1.0]),
    "force 1": Load.half_sine(1.5, 2.0, on="force1"),
    "force off": Load.trapezoid(1.5, 2.0, 0.0, on="force1"),
}


OTHER = CONTACT_LAWS[1:]
METHODS = Reference("derived"), ExactPenalty(400.0, 3.0)
LAWS = {law: ExactPenalty(400.0, None if law in LAWS_BY_RESTITUTION else 3.0, law, **law_numbers(law)) for law in OTHER}


@pytest.mark.parametrize("duration", [0.3, 2.0, 5.0])
def test_a_half_sine_on_an_oscillator_has_its_closed_form(duration):
    """ξ″ + ξ = sin ωτ gives ξ = (sin ωτ − ω sin τ)/(1 − ω²); then free vibration of amplitude 2ω cos(d/2)/(1 − ω²)."""
    w = math.pi / duration
    found = transient(System(wall=True, d1=0.0, clearance=1e3), Load.half_sine(-1.0, duration), Reference(), free=9.0)
    time, x = found.response.trajectory.time, found.response.trajectory.displacement[0]
    during = time <= duration
    assert np.abs(x - (np.sin(w * time) - w * np.sin(time)) / (1 - w * w))[during].max() <= 1e-13
    amplitude = abs(2 * w * math.cos(duration / 2) / (1 - w * w))
    assert found.residual == pytest.approx((amplitude, 0.0), rel=1e-12)
    assert found.later_peaks[0] == pytest.approx(amplitude, rel=1e-6)


def test_what_is_left_decays_by_the_damper_and_does_not_hold_what_was_met_before():
    body, slow = replace(WALL, d1=0.2), Load.half_sine(-1.0, 12.0)
    early, late = (transient(replace(body, clearance=1e3), slow, Reference(), free=free) for free in (1.0, 4.0))
    assert late.residual[0] / early.residual[0] == pytest.approx(math.exp(-0.2 * 3.0))
    found = transient(body, slow, Reference())
    assert len(found.response.impacts)
    assert found.later_peaks[0] < found.peaks["displacement1"] == body.clearance


@pytest.mark.parametrize("logarithmic", [False, True])
def test_a_sine_sweep_has_the_phase_of_its_definition(logarithmic):
    begin, end, duration = 3.0, 1.0, 20.0
    time = np.linspace(0.0, duration, 500, endpoint=False)
    phase = begin * time + (end - begin) / duration * time**2 / 2
    if logarithmic:
        phase = begin * duration / math.log(end / begin) * ((end / begin) ** (time / duration) - 1)
    load = Load.sweep(2.0, begin, end, duration, logarithmic)
    np.testing.assert_allclose(load.at(time), 2.0 * np.sin(phase), atol=2.0 * 8e-5)
    assert load.end == pytest.approx(duration)


def test_chords_of_an_oscillation_miss_as_much_of_it_as_of_half_a_sine():
    run = transient(WALL, Load.sweep(0.1, 1.0, 1.0, 4 * math.pi), Newmark(400.0, 3.0, 20))
    assert run.load_missed == pytest.approx((2 * math.pi / 20) ** 2 / 12, rel=0.01)


@pytest.mark.parametrize("system", [WALL, PAIR, PRESSED, TOUCHING], ids=["wall", "pair", "pressed", "touching"])
@pytest.mark.parametrize("load", LOADS.values(), ids=LOADS.keys())
@pytest.mark.parametrize("method", METHODS, ids=["reference", "penalty"])
def test_the_plain_twin_has_the_same_events_and_end(system, load, method):
    if system is TOUCHING and load is LOADS["late record"]:
        pytest.skip("the twin cannot tell when bodies that touch at rest begin to move: the test below")
    found = transient(system, load, method, free=2.0).response
    events, end = naive_load.run(system, load, method, load.end + 2.0)
    assert found.ok
    assert np.abs(found.section[-1] - end).max() <= 2e-9
    impacts = [tau for tau, kind in events if kind == 0]
    assert len(found.impacts) == len(impacts)
    assert found.impacts.time == pytest.approx(impacts, abs=1e-8)


@pytest.mark.parametrize(
    ("system", "load"),
    [(PAIR, "record"), (WALL, "half-sine"), (PRESSED, "sawtooth"), (TOUCHING, "rectangle"), (PAIR, "force off")],
    ids=["pair", "wall", "pressed", "touching", "force"],
)
@pytest.mark.parametrize("law", every(OTHER))
def test_the_plain_twin_of_other_laws_has_the_same_contacts_and_end(system, load, law):
    method, load = LAWS[law], LOADS[load]
    if system in (PRESSED, TOUCHING) and method.damping is None:
        pytest.skip("a damper by the closing speed has none where bodies begin in contact")
    found, twin = transient(system, load, method, free=2.0), Motion(system, 1.0, method, load)
    end, contacts = twin.run(system.rest, load.end + 2.0), [c for c in twin.contacts if c[1] > c[0] + 1e-9]
    assert found.ok
    np.testing.assert_allclose(found.response.section[-1], end, atol=1e-10)
    np.testing.assert_allclose(found.response.contacts[: len(contacts)], np.reshape(contacts, (-1, 2)), atol=1e-9)
    assert np.abs(found.energy.residual).max() <= 1e-11 * found.energy.size


@pytest.mark.parametrize("law", ["cut", "hunt-crossley"])
def test_located_steps_of_a_law_between_two_stops_tend_to_its_exact_solution(law):
    system, exact = replace(WALL, clearance2=0.3, stiffness_factor2=2.0), LAWS[law]
    found = transient(system, LOADS["record"], exact, free=1.0).response
    assert {True, False} == set((found.impacts.impulse < 0).tolist())

    def error(steps):
        method = TimeStepping(400.0, exact.damping, steps, status="located", law=law)
        section = transient(system, LOADS["record"], method, free=1.0).response.section
        return np.abs(section[-1] - found.section[-1]).max()

    assert error(16_000) <= 0.1 * error(4000) <= 1e-3


def test_a_short_shock_is_a_change_of_speed_and_its_impulse_depends_on_no_frequency():
    soft = System(wall=True, d1=0.0, clearance=0.01, restitution=0.5)
    found = engine.shock_response(soft, Load.trapezoid(-1.0, 0.1, 0.0), [0.01, 0.02])
    assert found.impulse == pytest.approx([1.5 * 0.1] * 2, rel=1e-4)


@pytest.mark.parametrize("method", [*METHODS, *(LAWS[law] for law in ("cut", "limited", "hunt-crossley", "impact"))])
@pytest.mark.parametrize("system", [WALL, TOUCHING], ids=["wall", "touching"])
def test_a_quiet_beginning_of_a_record_only_delays_the_motion(system, method):
    quiet = LOADS["late record"]
    at_once = Load.record(quiet.segments[1:, 0] - 1.0, [0.0, -3.0, 1.0])
    late, early = (transient(system, load, method).response for load in (quiet, at_once))
    assert np.abs(late.section - early.section).max() <= 1e-12
    assert late.contacts[:, 1] == pytest.approx(early.contacts[:, 1] + 1.0, abs=1e-12)


@pytest.mark.parametrize("load", [LOADS["half-sine"], LOADS["record"], LOADS["force off"]], ids=str)
@pytest.mark.parametrize("system", [WALL, PAIR], ids=["wall", "pair"])
@pytest.mark.parametrize("method", METHODS, ids=["reference", "penalty"])
def test_the_energy_balance_closes(system, load, method):
    found = transient(system, load, method).energy
    assert np.abs(found.residual).max() <= 1e-11 * found.size


@pytest.mark.parametrize(
    ("integrator", "order"),
    [
        (NewmarkBeta(), 2),
        (HHT(alpha=-0.1), 2),
        (GeneralisedAlpha(rho=0.8), 2),
        (Bathe(), 2),
        (TRBDF2(), 2),
        (CentralDifference(), 1),  # its dampers lag
    ],
    ids=str,
)
@pytest.mark.parametrize("load", [LOADS["half-sine"], LOADS["late record"]], ids=str)
def test_steps_tend_to_the_exact_solution(integrator, order, load):
    """Of the method's order where steps are cut at contact changes, else of the first."""
    exact = transient(WALL, load, ExactPenalty(400.0, 3.0)).response.section[-1]

    def error(steps, status):
        method = TimeStepping(400.0, 3.0, steps, integrator=integrator, status=status)
        return np.abs(transient(WALL, load, method).response.section[-1] - exact).max()

    assert error(4000, "located") <= 1.3 * 0.5**order * error(2000, "located") <= 3e-3
    assert error(16000, "start") <= 2e-3


@pytest.mark.parametrize("integrator", [NewmarkBeta(), Bathe()], ids=str)
def test_steps_without_a_solution_are_halved_as_the_twin_does(integrator):
    load = LOADS["record"]
    found = transient(PAIR, load, TimeStepping(100.0, 20.0, 60, integrator, "end", "halve"), free=3.0).response

    class Loaded(Twin):
        def load_of(self, first, second):
            times = np.linspace(0.0, found.period, self.method.steps + 1)
            return lambda tau: -np.array([1.0, self.mu]) * np.interp(tau, times, load.at(times))

    twin = Loaded(PAIR, found.eta, found.method)
    np.testing.assert_allclose(found.section, twin.run(1), atol=1e-11)
    assert found.steps_without_solution == twin.none > 0


def test_average_acceleration_creates_no_energy_without_contact():
    found = transient(System(wall=True, d1=0.01, clearance=1e3), LOADS["record"], Newmark(100.0, 1.0, 200)).energy
    assert np.abs(found.residual).max() <= 1e-12 * found.size


def test_a_force_that_ends_at_once_releases_the_body_at_once():
    """A body is pushed to the wall and rests there; where the force drops to zero its spring pulls it back."""
    found = transient(WALL, Load.trapezoid(2.0, 60.0, 0.0, on="force1"), Reference(), free=5.0)
    assert found.response.contacts[-1, 1] == pytest.approx(60.0, abs=1e-9)
    assert found.response.section[-1, 0] == pytest.approx(
        0.4
        * math.exp(-0.03 * 5)
        * (math.cos(w := 5 * math.sqrt(1 - 0.03**2)) + 0.03 / math.sqrt(1 - 0.03**2) * math.sin(w)),
        abs=1e-9,
    )


def test_a_long_record_may_have_more_impacts_than_a_period():
    """A ball on a table that is shaken at random: events are counted anew with each sample."""
    ball = System(wall=True, spring1=0.0, restitution=0.95, excitation=Excitation(constant1=1.0))
    times = np.arange(0.0, 60_000.0, 2.0)
    load = Load.record(times, np.random.default_rng(2).normal(size=len(times)) * 0.6)
    found = transient(ball, load, Reference(threshold=0.0))
    assert found.ok
    assert len(found.response.impacts) > 100_000


def test_peaks_lie_between_samples():
    found = transient(System(wall=True, d1=0.0, clearance=1e3), Load.half_sine(-1.0, 2.0), Reference(), free=9.0)
    w = math.pi / 2
    assert found.peaks["displacement1"] == pytest.approx(abs(2 * w * math.cos(1.0) / (1 - w * w)), rel=1e-6)


DRIVEN = replace(WALL, excitation=Excitation(load=LOADS["half-sine"]))


@pytest.mark.parametrize(
    "ask",
    [
        lambda: simulate(DRIVEN, 1.0, Reference()),
        lambda: engine.motion(DRIVEN, 1.0, Reference()),
        lambda: engine.steady(DRIVEN, 1.0, Reference()),
        lambda: engine.lyapunov(DRIVEN, 1.0, Reference()),
        lambda: engine.attractors(DRIVEN, 1.0, Reference(), starts=1),
        lambda: engine.run_cells(engine.Cells(DRIVEN, [1.0], Newmark(100.0, 1.0, 100)), transient=2, sample=2),
        lambda: engine.sweep(engine.EtaStudy(DRIVEN, Reference(), values=[1.0], transient=2, sample=4)),
        lambda: engine.compare(engine.ComparisonQuestion(DRIVEN, 1.0, Newmark(100.0, 1.0, 100))),
        lambda: engine.recommend(engine.SettingQuestion(DRIVEN, 1.0)),
    ],
)
def test_what_needs_a_period_is_refused(ask):
    with pytest.raises(ValueError, match="has no period"):
        ask()


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: Load.half_sine(1.0, 0.0), "duration = 0.0 is outside"),
        (lambda: Load.trapezoid(1.0, 1.0, 0.6), "rise = 0.6 is outside"),
        (lambda: Load.record([0.0, 2.0, 1.0], [0.0, 1.0, 0.0]), "sample 3"),
        (lambda: Load.record([0.0, 2.0], [0.0, math.nan]), "sample 2"),
        (lambda: Load.record([0.0], [0.0]), "2 to"),
        (lambda: Load.half_sine(1.0, 1.0, on="wall"), "on = 'wall' is not one of"),
        (lambda: transient(WALL, LOADS["record"], Reference(), free=-1.0), "free = -1.0 is outside"),
    ],
)
def test_bad_input_is_refused_in_words(make, words):
    with pytest.raises(ValueError, match=words):
        make()
