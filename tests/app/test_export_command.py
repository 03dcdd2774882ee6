"""`vibroscope export` and the menu "Take away" write decks of what is set, and say what a code cannot express."""

import json
import re
from dataclasses import replace

import pytest
from vibroscope.app.commands.cli import main
from vibroscope.app.export.decks import DECKS, DeckProblem, deck, modelica
from vibroscope.app.page.tabs import VIEWS
from vibroscope.app.page.take_away import TakeAway, file_writer
from vibroscope.engine import (
    HHT,
    Excitation,
    HHTInterpolated,
    Newmark,
    NewmarkBeta,
    Record,
    System,
    TimeStepping,
    Units,
    simulate,
    with_located_steps,
)

from tests.app.command_line import PHYSICAL, run_shell
from tests.app.fakes import FakeHost, QueueingHost
from tests.app.filled_tabs import ADDRESS, SETTING

NUMBERS = ["--eta", "2.76", "--K", "12000", "--D", "18", "--steps", "200"]


def export(*words):
    return main(["export", *words])


def test_a_deck_is_printed_or_written(capsys, tmp_path):
    assert export("--to", "opensees", *NUMBERS) == 0
    printed = capsys.readouterr().out
    assert export("--to", "opensees", *NUMBERS, "--out", str(tmp_path / "mine.py")) == 0
    assert capsys.readouterr().out == ""
    assert (tmp_path / "mine.py").read_text() == printed.replace("two_bodies", "mine")
    assert (
        "--measured mine.csv --eta 2.76 --K 12000 --D 18 --steps 200 --integrator newmark"
        in (tmp_path / "mine.py").read_text()
    )


@pytest.mark.parametrize("code", DECKS)
def test_numbers_have_units_where_the_system_has_them(code, capsys, tmp_path):
    file = tmp_path / "my.toml"
    file.write_text(PHYSICAL)
    own = [word for word in NUMBERS if word not in ("--eta", "2.76")]
    texts = []
    for more in ([], ["--units", "mm-t-s"]):
        assert export("--to", code, *own, "--periods", "1", "--system", str(file), *more) == 0
        texts.append(capsys.readouterr().out)
    assert export("--to", code, *NUMBERS, "--periods", "1") == 0
    texts.append(capsys.readouterr().out)
    for text, words in zip(texts, ("Units: s, m, kg, N.", "Units: s, mm, t, N.", "omega1 = 1 rad/s"), strict=True):
        assert words in text
        text.encode("ascii")


@pytest.mark.parametrize("law", modelica.LAWS)
def test_modelica_has_the_laws_that_are_piecewise_linear(law, capsys):
    """The menu and the command alike, whatever contact status the page has."""
    own = {"penetration": 0.5, "stiffening": 3.0} if law == "bilinear" else {}
    options = [word for name, value in own.items() for word in (f"--{name}", f"{value:g}")]
    assert export("--to", "modelica", "--law", law, *options, *NUMBERS) == 0
    equation = f"force = (if depth >= 0 then {modelica.LAWS[law].format(more=2.0, knee=0.5)} else 0);"
    assert equation in capsys.readouterr().out
    for status in ("start", "end"):
        setting = SETTING._replace(law=law, status=status, without_solution="halve", **own)
        assert equation in file_writer(VIEWS["help"](FakeHost()), "deck:modelica", setting, ADDRESS)()["text"]


def test_a_status_that_is_not_given_is_left_to_the_code(capsys):
    assert export("--to", "calculix", "--integrator", "hht", *NUMBERS, "--periods", "1") == 0
    assert "ALPHA=-5.0" in next(line for line in capsys.readouterr().out.splitlines() if line.startswith("*DYNAMIC"))
    explicit = SETTING._replace(integrator="central-difference")
    with pytest.raises(ValueError, match="CalculiX cannot express integrator = 'central-difference'"):
        file_writer(VIEWS["help"](FakeHost()), "deck:calculix", explicit, ADDRESS)()


