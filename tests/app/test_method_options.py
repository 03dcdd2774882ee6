"""Integrator, contact status, contact law and steps without a solution as options of commands."""

import json

import numpy as np
import pytest
import xarray
from vibroscope.app.commands.cli import build_parser
from vibroscope.engine import (
    HHT,
    TRBDF2,
    Bathe,
    CentralDifference,
    ComparisonQuestion,
    ExactPenalty,
    GeneralisedAlpha,
    HHTInterpolated,
    Newmark,
    NewmarkBeta,
    SemiImplicitEuler,
    System,
    TimeStepping,
    compare,
    recommend,
    simulate,
    stiffness_of_step,
    verdict,
)

from tests.app.command_line import run_command
from tests.recommended import question
from tests.share import every

FEW = "--periods 6 --keep 2"
STEPS = "--solver newmark --K 12000 --D 18 --steps 500"
LAW = "--solver newmark --steps 200 --status located --K 1200"
BY_STEP = stiffness_of_step(System(), 2.76, 500, 0.1)
LOCATED = [
    TimeStepping(1200, 18, 200, status="located", law="limited"),
    TimeStepping(1200, 18, 200, Bathe(), "located", law="impact", penetration=0.02),
]
HALVED = TimeStepping(12000, 18, 500, Bathe(), "end", "halve", initial_acceleration="zero")
METHODS = {
    f"{STEPS} --integrator newmark": Newmark(12000, 18, 500),
    f"{STEPS} --status start": Newmark(12000, 18, 500),
    f"{STEPS} --status located": Newmark(12000, 18, 500, located=True),
    f"{STEPS} --gamma 0.6 --beta 0.3025": TimeStepping(12000, 18, 500, NewmarkBeta(0.3025, 0.6)),
    f"{STEPS} --status end --law cut": TimeStepping(12000, 18, 500, status="end", law="cut"),
    f"{STEPS} --integrator hht --alpha -0.2": TimeStepping(12000, 18, 500, HHT(-0.2)),
    f"{STEPS} --integrator hht-interpolated": TimeStepping(12000, 18, 500, HHTInterpolated()),
    f"{STEPS} --integrator generalised-alpha --rho 0.5": TimeStepping(12000, 18, 500, GeneralisedAlpha(0.5)),
    f"{STEPS} --integrator tr-bdf2 --status end --without-solution keep": TimeStepping(
        12000, 18, 500, TRBDF2(), "end", "keep"
    ),
    f"{STEPS} --integrator bathe --status end --without-solution halve --initial-acceleration zero": HALVED,
    f"{STEPS} --integrator central-difference": TimeStepping(12000, 18, 500, CentralDifference()),
    f"{STEPS} --integrator semi-implicit-euler": TimeStepping(12000, 18, 500, SemiImplicitEuler()),
    "--solver exact --K 1200 --D 18 --law cut": ExactPenalty(1200, 18, "cut"),
    "--solver exact --K 1200 --law flores --restitution 0.6": ExactPenalty(1200, None, "flores"),
    "--solver exact --K 1200 --law constant-restitution --exponent 2": ExactPenalty(
        1200, None, "constant-restitution", 2
    ),
    "--solver exact --K 1200 --D 18 --law impact --penetration 0.02": ExactPenalty(
        1200, 18, "impact", penetration=0.02
    ),
    "--solver newmark --steps 500 --stiffness-of-step 0.1 --D 18": Newmark(BY_STEP, 18, 500),
    f"{LAW} --D 18 --law cut": Newmark(1200, 18, 200, located=True, law="cut"),
    f"{LAW} --D 18 --law limited": LOCATED[0],
    f"{LAW} --law flores": TimeStepping(1200, None, 200, status="located", law="flores"),
    f"{LAW} --D 18 --law impact --penetration 0.02 --integrator bathe": LOCATED[1],
}


def run(capsys, *arguments):
    return run_command(capsys, "simulate", "--eta", "2.76", *arguments)


@pytest.mark.parametrize("words", METHODS)
def test_options_reach_the_method(capsys, words):
    system = System(restitution=0.6 if "restitution 0.6" in words else 0.5)
    expected = simulate(system, 2.76, METHODS[words], periods=6, keep=2)
    status, out, err = run(capsys, *words.split(), *FEW.split(), "--json")
    found = json.loads(out)
    assert (status, err) == (0, "")
    assert found["section"] == expected.section.tolist()
    assert found["steps_without_solution"] == expected.steps_without_solution
    assert found["steps_with_two"] == expected.steps_with_two


