"""``--stiffness-of-step`` gives every command that takes it the K that follows, and no other command takes it."""

import json

import numpy as np
import pytest
import xarray
from vibroscope.app.commands.cli import main
from vibroscope.engine import System, stiffness_of_step

from tests.share import every

BY_STEP = stiffness_of_step(System(), 2.76, 200, 0.1)
SHORT = ["--eta", "2.76", "--D", "18", "--steps", "200"]
RULE = ["lsdyna-noise", "--periods", "60"]
COMMANDS = {
    "simulate": ["simulate", "--solver", "newmark", "--periods", "6", "--keep", "2", "--json"],
    "motion": ["motion", "--solver", "newmark", "--json"],
    "compare": ["compare", "--periods", "60", "--json"],
    "rules": ["rules", *RULE, "--json"],
    "rules of a code": ["rules", *RULE, "--code", "calculix", "--json"],
    "export": ["export", "--to", "opensees", "--periods", "2"],
}


def printed(capsys, *arguments):
    assert main([*arguments]) == 0
    return capsys.readouterr().out


def comparable(text):
    """What was printed, without how long it took."""
    try:
        found = json.loads(text)
    except json.JSONDecodeError:
        return text
    found.pop("cost", None)
    found.pop("seconds", None)
    return found


@pytest.mark.parametrize("name", every(COMMANDS))
def test_k_is_that_of_the_step(capsys, name):
    command = [*COMMANDS[name], *SHORT]
    follows = printed(capsys, *command, "--stiffness-of-step", "0.1")
    assert comparable(follows) == comparable(printed(capsys, *command, "--K", repr(BY_STEP)))
    assert comparable(follows) != comparable(printed(capsys, *command, "--K", "2500"))


def test_basins_are_of_the_k_that_follows(capsys, tmp_path):
    axes = ["--x", "xi2:0:4:2", "--y", "v2:-2:2:2", "--transient", "20", "--sample", "32"]
    for name, K in {"follows": ["--stiffness-of-step", "0.1"], "given": ["--K", repr(BY_STEP)]}.items():
        printed(capsys, "sweep", "basin", "--solver", "newmark", *axes, *SHORT, *K, "--out", str(tmp_path / name))
    follows, given = (xarray.open_zarr(tmp_path / name) for name in ("follows", "given"))
    assert follows.drop_attrs().identical(given.drop_attrs())


@pytest.mark.parametrize("more", every([["--integrator", "hht", "--status", "end", "--without-solution", "keep"], []]))
def test_each_number_of_steps_has_a_model_of_its_own(capsys, tmp_path, more):
    """Half the step has four times K: errors are against the exact solution and the reference of that model."""
    study = ["sweep", "step", "--eta", "2.76", "--D", "18", "--transient", "50", "--sample", "8", *more]

    def found(name, steps, *K):
        printed(capsys, *study, "--steps", steps, *K, "--out", str(tmp_path / name))
        return xarray.open_zarr(tmp_path / name).load()

    both = found("both", "200,400", "--stiffness-of-step", "0.1")
    np.testing.assert_allclose(both["K"], [BY_STEP, 4 * BY_STEP], rtol=1e-12)
    for n, K in ((200, BY_STEP), (400, float(both["K"][1]))):
        alone = found(f"alone{n}", str(n), "--K", repr(K))
        for name in ("error", "error_time_step", "xi2_section"):
            np.testing.assert_array_equal(both[name].sel(steps=n), alone[name].sel(steps=n))


WITHOUT = {
    "recommend": ["recommend", "--eta", "2.76"],
    "branch": ["branch", "--solver", "exact", "--eta", "2.76", "--D", "18", "--from", "1", "--to", "2"],
    "eta": ["sweep", "eta", "--from", "1", "--to", "2", "--count", "2", "--solver", "newmark"],
    "plane": ["sweep", "plane", "--eta", "2.76", "--K", "10:20:2", "--D", "1:2:2", "--steps", "100"],
    "no-solution": ["sweep", "no-solution", "--eta", "2.76", "--K", "10:20:2", "--D", "1", "--steps", "100:200:2"],
}


@pytest.mark.parametrize("name", WITHOUT)
def test_where_k_cannot_follow_the_step_the_option_is_refused_in_one_line(capsys, tmp_path, name):
    out = ["--out", str(tmp_path / "store")] if "sweep" in WITHOUT[name] else []
    refuse(capsys, [*WITHOUT[name], *out, "--stiffness-of-step", "0.1"], "--stiffness-of-step is no option")


@pytest.mark.parametrize("name", COMMANDS)
def test_it_does_not_go_with_k(capsys, name):
    both = [*COMMANDS[name], *SHORT, "--K", "1200", "--stiffness-of-step", "0.1"]
    refuse(capsys, both, "--stiffness-of-step: not allowed with argument --K")


def test_one_of_both_is_needed_where_nothing_else_gives_k(capsys):
    refuse(capsys, ["compare", *SHORT], "--K --stiffness-of-step is required")


def refuse(capsys, arguments, words):
    with pytest.raises(SystemExit) as end:
        main(arguments)
    assert end.value.code == 2
    error = capsys.readouterr().err
    assert words in error
    assert error.count("\n") == 1
