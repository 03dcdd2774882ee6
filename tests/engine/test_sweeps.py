"""The three studies against single runs, and against each other."""

import itertools

import numpy as np
import pytest
from vibroscope.engine import (
    Cells,
    ComparisonQuestion,
    EtaStudy,
    ExactPenalty,
    Newmark,
    PlaneStudy,
    Reference,
    StepStudy,
    System,
    compare,
    motion,
    run_cells,
    simulate,
    spaced,
    sweep,
)
from vibroscope.engine.contact import equal_restitution_damping
from vibroscope.engine.sweeps.eta_study import changed_intervals
from vibroscope.engine.sweeps.step_study import observed_order

SHORT = {"transient": 300, "sample": 20}


@pytest.mark.parametrize("method", [Reference(), ExactPenalty(12000, 18), Newmark(12000, 18, 500)])
def test_a_diagram_holds_what_single_runs_give(method):
    found = sweep(EtaStudy(System(), method, values=[1.08, 1.7, 2.76, 3.25], coordinates=["xi2", "v1"], **SHORT))
    assert found["xi2"].dims == ("eta", "sample")
    for eta in found["eta"].values:
        cell, run = found.sel(eta=eta), simulate(System(), eta, method, periods=320, keep=20)
        alone = motion(run)
        if alone.period:  # irregular motion multiplies rounding, and the batch may round otherwise
            np.testing.assert_allclose(cell["xi2"], run.section[:, 2], atol=1e-7)
            np.testing.assert_allclose(cell["v1"], run.section[:, 1], atol=1e-7)
        assert (cell["period"], cell["status"]) == (alone.period, 0)
        if alone.period:
            assert cell["impacts_per_period"] == pytest.approx(alone.impacts_per_period)
            assert cell["contact_share"] == pytest.approx(alone.contact_share, abs=1e-9)


def test_a_continued_diagram_follows_a_motion_that_rest_does_not_lead_to():
    """Downwards each cell starts where its upper neighbour ended; motions coexist near η = 3.2."""
    etas = np.linspace(3.1, 3.3, 11)
    down = sweep(EtaStudy(System(), Reference(), values=etas, direction="down", **SHORT))
    start = np.zeros(4)
    for eta in etas[::-1]:
        run = simulate(System(), eta, Reference(), periods=320, keep=20, initial=start)
        start = run.section[-1]
        np.testing.assert_allclose(down["end"].sel(eta=eta), start, atol=1e-6)
    up = sweep(EtaStudy(System(), Reference(), values=etas, direction="up", **SHORT))
    assert (np.abs(up["xi2"] - down["xi2"]).max("sample") > 0.1).any()


@pytest.mark.parametrize("direction", ["rest", "up", "down"])
def test_refinement_halves_the_intervals_where_the_motion_changes_and_leaves_the_others(direction):
    etas = np.linspace(2.7, 3.3, 7)
    coarse = sweep(EtaStudy(System(), Reference(), values=etas, direction=direction, **SHORT))
    fine = sweep(EtaStudy(System(), Reference(), values=etas, direction=direction, refine=3, **SHORT))
    assert (np.diff(fine["eta"]) > 0).all()
    assert len(fine["eta"]) > len(etas)
    np.testing.assert_array_equal(fine["xi2"].sel(eta=etas), coarse["xi2"])
    changed = np.flatnonzero(changed_intervals({name: column.values for name, column in coarse.variables.items()}))
    for i, (left, right) in enumerate(itertools.pairwise(etas)):
        inside = ((fine["eta"] > left) & (fine["eta"] < right)).sum()
        assert (inside >= 3) == (i in changed)
        assert inside <= 7
    alike = sweep(EtaStudy(System(), Reference(), values=[2.70, 2.72], refine=2, **SHORT))
    assert alike["eta"].values.tolist() == [2.70, 2.72]
    assert alike["period"].values.tolist() == [1, 1]


def test_a_sweep_over_another_parameter_is_a_sweep_of_runs():
    found = sweep(EtaStudy(System(), Reference(), values=[0.3, 0.6], over="restitution", eta=2.76, **SHORT))
    assert found["xi2"].dims == ("restitution", "sample")
    for e in (0.3, 0.6):
        run = simulate(System(restitution=e), 2.76, Reference(), periods=320, keep=20)
        np.testing.assert_allclose(found["xi2"].sel(restitution=e)[-1], run.section[-1, 2], atol=1e-7)
    found = sweep(EtaStudy(System(), Newmark(12000, 18, 4), values=[500, 1000], over="steps", eta=1.08, **SHORT))
    run = simulate(System(), 1.08, Newmark(12000, 18, 1000), periods=320, keep=20)
    np.testing.assert_allclose(found["xi2"][1, -1], run.section[-1, 2], atol=1e-6)


