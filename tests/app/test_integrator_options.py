"""Integrator, contact status and steps without a solution as options of ``vibroscope simulate``."""

import json

import pytest
from vibroscope.app.commands.cli import main
from vibroscope.engine import (
    HHT,
    TRBDF2,
    Bathe,
    CentralDifference,
    GeneralisedAlpha,
    HHTInterpolated,
    Newmark,
    NewmarkBeta,
    SemiImplicitEuler,
    System,
    TimeStepping,
    simulate,
)

from tests.app.command_line import run_command

PROBLEM = ["simulate", "--solver", "newmark", "--eta", "2.76", "--K", "12000", "--D", "18", "--steps", "500"]
FEW = ["--periods", "6", "--keep", "2", "--json"]


def run(capsys, *arguments):
    return run_command(capsys, *PROBLEM, *arguments)


@pytest.mark.parametrize(
    ("arguments", "method"),
    [
        ("--integrator newmark", Newmark(12000, 18, 500)),
        ("--status start", Newmark(12000, 18, 500)),
        ("--status located", Newmark(12000, 18, 500, located=True)),
        ("--gamma 0.6 --beta 0.3025", TimeStepping(12000, 18, 500, NewmarkBeta(0.3025, 0.6))),
        ("--status end --law cut", TimeStepping(12000, 18, 500, status="end", law="cut")),
        ("--integrator hht --alpha -0.2", TimeStepping(12000, 18, 500, HHT(-0.2))),
        ("--integrator hht-interpolated", TimeStepping(12000, 18, 500, HHTInterpolated())),
        ("--integrator generalised-alpha --rho 0.5", TimeStepping(12000, 18, 500, GeneralisedAlpha(0.5))),
        (
            "--integrator tr-bdf2 --status end --without-solution keep",
            TimeStepping(12000, 18, 500, TRBDF2(), "end", "keep"),
        ),
        (
            "--integrator bathe --status end --without-solution halve --initial-acceleration zero",
            TimeStepping(12000, 18, 500, Bathe(), "end", "halve", initial_acceleration="zero"),
        ),
        ("--integrator central-difference", TimeStepping(12000, 18, 500, CentralDifference())),
        ("--integrator semi-implicit-euler", TimeStepping(12000, 18, 500, SemiImplicitEuler())),
    ],
)
def test_options_reach_the_method(capsys, arguments, method):
    status, out, err = run(capsys, *arguments.split(), *FEW)
    found, expected = json.loads(out), simulate(System(), 2.76, method, periods=6, keep=2)
    assert (status, err) == (0, "")
    assert found["section"] == expected.section.tolist()
    assert found["steps_without_solution"] == expected.steps_without_solution
    assert found["steps_with_two"] == expected.steps_with_two


def test_a_step_without_a_solution_ends_the_run_and_says_what_to_change(capsys):
    stop = ["--status", "end", "--initial-acceleration", "zero"]
    status, out, _ = run(capsys, *stop, "--json")
    found = json.loads(out)
    assert (status, found["status"], found["steps_without_solution"]) == (0, "without-solution", 1)
    assert found["message"].startswith("step 1780 (period 4) has no solution")
    assert "take a smaller D than 18" in found["message"]
    _, out, _ = run(capsys, *stop, "--without-solution", "keep", "--periods", "10")
    assert "2 steps without a solution, 0 with two" in out


def test_options_without_effect_are_noted(capsys):
    _, _, err = run(capsys, "--integrator", "hht", "--without-solution", "keep", *FEW)
    assert "--without-solution has no effect unless --status is end" in err
    arguments = ["simulate", "--solver", "exact", "--eta", "2.76", "--K", "1", "--D", "1", "--rho", "1", *FEW]
    main(arguments)
    assert "--rho has no effect on the exact solver" in capsys.readouterr().err
