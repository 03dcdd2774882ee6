"""``vibroscope sweep``: the contract for scripts, and what a person at a terminal sees."""

import json
import os
import pty
import re
import signal
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import xarray
from vibroscope.app.commands.cli import main
from vibroscope.engine import Cancelled, Progress

ROOT = Path(__file__).parents[2]
ETA = ["sweep", "eta", "--from", "2.7", "--to", "3.2", "--count", "6", "--transient", "50", "--sample", "8"]
PLANE = ["sweep", "plane", "--eta", "2.76", "--K", "100:10000:4", "--D", "1:50:3", "--transient", "50", "--sample", "8"]


def summary(capsys, *arguments):
    assert main([*arguments, "--json"]) == 0
    return json.loads(capsys.readouterr().out)


def test_a_diagram_as_the_contract_says(tmp_path, capsys):
    path = str(tmp_path / "eta.zarr")
    answer = summary(capsys, *ETA, "--solver", "reference", "--out", path)
    assert answer["path"] == path
    assert {name: answer[name] for name in ("cells", "computed", "reused", "failed")} == {
        "cells": 6,
        "computed": 6,
        "reused": 0,
        "failed": 0,
    }
    assert answer["seconds"] > 0
    found = xarray.open_zarr(path)
    assert found["xi2"].sizes == {"eta": 6, "sample": 8}
    assert {"period", "impacts_per_period", "contact_share", "motion"} <= set(found)
    np.testing.assert_array_equal(found["eta"], np.linspace(2.7, 3.2, 6))
    assert summary(capsys, *ETA, "--solver", "reference", "--out", path)["reused"] == 6


def test_a_result_is_checked_and_damage_named(tmp_path, capsys):
    path = tmp_path / "eta.zarr"
    summary(capsys, *ETA, "--solver", "reference", "--out", str(path))
    assert main(["sweep", "check", str(path)]) == 0
    assert capsys.readouterr().out == f"{path} is whole\n"
    (path / "xi2" / "zarr.json").write_text("{")
    assert main(["sweep", "check", str(path)]) == 1
    assert f"{path}/xi2/zarr.json: missing, damaged, or of something else\n" in capsys.readouterr().out
    assert main(["sweep", "check", str(path), "--json"]) == 1
    assert json.loads(capsys.readouterr().out) == {"path": str(path), "damaged": ["xi2/zarr.json"], "finished": True}
    assert summary(capsys, *ETA, "--solver", "reference", "--out", str(path))["reused"] == 6


@pytest.mark.parametrize("solver", [["--steps", "500"], ["--steps", "100", "--located"], ["--solver", "exact"]])
def test_a_plane_as_the_contract_says(tmp_path, capsys, solver):
    path = str(tmp_path / "plane.zarr")
    assert summary(capsys, *PLANE, *solver, "--out", path)["cells"] == 12
    found = xarray.open_zarr(path)
    assert {"period", "impacts_per_period", "error", "error_regularisation", "D_equal_restitution"} <= set(found)
    assert ("longest_contact_steps" in found) == ("--steps" in solver)
    np.testing.assert_allclose(np.diff(np.log(found["K"])), np.log(100) / 3)
    assert found["error"].dims == ("K", "D")


def test_a_time_step_study_as_the_contract_says(tmp_path, capsys):
    path = str(tmp_path / "step.zarr")
    command = ["sweep", "step", "--eta", "2.76", "--K", "12000", "--D", "18", "--steps", "500,1000"]
    assert (
        summary(capsys, *command, "--transient", "50", "--sample", "8", "--out", path)["cells"] == 4
    )  # fixed and located
    found = xarray.open_zarr(path)
    assert found["spread"].sizes == {"steps": 2, "scheme": 2}
    assert {"order_of_spread", "scatter", "order_of_scatter", "xi1", "v1", "tau", "error", "period"} <= set(found)


def test_what_cannot_be_written_is_shown(tmp_path, capsys):
    (tmp_path / "file").write_text("mine")
    assert main([*ETA, "--solver", "reference", "--out", str(tmp_path / "file")]) == 1
    assert "give a place that can be written" in capsys.readouterr().err
    assert main([*ETA, "--solver", "reference", "--out", str(tmp_path)]) == 2
    assert (tmp_path / "file").read_text() == "mine"


@pytest.mark.parametrize(
    ("kind", "options"),
    [("plane", "--K 100:10000:3 --D 1:100:3 --steps 100"), ("no-solution", "--K 100:10000:3 --D 18 --steps 10:1000:3")],
)
def test_the_axes_of_a_plane_grow_by_equal_factors(monkeypatch, tmp_path, kind, options):
    def grows(study, how):
        other = study.steps if kind == "no-solution" else np.multiply(study.D, 10)
        np.testing.assert_allclose((study.K, other), ([100, 1000, 10_000], [10, 100, 1000]))
        raise Cancelled

    monkeypatch.setattr("vibroscope.app.commands.sweep.grow", grows)
    assert main(["sweep", kind, "--eta", "2.76", *options.split(), "--out", str(tmp_path / "x.zarr")]) == 130


@pytest.mark.parametrize(("seconds", "left"), [(50, "50 s"), (1800, "30 min"), (7200, "2.0 h")])
def test_a_person_sees_how_long_a_study_still_takes(monkeypatch, capsys, tmp_path, seconds, left):
    def grows(study, how):
        how.progress(Progress(done=10, total=20, computed=10, reused=0, failed=0, seconds=seconds))
        raise Cancelled

    monkeypatch.setattr("vibroscope.app.commands.sweep.grow", grows)
    monkeypatch.setattr(sys.stderr, "isatty", lambda: True)
    assert main([*ETA, "--solver", "reference", "--out", str(tmp_path / "x.zarr")]) == 130
    assert f"10 of 20 cells, {10 / seconds:.3g} a second, {left} left" in capsys.readouterr().err


SLOW = {  # 4,000 cells, of which the fastest machine computes a few before the signal
    "eta": "--from 1.6 --to 1.8 --count 4000 --solver newmark --K 3000 --D 10 --steps 2000",
    "plane": "--eta 1.7 --K 3000:4000:80 --D 8:12:50 --steps 2000",
}


@pytest.mark.parametrize("study", SLOW)
def test_ctrl_c_keeps_what_is_done_and_says_how_to_go_on(tmp_path, study):
    """At a terminal, with progress on it from the beginning; the signal comes once the first cells are computed."""
    path = str(tmp_path / "eta.zarr")
    command = ["sweep", study, *SLOW[study].split(), "--transient", "20000", "--sample", "20"]
    ours, theirs = pty.openpty()
    program = f"import sys; from vibroscope.app.commands.cli import main; sys.exit(main({[*command, '--out', path]!r}))"
    process = subprocess.Popen([sys.executable, "-c", program], cwd=ROOT, stderr=theirs, stdout=subprocess.DEVNULL)
    os.close(theirs)
    seen = b""
    with process:
        while b"a second" not in seen:
            seen += os.read(ours, 1000)
        process.send_signal(signal.SIGINT)
        try:
            while more := os.read(ours, 1000):
                seen += more
        except OSError:  # the terminal is closed
            pass
        assert process.wait(60) == 130
    os.close(ours)
    assert re.match(rb"\r0 of 4000 cells after \d+ s", seen)
    assert b"goes on from there" in seen
    assert b"Traceback" not in seen
    assert xarray.open_zarr(path).attrs["complete"] == 0
