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