def test_a_step_without_a_solution_ends_the_run_and_says_what_to_change(capsys):
    stop = [*STEPS.split(), "--status", "end", "--initial-acceleration", "zero"]
    status, out, _ = run(capsys, *stop, "--json")
    found = json.loads(out)
    assert (status, found["status"], found["steps_without_solution"]) == (0, "without-solution", 1)
    assert found["message"].startswith("step 1780 (period 4) has no solution")
    assert "take a smaller D than 18" in found["message"]
    _, out, _ = run(capsys, *stop, "--without-solution", "keep", "--periods", "10")
    assert "2 steps without a solution, 0 with two" in out


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (
            f"{STEPS} --integrator hht --without-solution keep",
            "--without-solution has no effect unless --status is end",
        ),
        ("--solver exact --K 1 --D 1 --rho 1", "--rho has no effect on the exact solver"),
        ("--solver reference --law cut", "--law has no effect on the reference solver"),
        ("--solver reference --penetration 1", "--penetration has no effect on the reference solver"),
        ("--solver reference --K 5", "--K has no effect on the reference solver"),
    ],
)
def test_options_without_effect_are_noted(capsys, words, said):
    status, _, err = run(capsys, *words.split(), *FEW.split())
    assert (status, err) == (0, f"vibroscope: {said}\n")


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
        words = [*f"{STEPS} --periods 5 --keep 2".split(), f"--{name}", VALUES.get(name, "0.5")]
        status, out, err = run(capsys, *words)
        assert (status, bool(out)) in ((0, True), (2, False)), name
        assert len(err.splitlines()) <= 1 or err.startswith("usage"), err
        ended.add(status)
    assert ended == {0, 2}


def asked(capsys, command, words):
    status, out, err = run_command(capsys, command, "--eta", "2.76", *words.split(), "--json")
    assert (status, err) == (0, "")
    return json.loads(out)


CUT = {"--D 18 --law cut": Newmark(1200, 18, 200, located=True, law="cut"), "--D 18 --law limited": LOCATED[0]}


@pytest.mark.parametrize("words", every(CUT))
def test_compare(capsys, words):
    found = asked(capsys, "compare", f"--K 1200 --steps 200 --status located {words} --periods 60 --keep 8")
    expected = compare(ComparisonQuestion(System(), 2.76, CUT[words], periods=60, keep=8))
    assert (found["status"], found["law"], found["located"]) == ("located", CUT[words].law, True)
    assert found["total"] == expected.difference.total
    assert found["time_step"] == expected.difference.parts["time_step"]
    assert 0 <= found["residual"] < 1e-10
    assert found["verdict"] == verdict(expected.with_evidence()).headline


def test_recommend(capsys):
    how = "--K 1200 --D 18 --law limited --status located --integrator hht --tolerance 0.5 --steps-max 16"
    found = asked(capsys, "recommend", how)
    scheme = TimeStepping(1.0, 0.0, 1000, HHT(), "located", law="limited")
    held = {"stiffness": 1200.0, "damping": 18.0}  # steps are searched alone, which is short
    expected = recommend(question(System(), 2.76, tolerance=0.5, scheme=scheme, steps_max=16, **held))
    assert (found["status"], found["law"], found["integrator"]) == ("located", "limited", "hht")
    best = expected.best
    assert (found["K"], found["D"], found["steps"]) == best.setting
    assert found["error"] == best.error


def test_recommend_says_once_that_steps_are_cut(capsys):
    held = "--K 1200 --D 18 --tolerance 0.5 --steps-max 8 --law limited --status located --integrator hht"
    _, out, _ = run_command(capsys, "recommend", "--eta", "2.76", *held.split())
    assert out.startswith("eta = 2.76, steps cut at contact changes, HHT(alpha=-0.05), law limited, tolerance 50 %\n")


def test_sweeps(capsys, tmp_path):
    few = ["--transient", "20", "--sample", "4", "--status", "located", "--law", "limited"]
    plane = ["--eta", "2.76", "--K", "500:2000:2", "--D", "5:20:2", "--steps", "100"]
    diagram = ["--from", "2.6", "--to", "2.76", "--count", "2", "--solver", "newmark", "--K", "500", "--D", "5"]
    for name, words in {"plane": plane, "eta": [*diagram, "--steps", "100"]}.items():
        out = tmp_path / f"{name}.zarr"
        status, _, err = run_command(capsys, "sweep", name, *words, *few, "--out", str(out))
        assert status == 0, err
    method = TimeStepping(500, 5, 100, status="located", law="limited")
    alone = simulate(System(), 2.76, method, periods=24, keep=4)
    swept = xarray.open_zarr(tmp_path / "eta.zarr")
    np.testing.assert_allclose(swept["xi2"][-1], alone.section[:, 2], rtol=0, atol=1e-12)
    assert xarray.open_zarr(tmp_path / "plane.zarr")["error"].shape == (2, 2)
