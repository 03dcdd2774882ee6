"""Contact law and stiffness by the step as options of ``vibroscope simulate``."""

import json

import pytest
from vibroscope.engine import ExactPenalty, Newmark, System, TimeStepping, simulate, stiffness_of_step

from .command_line import run_command

FEW = ["--periods", "6", "--keep", "2", "--json"]


def run(capsys, *arguments):
    return run_command(capsys, "simulate", "--eta", "2.76", *arguments)


BY_STEP = stiffness_of_step(System(), 2.76, 500, 0.1)
NEWMARK = "--solver newmark --steps 500"


@pytest.mark.parametrize(
    ("arguments", "method", "restitution"),
    [
        ("--solver exact --K 1200 --D 18 --law cut", ExactPenalty(1200, 18, "cut"), 0.5),
        ("--solver exact --K 1200 --law flores --restitution 0.6", ExactPenalty(1200, None, "flores"), 0.6),
        (
            "--solver exact --K 1200 --law constant-restitution --exponent 2",
            ExactPenalty(1200, None, "constant-restitution", 2),
            0.5,
        ),
        (
            "--solver exact --K 1200 --D 18 --law impact --penetration 0.02",
            ExactPenalty(1200, 18, "impact", penetration=0.02),
            0.5,
        ),
        (f"{NEWMARK} --K 1200 --D 18 --law limited", TimeStepping(1200, 18, 500, law="limited"), 0.5),
        (
            f"{NEWMARK} --K 1200 --law jankowski --status end",
            TimeStepping(1200, None, 500, status="end", law="jankowski"),
            0.5,
        ),
        (f"{NEWMARK} --stiffness-of-step 0.1 --D 18", Newmark(BY_STEP, 18, 500), 0.5),
    ],
)
def test_options_reach_the_method(capsys, arguments, method, restitution):
    status, out, err = run(capsys, *arguments.split(), *FEW)
    expected = simulate(System(restitution=restitution), 2.76, method, periods=6, keep=2)
    assert (status, err) == (0, "")
    assert json.loads(out)["section"] == expected.section.tolist()


@pytest.mark.parametrize(
    ("arguments", "text"),
    [
        ("--solver exact --K 1200 --law cut", "the exact solver needs --D"),
        ("--solver exact --K 1200 --law impact --D 1", "penetration = None is outside"),
        ("--solver exact --K 1200 --law flores --restitution 0", "since its formula divides by it: give D"),
        (f"{NEWMARK} --K 1200 --law limited --D 1 --located", "law = 'limited' has no located steps"),
        (f"{NEWMARK} --D 1 --stiffness-of-step -1", "stiffness_of_step = -1.0 is outside (0, 1e+06]"),
    ],
)
def test_bad_input_is_named_in_one_line(capsys, arguments, text):
    status, out, err = run(capsys, *arguments.split(), *FEW)
    assert (status, out) == (2, "")
    assert text in err
    assert err.count("\n") == 1


def test_what_has_no_effect_is_noted(capsys):
    status, _, err = run(capsys, "--solver", "reference", "--law", "cut", "--penetration", "1", *FEW)
    assert status == 0
    assert "--law has no effect on the reference solver" in err
    assert "--penetration has no effect" in err
