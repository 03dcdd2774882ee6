"""`vibroscope export` and the menu "Take away" write decks of what is set, and say what a code cannot express."""

import pytest
from vibroscope.app.commands.cli import main
from vibroscope.app.export.decks import DECKS, modelica
from vibroscope.app.page.tabs import TABS
from vibroscope.app.page.take_away import TakeAway, file_writer

from .command_line import PHYSICAL
from .fakes import FakeHost, QueueingHost
from .filled_tabs import ADDRESS, SETTING

NUMBERS = ["--eta", "2.76", "--K", "12000", "--D", "18", "--steps", "200"]


def export(*words):
    return main(["export", *words])


def test_a_deck_is_printed_or_written(capsys, tmp_path):
    assert export("--to", "opensees", *NUMBERS) == 0
    printed = capsys.readouterr().out
    assert export("--to", "opensees", *NUMBERS, "--out", str(tmp_path / "mine.py")) == 0
    assert capsys.readouterr().out == ""
    assert (tmp_path / "mine.py").read_text() == printed.replace("two_bodies", "mine")
    assert "--measured mine.csv --eta 2.76 --K 12000.0 --D 18.0 --steps 200\n" in (tmp_path / "mine.py").read_text()


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


REFUSED = {
    "status": (["--to", "calculix", "--status", "start"], "CalculiX cannot express status = 'start'"),
    "located": (["--to", "ansys", "--located"], "Ansys Mechanical APDL cannot express status = 'located'"),
    "integrator": (["--to", "opensees", "--integrator", "bathe"], "OpenSeesPy cannot express integrator = 'bathe'"),
    "law": (["--to", "abaqus", "--law", "cut"], "Abaqus/Standard cannot express law = 'cut'"),
    "periods": (["--to", "opensees", "--periods", "0"], "periods = 0"),
    "keep": (["--to", "opensees", "--periods", "3", "--keep", "4"], "keep = 4"),
}


@pytest.mark.parametrize("kind", REFUSED)
def test_what_cannot_be_written_is_refused_in_one_line(kind, capsys):
    words, text = REFUSED[kind]
    assert export(*words, *NUMBERS) == 2
    error = capsys.readouterr().err
    assert text in error
    assert error.count("\n") == 1


@pytest.mark.parametrize("law", modelica.LAWS)
def test_modelica_has_the_laws_that_are_piecewise_linear(law, capsys):
    """The menu and the command alike, whatever contact status the page has."""
    assert export("--to", "modelica", "--law", law, *NUMBERS) == 0
    equation = f"force = if depth >= 0 then {modelica.LAWS[law]} else 0;"
    assert equation in capsys.readouterr().out
    for status in ("start", "end"):
        setting = SETTING._replace(law=law, status=status, without_solution="halve")
        assert equation in file_writer(TABS["help"](FakeHost()), "deck:modelica", setting, ADDRESS)()["text"]


def test_a_status_that_is_not_given_is_left_to_the_code(capsys):
    assert export("--to", "calculix", "--integrator", "hht", *NUMBERS, "--periods", "1") == 0
    assert "ALPHA=-5.0" in next(line for line in capsys.readouterr().out.splitlines() if line.startswith("*DYNAMIC"))
    explicit = SETTING._replace(integrator="central-difference")
    with pytest.raises(ValueError, match="CalculiX cannot express integrator = 'central-difference'"):
        file_writer(TABS["help"](FakeHost()), "deck:calculix", explicit, ADDRESS)()


@pytest.mark.parametrize("code", DECKS)
def test_the_page_offers_each_deck(code):
    tab = TABS["help"](FakeHost())
    file = file_writer(tab, f"deck:{code}", SETTING._replace(steps=5000), ADDRESS)()
    assert file["name"] == f"two_bodies.{DECKS[code].SUFFIX}"
    assert "eta = 2.76, K = 12000.0, D = 18.0, 5000 steps" in file["text"]
    assert file_writer(tab, "deck:", SETTING, ADDRESS) is file_writer(tab, "deck:nastran", SETTING, ADDRESS) is None


def test_the_page_says_what_it_cannot_write():
    host = QueueingHost()
    explicit = SETTING._replace(integrator="central-difference")
    TakeAway(host, lambda *_: None).request("deck:calculix", TABS["help"](host), explicit, ADDRESS)
    host.catch_up()
    (error,) = host.errors
    assert error.startswith("This file was not written: CalculiX cannot express integrator = 'central-difference'")
