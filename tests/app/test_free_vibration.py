"""Where nothing drives the bodies, each view says in one sentence what it cannot show, why, and what to do."""

import math

import pytest
from vibroscope.app.commands.cli import main
from vibroscope.app.explorer.parameters import START_FIELDS
from vibroscope.app.explorer.shelf import shelf
from vibroscope.app.explorer.state import Setting
from vibroscope.app.page.basin.tab import Basins
from vibroscope.app.page.bifurcation.tab import Bifurcation
from vibroscope.app.page.plane.tab import Plane
from vibroscope.app.page.speed.tab import Speed
from vibroscope.app.page.tab import Move
from vibroscope.app.page.time_step.tab import TimeStep
from vibroscope.engine import System, compare_measured, measured_verdict, synthetic_measurement

from tests.app.fakes import Asked, FakeHost
from tests.app.test_study_tab import opened  # noqa: F401 - a fixture

FREE = shelf()["thrown"].setting
AT_REST = FREE._replace(**dict.fromkeys(START_FIELDS, 0.0))
WORDS = {
    Bifurcation: "no motion belongs to a frequency: let the base or a force move them",
    Plane: "each cell of this plane begins at rest, where nothing moves: let the base",
    Basins: "each start leads to rest: let the base",
    TimeStep: "this study needs a motion that lasts: let the base",
    Speed: "this measurement begins at rest, where nothing moves: let the base",
}


@pytest.mark.parametrize("kind", WORDS)
def test_a_study_says_why_it_has_nothing_to_show_and_computes_nothing(opened, kind):  # noqa: F811
    tab, host = opened(kind)
    (driven,) = Asked.all
    free = AT_REST if kind is Speed else FREE
    tab.show(Move(2, free))
    assert driven.cancelled
    assert len(Asked.all) == 1
    ((head, text),) = tab.panel.statements
    assert (head, WORDS[kind] in text, text.count(".")) == ("Nothing to show", True, 1)
    assert tab.summary(free) == host.summary == text
    assert not any(cell.object.visible for cell in tab.cells)
    assert tab.figures() == []
    assert tab.panel.status == {}
    tab.show(Move(3, Setting()))
    assert len(Asked.all) == 2
    assert {cell.object.visible for cell in tab.cells} == {True}
    assert tab.panel.statements == []


def test_the_speed_of_a_free_vibration_is_measured():
    assert Speed(FakeHost()).obstacle(FREE) == ""
    assert "begins at rest" in TimeStep(FakeHost()).obstacle(AT_REST)


def test_a_diagram_over_another_number_needs_an_own_start():
    tab = Bifurcation(FakeHost())
    tab.build()
    tab.view.sweep("restitution")
    assert "this diagram begins at rest" in tab.obstacle(FREE)
    tab.panel.chosen = tab.panel.chosen | {"direction": "own"}
    assert tab.obstacle(FREE) == ""
    assert tab.obstacle(Setting()) == ""


def test_a_measurement_without_its_start_asks_for_it():
    measured = synthetic_measurement(System(), 2.76, periods=4)
    found = compare_measured(FREE.system, FREE.eta, measured, FREE.penalty, periods=60)
    assert measured_verdict(found).startswith(
        "Nothing drives the bodies, and they start at rest, so that nothing moves."
    )
    with pytest.raises(ValueError, match="nothing drives the bodies, so that they come to rest: give what drives them"):
        synthetic_measurement(FREE.system, FREE.eta)


@pytest.mark.parametrize(
    "command",
    ["simulate --solver reference", "motion --solver reference", "compare --K 1e4 --D 20 --steps 2000"],
)
def test_a_drop_needs_no_frequency(capsys, tmp_path, command):
    path = tmp_path / "drop.toml"
    path.write_text("[physical]\nmass1_kg = 2.0\nwall = true\nclearance_mm = 500.0\nconstant1_N = 19.62\n")
    assert main([*command.split(), "--system", str(path), "--initial=-0.5,0,0,0"]) == 0
    assert "eta = 1" in capsys.readouterr().out


def test_the_command_fits_the_restitution_to_a_drop(capsys, tmp_path):
    """A mass falls 1 m on a floor; its rebounds follow from the restitution 0.7."""
    (tmp_path / "drop.toml").write_text(
        "[physical]\nmass1_kg = 1.0\nstiffness1_N_per_m = 1e-4\nwall = true\nclearance_mm = 1000.0\n"
        "length_mm = 1000.0\nconstant1_N = 9.81\nfrequency_Hz = 1.0\nrestitution = 0.5\n"
    )
    (tmp_path / "drop.csv").write_text(
        "\n".join(["time [s],xi1 [m]", *(f"{t},{fallen(t)}" for t in range_of(0.01, 2))])
    )
    options = ["--K", "1e5 N/m", "--D", "0", "--steps", "3000", "--initial", "0,0,0,0", "--fit", "restitution"]
    files = ["--system", str(tmp_path / "drop.toml"), "--measured", str(tmp_path / "drop.csv")]
    assert main(["compare", *options, *files]) == 0
    said = capsys.readouterr().out
    assert "from the start, since nothing drives the bodies" in said
    assert float(said.partition("restitution")[2].split()[0]) == pytest.approx(0.7, abs=1e-5)
    assert "The reference follows the measurement to 0.0" in said


def range_of(step, end):
    return [round(step * i, 6) for i in range(round(end / step) + 1)]


def fallen(time, height=1.0, gravity=9.81, restitution=0.7):
    """The way down of a mass that is let go, in closed form."""
    touch, speed = math.sqrt(2 * height / gravity), restitution * math.sqrt(2 * height * gravity)
    if time < touch:
        return gravity * time**2 / 2
    time -= touch
    while time > 2 * speed / gravity:
        time -= 2 * speed / gravity
        speed *= restitution
    return height - speed * time + gravity * time**2 / 2


@pytest.mark.parametrize(("load", "words"), [(0, "nothing drives the bodies"), (0.5, "only constant forces act")])
def test_a_weight_is_named_where_it_is_all_that_acts(capsys, tmp_path, load, words):
    file = tmp_path / "free.toml"
    file.write_text(f"[excitation]\nbase = 0\nconstant1 = {load}\n")
    simulated = ["simulate", "--solver", "reference", "--eta", "1", "--periods", "2", "--system", str(file)]
    assert main(simulated) == 0
    assert words in capsys.readouterr().err
