"""Contact law and stiffness by the step as options of ``vibroscope simulate``."""

import json

import pytest
from vibroscope.app.commands.cli import build_parser
from vibroscope.engine import ExactPenalty, Newmark, System, TimeStepping, simulate, stiffness_of_step

from tests.app.command_line import run_command

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


def test_what_has_no_effect_is_noted(capsys):
    status, _, err = run(capsys, "--solver", "reference", "--law", "cut", "--penetration", "1", *FEW)
    assert status == 0
    assert "--law has no effect on the reference solver" in err
    assert "--penetration has no effect" in err


PENALTY = "--eta 2.76 --K 12000 --D 18 --steps 100"


def test_a_number_of_a_law_has_no_effect_on_the_reference(capsys):
    status, _, err = run(capsys, "--solver", "reference", "--exponent", "2", *FEW)
    assert (status, err) == (0, "vibroscope: --exponent has no effect on the reference solver\n")


VALUES = {
    "integrator": "hht",
    "status": "end",
    "law": "limited",
    "without-solution": "keep",
    "initial-acceleration": "zero",
    "initial": "0,0,1,0",
    "joint-damping": "derived",
}


def test_every_option_alone_ends_in_a_result_or_in_one_line(capsys):
    """A number is given as 0.5, which is in the range of some options and out of that of others."""
    parser = build_parser(["simulate"])._subparsers._group_actions[0].choices["simulate"]
    options = [action for action in parser._actions if action.nargs != 0 and action.option_strings]
    ended = set()
    for name in (action.option_strings[-1].removeprefix("--") for action in options):
        if name in ("solver", "system"):
            continue
        words = [*PENALTY.split(), "--periods", "5", "--keep", "2", f"--{name}", VALUES.get(name, "0.5")]
        status, out, err = run_command(capsys, "simulate", "--solver", "newmark", *words)
        assert (status, bool(out)) in ((0, True), (2, False)), name
        assert len(err.splitlines()) <= 1 or err.startswith("usage"), err
        ended.add(status)
    assert ended == {0, 2}
