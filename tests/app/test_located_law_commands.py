"""``--status located`` with other contact laws than spring and damper: every command that takes both."""

import json

import numpy as np
import pytest
import xarray
from vibroscope.engine import (
    HHT,
    Bathe,
    ComparisonQuestion,
    Newmark,
    System,
    TimeStepping,
    compare,
    recommend,
    simulate,
    verdict,
)

from tests.app.command_line import run_command
from tests.recommended import question
from tests.share import every

CUT = Newmark(1200, 18, 200, located=True, law="cut")
LAWS = {
    "--K 1200 --D 18 --law cut": CUT,
    "--K 1200 --D 18 --law limited": TimeStepping(1200, 18, 200, status="located", law="limited"),
    "--K 1200 --law flores": TimeStepping(1200, None, 200, status="located", law="flores"),
    "--K 1200 --D 18 --law impact --penetration 0.02 --integrator bathe": TimeStepping(
        1200, 18, 200, Bathe(), "located", law="impact", penetration=0.02
    ),
}


def asked(capsys, command, words):
    status, out, err = run_command(capsys, command, "--eta", "2.76", *words.split(), "--json")
    assert (status, err) == (0, "")
    return json.loads(out)


@pytest.mark.parametrize("words", LAWS)
def test_simulate(capsys, words):
    how = f"--solver newmark --steps 200 --status located {words} --periods 6 --keep 2"
    run = simulate(System(), 2.76, LAWS[words], periods=6, keep=2)
    found = asked(capsys, "simulate", how)
    assert found["section"] == run.section.tolist()
    assert (found["steps_without_solution"], found["steps_with_two"]) == (0, 0)
    whole = simulate(System(), 2.76, TimeStepping(1200, 18, 200, law="cut"), periods=6, keep=2)
    assert np.abs(run.section - whole.section).max() > 1e-4  # another solution than with whole steps


@pytest.mark.parametrize("words", every(list(LAWS)[:2]))
def test_compare(capsys, words):
    found = asked(capsys, "compare", f"--steps 200 --status located {words} --periods 60 --keep 8")
    expected = compare(ComparisonQuestion(System(), 2.76, LAWS[words], periods=60, keep=8))
    assert (found["status"], found["law"], found["located"]) == ("located", LAWS[words].law, True)
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
