"""Measured motion: aligned with a cycle, analysed without one, and compared with both solutions."""

import re
from dataclasses import replace

import numpy as np
import pytest
from vibroscope.app.explorer.measured import comparison_rows
from vibroscope.engine import (
    Excitation,
    Measurement,
    Newmark,
    Record,
    Reference,
    System,
    compare_measured,
    fit,
    measured_verdict,
    motion,
    parse_measurement,
    percent,
    simulate,
    synthetic_measurement,
)
from vibroscope.engine.measurement.cycle import align, reference_cycle
from vibroscope.engine.measurement.recurrence import recurrence, summarise_sensor

from tests.share import every

# ------------------------------------------------------------------------------------------------------ alignment


def test_without_a_known_mean_no_residual_has_one():
    made = synthetic_measurement(System(), 1.08, noise=0.05, periods=4)
    unknown, moved = replace(made, mean_known=False), made.displacement + np.array([[0.3], [-2.0]])
    assert unknown.residual(moved) == pytest.approx(np.zeros(moved.shape), abs=1e-12)
    assert made.residual(moved) == pytest.approx(made.displacement - moved)


def test_every_sample_has_a_displacement():
    time = np.arange(5.0)
    for shape in ((2, 4), (2, 6), (3, 5), (5,)):
        with pytest.raises(ValueError, match=re.escape("displacement has the shape")):
            Measurement(time, np.zeros(shape), None, "absolute")
    with pytest.raises(ValueError, match="contact has the shape"):
        Measurement(time, np.zeros((2, 5)), np.zeros(4), "absolute")


@pytest.mark.parametrize(
    ("eta", "frame"), every((eta, frame) for frame in ("relative", "absolute") for eta in (1.08, 2.76, 3.25))
)
def test_the_phase_of_a_synthetic_measurement_is_found(eta, frame):
    _, cycle = reference_cycle(System(), eta, Reference())
    for phase in np.linspace(0.01, 0.99, 5) * cycle.length:
        made = synthetic_measurement(System(), eta, phase=phase, noise=0.0, frame=frame)
        found = align(cycle, made)
        assert found.phase == pytest.approx(phase, abs=1e-7)
        assert found.rms < 1e-7
        assert found.closing_error < 1 / 200  # a sample
        measured = summarise_sensor(made.time, made.contact, eta)
        assert found.sensor.per_period == pytest.approx(measured.per_period)
        assert found.sensor.share == pytest.approx(measured.share)


def test_the_cycle_is_accurate_between_its_samples():
    """Compared with a run that continues the steady motion with five times as many samples."""
    _, cycle = reference_cycle(System(), 1.08, Reference())
    start = cycle.response.section[-1]
    run = simulate(System(), 1.08, Reference(), periods=2, keep=1, initial=start, record=Record(1, 10_000))
    time = run.trajectory.time - run.window[0]
    assert cycle.displacement(time[:-1]) == pytest.approx(run.trajectory.displacement[:, :-1], abs=1e-6)
    at_impact = np.abs(time[:, None] - cycle.closings).min(axis=1) < 1e-6
    smooth = ~at_impact & (time > 0) & (time < cycle.length)
    assert cycle.velocity(time[smooth]) == pytest.approx(run.trajectory.velocity[:, smooth], abs=1e-4)


def test_the_error_of_the_frequency_of_a_sine_is_the_least_that_noise_allows():
    """Cramér–Rao bound (Rife & Boorstyn 1974), for two bodies with one frequency: √12 σ/(A T √n)."""
    eta, noise, n = 2.76, 0.05, 600
    time = np.linspace(0.0, 30 * 2 * np.pi / eta, n)
    shown = np.stack([np.cos(eta * time), np.sin(eta * time)]) + np.random.default_rng(3).normal(0.0, noise, (2, n))
    found = recurrence(Measurement(time, shown, None, "relative"), eta)
    assert found.eta_error == pytest.approx(np.sqrt(12 / n) * noise / time[-1], rel=0.05)
    assert abs(found.eta - eta) < 3 * found.eta_error


