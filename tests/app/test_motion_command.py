"""``vibroscope motion``: its JSON and its text."""

import json
import re

import pytest
from vibroscope.app.commands.cli import main

NEWMARK = ["--solver", "newmark", "--eta", "2.76", "--K", "12000", "--D", "18"]


def printed(capsys, *arguments):
    assert main(["motion", *arguments]) == 0
    return capsys.readouterr().out


def as_json(capsys, *arguments):
    return json.loads(printed(capsys, *arguments, "--json"))


def test_a_periodic_motion(capsys):
    found = as_json(capsys, "--solver", "reference", "--eta", "1.08")
    assert (found["type"], found["period"], found["impacts_per_period"]) == ("periodic", 1, 10)
    assert 0.2 < found["contact_share"] < 0.3
    assert found["lyapunov"] < 0
    assert [len(pair) for pair in found["floquet"]] == [2, 2, 2, 2]
    assert (found["solver"], found["eta"]) == ("reference", 1.08)


def test_a_chaotic_motion(capsys):
    found = as_json(capsys, "--solver", "reference", "--eta", "1.70")
    assert (found["type"], found["period"], found["floquet"]) == ("chaotic", 0, [])
    assert 0.24 < found["lyapunov"] < 0.28


def test_step_noise_is_named(capsys):
    found = as_json(capsys, *NEWMARK, "--steps", "2000")
    assert (found["type"], found["period"]) == ("periodic", 1)
    assert found["step_noise"] > 0.1
    text = printed(capsys, *NEWMARK, "--steps", "2000")
    assert "an artefact of the time step" in " ".join(text.split())
    amount, periods = re.search(r"blurred by the time step \(±([\d.]+) in ξ₂\)", text)[1], len(found["section"])
    assert f"(±{amount} at T/2000, ±" in text  # one scatter, in the name of the motion and in its evidence
    assert f"in ξ₂, over {periods} periods)" in " ".join(text.split())
    made = found["energy_created"]
    assert f"{'created' if made > 0 else 'removed'} by the time step {abs(made):.4g}" in text
    assert found["step_noise"] == found["scatter"] == found["bands"][0][1]


def test_a_run_that_blows_up_is_a_result(capsys):
    found = as_json(capsys, "--solver", "newmark", "--eta", "2.76", "--K", "1e9", "--D", "1e3", "--steps", "20")
    assert (found["type"], found["lyapunov"], found["floquet"]) == ("diverged", None, [])
    assert "blew up" in printed(
        capsys, "--solver", "newmark", "--eta", "2.76", "--K", "1e9", "--D", "1e3", "--steps", "20"
    )


def test_attractors_side_by_side(capsys):
    options = ("--solver", "reference", "--eta", "3.2", "--attractors", "--starts", "12")
    found = as_json(capsys, *options)["attractors"]
    assert {each["period"] for each in found} == {2, 6}
    assert sum(each["share"] for each in found) == pytest.approx(1)
    assert printed(capsys, *options).count("% of starts") == 2
