"""The scripts and commands of every tab find the numbers of the page."""

import numpy as np
import pytest
import xarray
from vibroscope.app.explorer.state import SOLVERS
from vibroscope.app.page.tabs import VIEWS
from vibroscope.app.paper import CLAIMS
from vibroscope.app.studies import basin, bifurcation, plane
from vibroscope.engine import Cells, ExactPenalty, Newmark, run_cells

from tests.app.command_line import run_shell
from tests.app.fakes import FakeHost
from tests.app.filled_tabs import SETTING, filled  # noqa: F401 - a fixture


def test_the_script_of_a_bifurcation_diagram_finds_its_points(filled, capsys):  # noqa: F811
    tab = filled("bifurcation")
    space = {}
    exec(tab.python(SETTING), space)
    found, shown = space["diagram"], tab.data()
    for name in ("eta", "period", *bifurcation.COORDINATES):
        np.testing.assert_array_equal(found[name], shown[name].astype(found[name].dtype))


def test_the_script_of_a_plane_finds_its_cells(filled, monkeypatch, capsys):  # noqa: F811
    tab = filled("plane")
    monkeypatch.setattr("vibroscope.app.page.study.plane.COUNT", 6)
    monkeypatch.setattr(plane, "COUNT", 6)
    space = {}
    exec(tab.python(SETTING), space)
    for name in ("K", "D"):
        np.testing.assert_allclose(space["exact"][name], tab.question(SETTING).axis(name), rtol=1e-14)
    # The last digit of K is enough for another chaotic motion, so the cells are run at exactly the script's K and D.
    K, D = np.meshgrid(space["exact"]["K"], space["exact"]["D"])
    periods = {"transient": plane.TRANSIENT, "sample": plane.SAMPLE}
    for side, method in (("penalty", Newmark(1.0, 1.0, SETTING.steps)), ("exact", ExactPenalty(1.0, 1.0))):
        eta = np.full(K.size, SETTING.eta)
        cells = run_cells(Cells(SETTING.system, eta, method, stiffness=K.ravel(), damping=D.ravel()), **periods)
        for name in ("status", "period", "near_period", "impacts_per_period"):
            found = space[side][name].transpose("D", "K").values
            np.testing.assert_array_equal(found.ravel(), getattr(cells, name))


def test_the_script_of_basins_finds_their_motions(filled, monkeypatch, capsys):  # noqa: F811
    tab = filled("basin")
    monkeypatch.setattr(basin, "COUNT", 6)
    space = {}
    exec(tab.python(SETTING), space)
    question = tab.question(SETTING)
    for side in SOLVERS:
        found = space[side]
        np.testing.assert_array_equal(found["xi2"], question.axis("x"))
        values = question.study(side).compute()
        np.testing.assert_array_equal(found["reached_period"], values["reached_period"])
    assert space["difference"].cells.shape == (6, 6)


def test_the_script_of_the_time_step_study_finds_its_motions(filled, capsys):  # noqa: F811
    tab = filled("step")
    space = {}
    exec(tab.python(SETTING).replace("2000, 4000, 6000, 8000, 16000, 32000", "2000"), space)
    shown = tab.data()
    count = int((shown["steps"] <= 2000).sum())
    assert count > 0
    for name in ("period", "spread", "error_time_step", "xi2_section"):
        np.testing.assert_array_equal(space["study"][name].values[:count], shown[name][:count])


def test_the_script_of_speed_and_error_finds_its_errors(filled, capsys):  # noqa: F811
    tab = filled("speed")
    space = {}
    exec(tab.python(SETTING), space)
    np.testing.assert_array_equal(space["found"].data()["error"], tab.data()["error"])


def test_the_script_of_the_paper_checks_the_claims(monkeypatch, capsys):
    monkeypatch.setattr("vibroscope.app.paper.CLAIMS", {"4C": CLAIMS["4C"]})
    exec(VIEWS["paper"](FakeHost()).python(SETTING), {})
    assert "Figure 4 [C]" in capsys.readouterr().out


@pytest.mark.parametrize("key", ["bifurcation", "plane", "basin", "step"])
def test_the_commands_of_a_study_are_understood_and_make_it(filled, key, tmp_path, monkeypatch, capsys):  # noqa: F811
    tab = filled(key)  # before the cells become few: what a study has found is remembered without their number
    monkeypatch.setattr("vibroscope.app.page.study.plane.COUNT", 3)
    monkeypatch.setattr(plane, "COUNT", 3)
    monkeypatch.setattr(basin, "COUNT", 3)
    monkeypatch.setattr("vibroscope.app.page.study.time_step.STEPS", (500, 1000))
    commands = tab.command(SETTING).replace("--count 30", "--count 3")
    assert "kappa = 2.4" in commands
    run_shell(capsys, commands, tmp_path)
    stores = sorted(path.name for path in tmp_path.glob("*.zarr"))
    made = {"bifurcation": ["eta"], "plane": ["plane1", "plane2"], "basin": ["basin1", "basin2"], "step": ["step"]}[key]
    assert stores == [f"{name}.zarr" for name in made]
    axis = {"bifurcation": "eta", "plane": "K", "basin": "xi2", "step": "steps"}[key]
    for name in stores:
        found = xarray.open_zarr(tmp_path / name)
        # 200 steps per period are too few for the stiffest of the three K that the sliders of this system reach
        assert found.attrs["failed"] == (3 if name == "plane1.zarr" else 0)
        assert found.sizes[axis] == {"step": 2}.get(key, 3)