def test_noise_period_and_frequency_of_a_measurement_are_found():
    for eta, noise, period in ((1.08, 0.05, 1), (2.76, 0.05, 1), (3.25, 0.05, 2), (3.25, 0.2, 2)):
        found = recurrence(synthetic_measurement(System(), eta, noise=noise, periods=12, seed=3), eta)
        assert found.period == period
        assert found.noise == pytest.approx(noise, rel=0.1)
        assert found.eta == pytest.approx(eta, rel=1e-3)


@pytest.mark.parametrize(("noise", "found"), [(0.0, 0.0), (1e-13, 0.0), (1e-9, pytest.approx(1e-9, rel=0.1))])
def test_data_without_noise_have_none(noise, found):
    time = np.linspace(0, 8 * 2 * np.pi / 1.3, 400)
    exact = np.stack([2 * np.cos(1.3 * time), np.sin(1.3 * time + 0.2)])
    rows = exact + noise * np.random.default_rng(0).standard_normal(exact.shape)
    measurement = Measurement(time, rows, None, "absolute")
    assert recurrence(measurement, 1.3).noise == found
    compared = compare_measured(System(clearance=50.0), 1.3, measurement, Newmark(200, 5, 200))
    assert (comparison_rows(compared)[2][1] == "no noise beyond rounding") == (found == 0.0)


@pytest.mark.parametrize("per_period", [6, 8, 10, 13.3, 20])
@pytest.mark.parametrize("periods", [4, 8, 20])
def test_few_samples_a_period_show_the_period_and_the_frequency(per_period, periods):
    """At 10 samples a period, 9 of 10 motions of one period were once taken for motions of four."""
    for eta, period in ((2.76, 1), (2.08333, 1), (3.25, 2)):
        _, cycle = reference_cycle(System(), eta, Reference())
        for seed in range(5):
            found = recurrence(few_samples(cycle, periods, per_period, seed), eta)
            assert found.period == period
            assert abs(found.eta - eta) < 4 * found.eta_error


def few_samples(cycle, periods, per_period, seed):
    time = 2 * np.pi / cycle.eta / per_period * np.arange(int(periods * per_period) + 1)
    exact = cycle.displacement(time + 0.3 * seed, "absolute")
    noise = 0.02 * np.random.default_rng(seed).standard_normal(exact.shape)
    return Measurement(time, exact + noise, None, "absolute")


def test_what_the_samples_do_not_show_is_said_to_be_undecided():
    """With 10.5 samples a period, all samples repeat after two periods: a motion of one looks like one of two."""
    _, cycle = reference_cycle(System(), 3.25, Reference())
    made = few_samples(cycle, 8, 10.5, 0)
    assert recurrence(made, 3.25).possible == (1, 2, 4)
    words = verdict(3.25, made)
    assert words.startswith(
        "With 10.5 samples a period over 8 periods, the measurement does not show whether it repeats every period or "
        "every 2 periods or every 4 periods; give more samples a period, or more periods."
    )
    assert "another motion" not in words
    assert "was excited at" not in words


def test_contacts_are_counted_over_what_was_observed():
    made = synthetic_measurement(System(), 2.76, periods=4, noise=0.0)
    seen = (made.time < 2.8) | (made.time > 7.6)  # a gap of two periods
    found = summarise_sensor(made.time[seen], made.contact[seen], 2.76)
    whole = summarise_sensor(made.time, made.contact, 2.76)
    assert whole.per_period == pytest.approx(1.0, rel=0.01)
    assert found.per_period == pytest.approx(1.0, rel=0.01)
    assert found.share == pytest.approx(whole.share, rel=0.05)


def test_one_body_is_compared_and_fitted_at_a_wall():
    wall = System(wall=True, d1=0.05, clearance=0.5, restitution=0.6)
    made = synthetic_measurement(wall, 0.8, noise=0.01)
    assert made.displacement.shape[0] == 1
    assert "The reference agrees within the noise" in verdict(0.8, made, Newmark(500, 2, 2000), wall)
    with_zeros = Measurement(made.time, np.vstack([made.displacement, 0 * made.time]), None, "absolute")
    assert "The reference agrees within the noise" in verdict(0.8, with_zeros, Newmark(500, 2, 2000), wall)
    assert fit(wall, 0.8, made, names=["restitution"]).values["restitution"] == pytest.approx(0.6, abs=0.02)


