"""Studies with integrators, contact statuses and laws of codes, and the plane of steps without a solution."""

import json
from dataclasses import replace

import numpy as np
import pytest
from vibroscope.app.commands.cli import main
from vibroscope.engine import (
    HHT,
    Cells,
    HHTInterpolated,
    Newmark,
    PlaneStudy,
    StepStudy,
    System,
    TimeStepping,
    run_cells,
    simulate,
    sweep,
)
from vibroscope.engine.sweeps import EtaStudy, NoSolutionStudy

SYSTEM = System()
KEEP = TimeStepping(1, 0, 1000, HHT(-0.1), "end", "keep")
FEW = {"transient": 60, "sample": 20}


def test_a_cell_that_grows_without_bound_has_an_error_wherever_its_run_ended():
    """Far beyond where a run may begin, and not yet blown up: how far hangs on rounding, so in many cells."""
    method = TimeStepping(1, 1, 200, HHT(-0.05), "end", "keep")
    K = np.linspace(36000, 40000, 64)
    found = sweep(PlaneStudy(SYSTEM, method, 2.76, K=K, D=[0.1], transient=250, sample=50))
    not_blown_up = found["status"].values == 0
    assert not_blown_up.mean() > 0.5
    assert np.nanmax(found["error"].values[not_blown_up]) > 1e6


def test_each_cell_is_a_single_run():
    method = TimeStepping(1000, 5, 100, HHT(-0.1), "end", "keep")
    found = run_cells(Cells(SYSTEM, [1.0, 1.08], method, stiffness=[500, 1000], steps=[80, 120]), **FEW)
    for i, (eta, k, n) in enumerate([(1.0, 500, 80), (1.08, 1000, 120)]):
        run = simulate(SYSTEM, eta, TimeStepping(k, 5, n, HHT(-0.1), "end", "keep"), periods=80, keep=20)
        np.testing.assert_array_equal(found.section[i], run.section)
        assert found.steps_without_solution[i] == run.steps_without_solution
        assert found.steps_with_two[i] == run.steps_with_two
        assert found.steps_taken[i] == 80 * n
    assert found.steps_without_solution.sum() > 0


def test_a_diagram_has_the_section_of_single_runs():
    method = TimeStepping(1000, 5, 100, HHT(-0.1), "end", "keep")
    found = sweep(EtaStudy(SYSTEM, method, values=[1.0, 1.08], **FEW))
    run = simulate(SYSTEM, 1.08, method, periods=80, keep=20)
    np.testing.assert_array_equal(found.xi2[1], run.section[:, 2])


def test_a_diagram_and_a_plane_count_steps_without_a_solution_where_there_may_be_some():
    method = replace(KEEP, stiffness=1000, damping=5, steps=100)
    diagram = sweep(EtaStudy(SYSTEM, method, values=[1.0, 1.08], **FEW))
    plane = sweep(PlaneStudy(SYSTEM, replace(KEEP, steps=100), 1.08, K=[1000], D=[5], **FEW))
    run = simulate(SYSTEM, 1.08, method, periods=80)
    for name in ("steps_without_solution", "steps_with_two"):
        assert diagram[name][1] == plane[name][0, 0] == getattr(run, name)
    assert run.steps_without_solution > 0
    start = sweep(EtaStudy(SYSTEM, replace(method, status="start"), values=[1.0], **FEW))
    assert "steps_without_solution" not in start


def test_a_plane_and_a_step_study_take_what_a_code_has():
    plane = sweep(PlaneStudy(SYSTEM, replace(KEEP, steps=100), 1.08, K=[500, 1000], D=[5], **FEW))
    paper = sweep(PlaneStudy(SYSTEM, Newmark(1, 1, 100), 1.08, K=[500, 1000], D=[5], **FEW))
    assert (plane.error != paper.error).all()
    np.testing.assert_array_equal(plane.exact_period, paper.exact_period)
    found = sweep(StepStudy(SYSTEM, replace(KEEP, stiffness=1000, damping=5), 1.08, steps=[100], **FEW))
    assert found.error[0, 0] == plane.error[1, 0]
    located = run_cells(Cells(SYSTEM, [1.08], Newmark(1000, 5, 100, located=True)), **FEW)
    apart = np.abs(found.xi2_section[0, 1] - located.section[0, :, 2])
    assert apart.max() < 0.2  # located steps of one scheme or another


def test_the_plane_of_steps_without_a_solution_counts_those_of_single_runs(tmp_path):
    K, steps = [1000.0, 12000.0], [200, 500, 1000]
    for choice in ("stop", "keep"):
        method = TimeStepping(1, 18, 1000, status="end", without_solution=choice)
        study = NoSolutionStudy(SYSTEM, method, 2.76, K=K, steps=steps, **FEW)
        found = sweep(study, out=tmp_path / choice)
        for i, k in enumerate(K):
            for j, n in enumerate(steps):
                method = TimeStepping(k, 18, n, status="end", without_solution=choice)
                run = simulate(SYSTEM, 2.76, method, periods=80, keep=20)
                assert found.steps_without_solution[i, j] == run.steps_without_solution
                stopped = found.periods_until_stopped[i, j]
                assert (stopped == run.cost.steps / n) if not run.ok else np.isnan(stopped)
    assert found.steps_without_solution.values.max() > 3
    again = sweep(study, out=tmp_path / choice)
    assert (again.attrs["computed"], again.attrs["reused"]) == (0, 6)


def test_every_choice_of_a_code_has_a_store_of_its_own():
    def key(method):
        return EtaStudy(SYSTEM, method, None, transient=10, sample=5, values=[1.0, 1.1]).key

    methods = [
        Newmark(100, 1, 100),
        Newmark(100, 1, 100, located=True),
        TimeStepping(100, 1, 100, status="located"),
        TimeStepping(100, 1, 100, status="end"),
        TimeStepping(100, 1, 100, status="end", without_solution="keep"),
        TimeStepping(100, 1, 100, law="cut"),
        TimeStepping(100, 1, 100, HHT(-0.1)),
        TimeStepping(100, 1, 100, HHTInterpolated(-0.1)),
    ]
    assert len({key(method) for method in methods}) == len(methods)
    assert key(TimeStepping(100, 1, 100)) == key(Newmark(100, 1, 100))


def test_steps_that_have_one_solution_are_one_clear_line():
    with pytest.raises(ValueError, match="each step has one solution"):
        NoSolutionStudy(SYSTEM, TimeStepping(1, 1, 1000), 2.76, K=[100], steps=[100])
    with pytest.raises(ValueError, match="each step has one solution"):
        NoSolutionStudy(SYSTEM, Newmark(100, 1, 100), 2.76, transient=10, sample=5, K=[1.0], steps=[100])


def test_the_command_computes_a_plane_of_steps_without_a_solution(capsys, tmp_path):
    numbers = "--eta 2.76 --K 1000:12000:2 --D 18 --steps 200:500:2 --transient 10 --sample 5 --json"
    main(["sweep", "no-solution", *numbers.split(), "--without-solution", "keep", "--out", str(tmp_path / "plane")])
    found = json.loads(capsys.readouterr().out)
    assert (found["cells"], found["computed"], found["failed"]) == (4, 4, 0)