def test_the_exponent_tells_chaos_from_what_repeats():
    found = sweep(EtaStudy(System(), Reference(), values=[1.7, 2.76], lyapunov=1024, **SHORT))
    kinds = dict(zip(found["motion"].attrs["flag_meanings"].split(), found["motion"].attrs["flag_values"], strict=True))
    assert found["motion"].values.tolist() == [kinds["chaotic"], kinds["periodic"]]
    assert 0.15 < found["lyapunov"][0] < 0.4
    assert found["lyapunov"][1] < -0.05


def test_the_plane_holds_what_single_runs_give_and_the_parts_of_their_errors():
    K, D = [3000.0, 50_000.0], [20.0, 80.0]
    found = sweep(PlaneStudy(System(), Newmark(1, 1, 2000), 1.08, K=K, D=D, transient=150, sample=20))
    for k in K:
        for d in D:
            cell = found.sel(K=k, D=d)
            newmark = motion(simulate(System(), 1.08, Newmark(k, d, 2000), periods=170, keep=20))
            assert cell["period"] == newmark.period
            assert cell["impacts_per_period"] == pytest.approx(newmark.impacts_per_period)
            exact = motion(simulate(System(), 1.08, ExactPenalty(k, d), periods=170, keep=20))
            assert cell["exact_contact_share"] == pytest.approx(exact.contact_share, abs=1e-9)
            # the parts add up as functions of time, so that no one is longer than the others together
            parts = [float(cell[f"error_{name}"]) for name in ("time_step", "regularisation")]
            parts.append(float(found["error_joint_damping"]))
            assert float(cell["error"]) <= sum(parts) * (1 + 1e-6)
            assert float(cell["error"]) >= 2 * max(parts) - sum(parts) - 1e-9
    whole = compare(ComparisonQuestion(System(), 1.08, Newmark(3000, 20, 2000), periods=170))
    assert float(found["error"][0, 0]) == pytest.approx(whole.total, rel=0.05)
    assert float(found["error_time_step"][0, 0]) == pytest.approx(whole.time_step, rel=0.1, abs=1e-4)


def test_cells_that_blow_up_are_marked_and_stop_nothing():
    """K = 6·10⁴ with 100 steps per period is not stable; without a time step there is nothing to blow up."""
    found = sweep(
        PlaneStudy(System(), Newmark(1, 1, 100), 2.76, K=[500.0, 60_000.0], D=[1.0, 3.0], transient=200, sample=10)
    )
    assert (found["status"][1] != 0).any()
    assert (found["status"][0] == 0).all()
    assert (found["exact_status"] == 0).all()
    assert found.attrs["failed"] == int((found["status"] != 0).sum())
    assert np.isnan(found["error"].values[found["status"] != 0]).all()


def test_on_the_curve_of_equal_restitution_a_contact_returns_e():
    system = System(kappa3=1.7, restitution=0.37)
    K = np.array([1e7])
    (D,) = equal_restitution_damping(system, K)
    run = simulate(system, 2.76, ExactPenalty(K[0], D), periods=60, keep=20)
    before, after = (
        np.diff(velocity, axis=1)[:, 0] for velocity in (run.impacts.velocity_before, run.impacts.velocity_after)
    )
    np.testing.assert_allclose(-after / before, 0.37, rtol=0.01)


def test_the_observed_orders_of_the_fixed_and_the_located_step():
    """Of the fixed step only the scatter is left to see at η = 2.76; the located one is of second order."""
    study = StepStudy(System(), Newmark(12000, 18, 2000), 2.76, steps=[1000, 2000, 4000], transient=200, sample=20)
    seen = []
    found = sweep(study, progress=seen.append)
    assert 3 in [now.done for now in seen]  # the fixed step, before the located one
    fixed, located = found["spread"].values.T
    assert (located < 1e-3 * fixed).all()
    assert found["order_of_error_time_step"][1] == pytest.approx(2, abs=0.1)
    phase = found.isel(steps=1, scheme=0)
    assert phase["tau"].max() == pytest.approx(2 * 2 * np.pi / 2.76)
    run = simulate(System(), 2.76, Newmark(12000, 18, 2000), periods=220, keep=20)
    np.testing.assert_allclose(phase["xi2_section"][0], run.section[0, 2], atol=0.5)