def test_unevenly_spaced_samples_are_aligned():
    made = synthetic_measurement(System(), 2.76, noise=0.01, per_period=400, phase=1.0)
    some = np.sort(np.random.default_rng(5).choice(len(made), 900, replace=False))
    thin = Measurement(made.time[some], made.displacement[:, some], None, made.frame)
    _, cycle = reference_cycle(System(), 2.76, Reference())
    assert align(cycle, thin).phase == pytest.approx(1.0, abs=1e-3)
    assert recurrence(thin, 2.76).period == 1


# --------------------------------------------------------------------------------------------------- the comparison

FINE = Newmark(12000, 18, 8000)
WRONG = Newmark(100, 50, 2000)


def verdict(eta, measurement, penalty=FINE, system=None):
    return measured_verdict(compare_measured(system or System(), eta, measurement, penalty, periods=300))


def test_the_verdict_covers_both_solutions():
    made = synthetic_measurement(System(), 2.76, noise=0.02)
    found = compare_measured(System(), 2.76, made, FINE, periods=300)
    assert found.reference.alignment.rms < found.penalty.alignment.rms < 0.05
    assert found.reference.impacts_per_period == 1
    assert measured_verdict(found).startswith("The reference agrees within the noise of the measurement (0.71 %).")
    assert "penalty solution follows the measurement to" in measured_verdict(found)


def test_the_nearer_solution_is_named_unless_noise_hides_it():
    made = synthetic_measurement(System(), 2.76, noise=0.02)
    found = compare_measured(System(), 2.76, made, FINE, periods=300)
    near, other = (percent(each.alignment.rms) for each in (found.reference, found.penalty))
    assert f"The reference is nearer: {near} off against {other}." in measured_verdict(found)
    noisy = synthetic_measurement(System(), 2.76, noise=0.2)
    assert "Its noise hides which of the two is nearer." in verdict(2.76, noisy)


def test_a_wrong_penalty_solution_is_recognised():
    made = synthetic_measurement(System(), 1.08, noise=0.02)
    found = compare_measured(System(), 1.08, made, WRONG)
    assert found.penalty.alignment.rms > 0.1
    words = measured_verdict(found)
    assert f"The penalty solution is {percent(found.penalty.alignment.rms)} off" in words
    assert "would close the sensor 1 times a period" in words


@pytest.mark.parametrize("d1", [0.08, 0.0889])
def test_what_the_step_scatters_is_no_other_motion(d1):
    """Its section repeats itself after 3 periods by chance, or after 6, and without a step after one."""
    stop = System(wall=True, d1=d1, clearance=2.0, restitution=0.7, excitation=Excitation(held="acceleration"))
    coarse = Newmark(583.6, 2.0, 400)
    assert motion(simulate(stop, 1.0, coarse)).period > 1
    words = measured_verdict(compare_measured(stop, 1.0, synthetic_measurement(stop, 1.0, noise=0.002), coarse))
    assert re.search(r"The penalty solution follows the measurement to \d.* %", words)


def test_a_measurement_of_another_motion_is_recognised():
    assert "not in step with an excitation at eta = 2.76; its strongest frequency is eta = 1.08" in verdict(
        2.76, synthetic_measurement(System(), 1.08, periods=12)
    )
    assert "was excited at eta = 2.76" in verdict(2.80, synthetic_measurement(System(), 2.76))
    assert "the measurement every 2 periods: another motion" in verdict(
        3.25, synthetic_measurement(System(), 3.25), system=System(restitution=0.1, d1=0.2, d2=0.2)
    )
    assert re.match(
        r"The reference is \d\.\d % off\.", verdict(2.76, synthetic_measurement(System(restitution=0.7), 2.76))
    )


def test_columns_in_the_wrong_frame_are_recognised():
    made = synthetic_measurement(System(), 1.08, noise=0.01)
    misread = Measurement(made.time, made.displacement, made.contact, "relative")
    assert "If the columns are x1, x2 (absolute), the reference is 0.5 % off: name them so." in verdict(1.08, misread)


