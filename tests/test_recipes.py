"""The worked examples of docs/architecture.md: each is followed, in a copy of the engine where it changes code."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from vibroscope.app.explorer.presets import read_shelf
from vibroscope.app.explorer.state import Setting
from vibroscope.app.page.tab import Move
from vibroscope.app.page.take_away import file_writer
from vibroscope.engine import Newmark, simulate

from docs.examples.impacts import Impacts
from tests.app.fakes import QueueingHost

ROOT = Path(__file__).parents[1]
EXAMPLES = ROOT / "docs/examples"
# The twin's run is that of the law, and the step's tends to it.
LAW = """
from dataclasses import replace
import numpy as np
from tests.naive_laws import Motion
from vibroscope.engine import CONTACT_LAWS, ExactPenalty, System, TimeStepping, restitution_of_damping, simulate
from vibroscope.engine.contact import spring_duration, contact_frequency
from vibroscope.engine.contact import spring_energy
law, system, start = "part-limited", System(), (0.0, 0.0, 1.0, 0.0)
assert law in CONTACT_LAWS
method = ExactPenalty(900, 8, law)
run = simulate(system, 2.76, method, periods=2, keep=2, initial=start)
assert len(run.impacts.time) > 0
np.testing.assert_allclose(run.section[-1], Motion(system, 2.76, method).run(start, 2 * run.period), atol=1e-10)
steps = TimeStepping(900, 8, 2000, law=law, status="end")
stepped = simulate(system, 2.76, steps, periods=2, keep=2, initial=start)
np.testing.assert_allclose(stepped.section, run.section, atol=1e-2)
assert 0.0 < restitution_of_damping(law, 8, 900, closing_speed=2.0) < 1.0
# what makes a law piecewise linear holds for skipped steps and for those that are cut at its kinks
every = simulate(system, 2.76, replace(steps, status="start", every_step=True), periods=1, keep=1, initial=start)
skipped = simulate(system, 2.76, replace(steps, status="start"), periods=1, keep=1, initial=start)
np.testing.assert_allclose(skipped.section, every.section, atol=1e-9)
located = simulate(system, 2.76, replace(steps, status="located"), periods=2, keep=2, initial=start)
np.testing.assert_allclose(located.section, run.section, atol=2e-3)
assert np.isclose(spring_duration(system.mass_share, method, 2.0), np.pi / contact_frequency(system, 900))
assert np.isclose(spring_energy(method, np.array([-0.1]))[0], 0.5 * 900 * 0.1**2)
"""
INTEGRATOR = """
import numpy as np
from tests.naive_stepping import Twin
from vibroscope.engine import INTEGRATORS, NewmarkBeta, System, TimeStepping, simulate
method, other = (
    TimeStepping(900, 8, 500, integrator=own) for own in (INTEGRATORS["fox-goodwin"](), NewmarkBeta(1 / 12))
)
run, same = (simulate(System(), 2.76, each, periods=2, keep=2) for each in (method, other))
np.testing.assert_array_equal(run.section, same.section)
np.testing.assert_allclose(run.section, Twin(System(), 2.76, method).run(2), atol=1e-10)
"""


@pytest.fixture
def copy(tmp_path):
    """A copy of the engine and of the twins, which `vibroscope.engine` is where PYTHONPATH names it."""
    (tmp_path / "vibroscope").mkdir()
    shutil.copytree(ROOT / "engine", tmp_path / "engine", ignore=shutil.ignore_patterns("__pycache__"))
    (tmp_path / "vibroscope/engine").symlink_to(tmp_path / "engine")
    (tmp_path / "tests").mkdir()
    for twin in (ROOT / "tests").glob("naive*.py"):
        shutil.copy(twin, tmp_path / "tests")
    return tmp_path


@pytest.mark.parametrize(("example", "script"), [("part_limited", LAW), ("fox_goodwin", INTEGRATOR)])
def test_a_change_of_the_engine(copy, example, script):
    subprocess.run(["git", "apply", EXAMPLES / f"{example}.diff"], cwd=copy, check=True)
    # uncompiled: these few steps take less than the compiler would
    variables = {**os.environ, "PYTHONPATH": str(copy), "NUMBA_DISABLE_JIT": "1"}
    subprocess.run([sys.executable, "-c", script], cwd=copy, env=variables, check=True, timeout=300)


def test_a_tab_with_a_figure():
    host, setting = QueueingHost(), Setting(eta=1.08)
    tab = Impacts(host)
    tab.build()
    tab.show(Move(1, setting))
    host.catch_up_until(lambda: tab.panel.status.get("text") == "complete")
    run = simulate(setting.system, setting.eta, setting.reference, periods=3000, keep=1000)
    np.testing.assert_array_equal(
        tab.view.sources["impacts"].data["speed"], run.impacts.closing_speed.astype(np.float32)
    )
    assert tab.ranges["speed"].ends[1] > run.impacts.closing_speed.max()
    assert str(len(run.impacts.closing_speed)) in tab.summary(setting).replace(",", "")
    assert [figure.name for figure in tab.figures()] == ["impacts"]
    lines = file_writer(tab, "csv:impacts", setting, "")()["text"].splitlines()
    assert len([line for line in lines if not line.startswith("#")]) > len(run.impacts.time)
    tab.close()


def test_a_system_of_the_shelf():
    (system,) = read_shelf((EXAMPLES / "shelf.toml").read_text()).values()
    setting = system.setting
    assert system.matches(setting)
    assert setting.system.wall
    assert simulate(setting.system, setting.eta, Newmark(setting.K, setting.D, int(setting.steps)), periods=300).ok