@pytest.mark.parametrize(
    ("eta", "steps", "located", "exact"),
    [(3.205, 50, 6, 2), (3.04, 100, 0, 6), (1.7, 100, 0, 0)],  # periods with located steps and without a step
)
def test_scatter_is_about_the_cycle_of_the_located_steps_or_else_of_exact_penalty(eta, steps, located, exact):
    method, periods = Newmark(12000, 18, steps), {"transient": 600, "sample": 50}
    found = sweep(StepStudy(System(), method, eta, steps=[steps], **periods))
    assert found["period"][0, 1] == located
    assert run_cells(Cells(System(), [eta], method.limit), **periods).period == [exact]
    period = located or exact or 1
    points = found["xi2_section"].values[0, 1][50 % period :].reshape(-1, period)
    assert found["scatter"].values[0, 1] == pytest.approx(np.sqrt(points.var(axis=0).mean()), abs=1e-12)
    assert points.std() > 0.1


def test_the_order_is_the_slope_of_a_power_law():
    n = np.array([10.0, 20, 40, 80])
    assert observed_order(n, 3 * n**-1.7) == (pytest.approx(1.7), pytest.approx(0, abs=1e-9))
    assert observed_order(n, np.array([np.nan, 0.0, 1.0, 0.5]))[0] == pytest.approx(1)
    assert np.isnan(observed_order(n[:1], n[:1])[0])


@pytest.mark.parametrize("name", ["base", "force1", "force2", "constant1", "constant2", "clearance2"])
def test_an_amplitude_or_a_second_clearance_is_swept(name):
    values, system = [0.5, 2.0], System(clearance=0.2)
    found = sweep(EtaStudy(system, Reference(), values=values, over=name, eta=1.08, **SHORT))
    for value, section in zip(values, found["xi2"].values, strict=True):
        alone = simulate(system.changed({name: value}), 1.08, Reference(), periods=320, keep=20)
        np.testing.assert_allclose(section, alone.section[:, 2], atol=1e-9)
    assert np.abs(np.diff(found["xi2"].values, axis=0)).max() > 0.1


@pytest.mark.parametrize(
    ("sweep", "text"),
    [
        (lambda: sweep(EtaStudy(System(), Reference(), values=[])), "no value of eta"),
        (lambda: sweep(EtaStudy(System(), Reference(), values=[2, 1])), "do not ascend"),
        (lambda: sweep(EtaStudy(System(), Reference(), values=[1.0, np.nan])), "do not ascend"),
        (lambda: sweep(EtaStudy(System(), Reference(), values=[1.0, 1e9])), "eta = "),
        (
            lambda: sweep(EtaStudy(System(), Reference(), values=[1.0], over="mood", eta=1)),
            "no parameter that can be swept",
        ),
        (lambda: sweep(EtaStudy(System(), Reference(), values=[0.5], over="restitution")), "needs an eta"),
        (lambda: sweep(EtaStudy(System(), Reference(), values=[1.7, 2.4], over="kappa", eta=1)), "kappa3"),
        (
            lambda: sweep(EtaStudy(System(wall=True), Reference(), values=[1.0], over="force2", eta=1)),
            "force2 cannot be swept: a wall",
        ),
        (lambda: sweep(EtaStudy(System(), Reference(), values=[1.0], direction="sideways")), "direction"),
        (lambda: sweep(EtaStudy(System(), Reference(), values=[1.0], coordinates=["x"])), "coordinate 'x'"),
        (lambda: sweep(EtaStudy(System(), Reference(), values=[1.0], sample=0)), "sample = 0"),
        (lambda: sweep(EtaStudy(System(), Reference(), values=[1.0], transient=1.5)), "transient = 1.5"),
        (lambda: sweep(EtaStudy(System(), Reference(), values=[1.0], refine=40)), "refine = 40"),
        (lambda: sweep(EtaStudy(System(), Newmark(1, 1, 100), values=[1.0], lyapunov=1000)), "closed form"),
        (lambda: sweep(PlaneStudy(System(), Newmark(1, 1, 2000), 2.76, K=[0.0, 1.0], D=[1.0])), "K = 0"),
        (
            lambda: sweep(PlaneStudy(System(), Newmark(1, 1, 2000), 2.76, K=[1.0, 1e13], D=[1.0])),
            "K = 10000000000000.0 is outside",
        ),
        (
            lambda: sweep(PlaneStudy(System(), Newmark(1, 1, 2000), 2.76, K=np.arange(1, 1e6), D=np.arange(1, 1e6))),
            "cells = ",
        ),
        (lambda: sweep(StepStudy(System(), Newmark(1e4, 18, 2000), 2.76, steps=[100.5])), "steps = 100.5"),
        (lambda: spaced("K", 0, 10, 4, logarithmic=True), "K = 0"),
        (lambda: spaced("eta", 1, 2, 0), "count of eta = 0"),
        (lambda: spaced("eta", 2, 2, 3), "empty range"),
    ],
)
def test_bad_input_is_refused_before_any_work(sweep, text):
    with pytest.raises(ValueError, match=text):
        sweep()


def test_a_range_of_one_value_may_end_where_it_begins():
    assert spaced("eta", 2, 2, 1).tolist() == [2.0]