@pytest.mark.parametrize(
    ("change", "words"),
    every(
        [
            (lambda x: x - [[0.4], [0]], "If the sensor of x1 shows -0.4.* at rest, the reference is .*: fit zero1."),
            (
                lambda x: x - [[0.4], [0.5]],
                "If the sensor of x1 shows -0.4 at rest and the sensor of x2 shows -0.5.* at rest",
            ),
            (lambda x: 1000 * x, r"If x1 and x2 are 0.001 times as large \(mm in place of m\), the reference is 0"),
            (lambda x: x * [[1], [2.4]], "If x2 is 0.416 times as large, the reference is 0"),
            (lambda x: -x, "If x1 and x2 have the opposite sign, the reference is 0"),
            (lambda x: x * [[1], [-1]], "If x2 has the opposite sign, the reference is 0.*: correct the columns."),
            (lambda x: x[::-1], "If the columns of body 1 and body 2 are exchanged, the reference is 0"),
            (
                lambda x: x[::-1] / 25.4,
                r"exchanged and x1 and x2 are 25.4 times as large \(in in place of mm\), the reference",
            ),
        ]
    ),
)
def test_what_of_the_sensors_explains_the_difference_is_proposed(change, words):
    made = synthetic_measurement(System(), 2.76, noise=0.01, phase=0.4)
    assert re.search(words, verdict(2.76, replace(made, displacement=change(made.displacement))))


@pytest.mark.parametrize("true", [System(restitution=0.7), System(d2=0.02), System(kappa=2.5)])
def test_no_other_reading_of_the_columns_is_proposed_for_another_system(true):
    assert "If " not in verdict(2.76, synthetic_measurement(true, 2.76, noise=0.01))


def test_the_unit_and_the_sign_of_one_sensor_at_a_wall_are_proposed():
    wall = System(wall=True, d1=0.05, clearance=0.5, restitution=0.6)
    made = synthetic_measurement(wall, 0.8, noise=0.01)
    wrong = replace(made, displacement=-1e-3 * made.displacement)
    words = verdict(0.8, wrong, Newmark(500, 2, 2000), wall)
    assert "If x1 has the opposite sign and x1 is 1000 times as large (m in place of mm), the reference is" in words


def test_a_measurement_of_less_than_a_period_is_refused():
    made = synthetic_measurement(System(), 2.76, periods=1)
    short = Measurement(made.time[:100], made.displacement[:, :100], None, made.frame)
    with pytest.raises(ValueError, match=r"covers 0\.495 periods"):
        compare_measured(System(), 2.76, short, FINE)


def test_a_penalty_solution_that_diverges_is_reported():
    made = synthetic_measurement(System(), 2.76)
    found = compare_measured(System(), 2.76, made, Newmark(60000, 1, 100), periods=300)
    assert found.penalty.alignment is None
    assert "The penalty solution ended early (diverged)." in measured_verdict(found)


@pytest.mark.parametrize("eta", [0.8, 0.9])
def test_accelerations_are_integrated_and_compared(eta):
    """An accelerometer on the body of a penalty solution, with noise and a bias; its mean displacement is unknown."""
    wall, penalty = System(wall=True, d1=0.05, clearance=0.5, restitution=0.6), Newmark(500, 2, 2000, located=True)
    run = simulate(wall, eta, penalty, periods=300, keep=8, record=Record(8, 2000)).trajectory
    force = np.cos(eta * run.time) * eta**2 - run.force  # of the base's motion and of the contact
    acceleration = force - 2 * wall.d1 * run.velocity[0] - run.displacement[0] - eta**2 * np.cos(eta * run.time)
    noise = 0.005 * np.random.default_rng(1).standard_normal(len(run.time))
    rows = zip(run.time - run.time[0], acceleration + noise + 0.01, strict=True)
    content = "\n".join(["time,a1", *(f"{t:.9g},{a:.9g}" for t, a in rows)]).encode()
    made = parse_measurement(content, eta=eta)
    found = compare_measured(wall, eta, made, penalty, periods=300)
    assert (found.recurrence.period, made.mean_known) == (1, False)
    assert found.penalty.alignment.rms < 0.01
    assert found.penalty.alignment.rms < found.reference.alignment.rms
    with pytest.raises(ValueError, match="accelerations need the excitation frequency: give eta"):
        parse_measurement(content)