@pytest.mark.parametrize("code", DECKS)
def test_the_page_offers_each_deck(code):
    tab = VIEWS["help"](FakeHost())
    file = file_writer(tab, f"deck:{code}", SETTING._replace(steps=5000), ADDRESS)()
    assert file["name"] == f"two_bodies.{DECKS[code].SUFFIX}"
    assert "eta = 2.76, K = 12000.0, D = 18.0, 5000 steps" in file["text"]
    assert file_writer(tab, "deck:", SETTING, ADDRESS) is file_writer(tab, "deck:nastran", SETTING, ADDRESS) is None


def test_the_page_says_what_it_cannot_write():
    host = QueueingHost()
    explicit = SETTING._replace(integrator="central-difference")
    TakeAway(host, lambda *_: None).request("deck:calculix", VIEWS["help"](host), explicit, ADDRESS)
    host.catch_up()
    (error,) = host.errors
    assert error.startswith("This file was not written: CalculiX cannot express integrator = 'central-difference'")


OWN = System(mu=0.8, d3=None, clearance=0.3, restitution=0.7, excitation=Excitation(base=0.8, force1=0.7))
WALL = System(wall=True, d1=0.07, clearance=0.5, restitution=0.8)
MM, SI, START = Units(30.0, 5.0, 2.0, "mm-t-s"), Units(62.8, 25.0, 0.25), (-0.2, 0.1, 0.3, 0.0)
AWAY = {  # code: system, method, units, start
    "opensees": (OWN, TimeStepping(900, None, 400, HHTInterpolated(-0.2), law="flores"), SI, START),
    "calculix": (WALL, TimeStepping(100, 2, 400, HHT(-0.2)), MM, None),
    "abaqus": (System(), Newmark(200, 8, 400), None, START),
    "ansys": (OWN, TimeStepping(300, 2, 400, NewmarkBeta(0.3025, 0.6), initial_acceleration="zero"), MM, START),
    "modelica": (WALL, Newmark(584, 2, 400, law="cut"), SI, (-0.2, 0.1, 0.0, 0.0)),
}


def as_the_code_has_it(code, method):
    """The method with the contact status of a code, which a problem leaves to it."""
    status = DECKS[code].STATUS
    return with_located_steps(method) if status == "located" else replace(method, status=status)


@pytest.mark.parametrize("code", DECKS)
def test_the_commands_of_a_deck_lay_our_own_motion_over_itself(code, tmp_path, capsys):
    """The result of the code is made by our run of what the deck says: the commands must find that very run."""
    system, method, units, start = AWAY[code]
    problem = DeckProblem(system, 2.3, method, units, start, periods=2, keep=2, name="mine")
    text = deck(code, problem)
    (tmp_path / f"mine.{DECKS[code].SUFFIX}").write_text(text)
    record = Record(periods=4, per_period=200)
    run = simulate(system, 2.3, as_the_code_has_it(code, method), initial=start, record=record)
    assert run.ok, run.message
    path = run.trajectory
    scale = [problem.scale.physical("time", 1.0), *2 * [problem.length]]
    rows = zip(path.time - path.time[0], *path.displacement, strict=True)
    lines = [", ".join(repr(float(x * of)) for x, of in zip(row, scale, strict=True)) for row in rows]
    (tmp_path / "mine.csv").write_text("\n".join([problem.header, *lines]))
    shell = "\n".join(re.findall(r"^[*!/ ]*((?:sed|vibroscope compare) .*)$", text, re.MULTILINE))
    shell = shell.replace("vibroscope compare", "vibroscope compare --json")
    found = json.loads(run_shell(capsys, shell, tmp_path))
    assert found["measured"]["frame"] == "relative"
    assert found["penalty"]["status"] == "ok"
    assert found["penalty"]["rms"] < 1e-4
