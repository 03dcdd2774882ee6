"""A damper that follows from the restitution, on the page: what is run, shown, linked, and taken away."""

import pytest
from vibroscope.app.codes.catalogue import codes
from vibroscope.app.commands.cli import main
from vibroscope.app.explorer.compute import compute_runs
from vibroscope.app.explorer.errors import Refused
from vibroscope.app.explorer.explanation import describe
from vibroscope.app.explorer.link import parse_address, print_address
from vibroscope.app.explorer.method_words import words_of_method
from vibroscope.app.explorer.physical_fields import entered
from vibroscope.app.explorer.reading import read_setting
from vibroscope.app.explorer.state import Setting
from vibroscope.app.explorer.suggestion import make_question
from vibroscope.app.export.decks import deck, problem_of
from vibroscope.app.export.formats import as_toml, loaded_from_toml
from vibroscope.app.export.report import setting_rows
from vibroscope.app.export.scripts import as_command, as_python
from vibroscope.app.page.controls.controls import Controls
from vibroscope.app.page.tabs import VIEWS
from vibroscope.app.studies.your_code import code_lines, code_texts
from vibroscope.engine import LAWS_BY_RESTITUTION, ExactPenalty, TimeStepping, effective_restitution
from vibroscope.engine.law_table import RATIO_LAWS

from tests.app.fakes import FakeHost

COARSE = Setting(eta=2.76, K=12000.0, D=18.0, steps=200)


def follows(law, **more):
    return read_setting({"law": law, "damper": "restitution"}, COARSE._replace(**more))


@pytest.mark.parametrize("law", LAWS_BY_RESTITUTION)
def test_the_authors_formula_is_run_linked_and_taken_away(law):
    setting = follows(law, eta=1.08, K=2500.0, status="end", restitution=0.6)
    assert setting.penalty == TimeStepping(2500.0, None, 200, status="end", law=law)
    assert read_setting(parse_address(print_address(setting))) == setting
    assert read_setting(loaded_from_toml(as_toml(setting)).texts) == setting
    assert "damping=None" in as_python(setting)
    assert "--D" not in as_command(setting)
    assert dict(row[:2] for row in setting_rows(setting))["D"] == "from the restitution"
    assert words_of_method(setting.penalty).endswith(", its damper from the restitution")
    runs = compute_runs(setting)
    assert runs.penalty.response.method.damping is None
    assert "its damper from the restitution" in describe(runs).penalty[1]


@pytest.mark.parametrize("law", LAWS_BY_RESTITUTION)
def test_the_locked_slider_shows_the_damper_that_results(law):
    """With that D typed, a contact gives the restitution that the formula really gives at a closing speed of 1."""
    controls = Controls()
    setting = follows(law)
    controls.show_setting(setting)
    assert controls.fields["D"]["locked"].startswith("follows from the restitution")
    shown = float(controls.shown["texts"]["D"])
    typed, own = (ExactPenalty(12000.0, D, law) for D in (shown, None))
    expected = effective_restitution(setting.system, own, 1.0)
    assert effective_restitution(setting.system, typed, 1.0) == pytest.approx(expected, rel=1e-9)
    assert float(controls.shown["numbers"]["D"]) == pytest.approx(shown, rel=1e-3)
    assert ("closing speed" in controls.shown["notes"]["D"]) == (law in RATIO_LAWS)
    controls.show_setting(setting._replace(damper="typed"))
    assert (controls.fields["D"]["locked"], controls.shown["texts"]["D"]) == ("", "18")


def test_the_locked_number_is_in_the_units_that_are_shown():
    controls, setting = Controls(), follows("jankowski", units="si", omega1=10.0, m1=2.0)
    controls.show_setting(setting)
    assert float(controls.shown["numbers"]["D"]) == pytest.approx(
        2 * 2.0 * 10.0 * setting.damping[0] * 1.07e-3**-0.25, rel=1e-3
    )
    controls.show_setting(follows("flores", units="si", omega1=10.0, amplitude=3.0))
    assert "at a closing speed of 0.03 m/s" in controls.shown["notes"]["D"]


def test_a_damping_that_is_set_counts_and_other_laws_have_their_own():
    setting = follows("flores")
    assert read_setting({"D": "5"}, setting).penalty.damping == 5.0
    assert read_setting({"law": "limited"}, setting).penalty.damping == 18.0
    assert read_setting(setting.texts()) == setting
    for given in ({"restitution": "0"}, {"law": "jankowski"}):
        with pytest.raises(Refused, match="since its formula divides by it") as refused:
            read_setting(given, setting if "restitution" in given else follows("hunt-crossley", restitution=0.0))
        assert refused.value.name == ("restitution" if "restitution" in given else "damper")
    with pytest.raises(Refused, match="cannot be held"):
        make_question(setting, {"tolerance": "5", "hold": "D"})


def test_the_damper_stays_where_other_units_carry_the_numbers_over():
    setting = follows("flores", units="si")
    texts = entered({"mass1_kg": "2"}, setting)
    assert "D" in texts
    assert read_setting(texts, setting).follows_restitution


@pytest.mark.parametrize("law", RATIO_LAWS)
def test_the_page_writes_the_material_of_hertz_of_opensees(law):
    text = deck("opensees", problem_of(follows(law), "opensees"))
    assert '"Hertzdamp"' in text
    assert "D from the restitution" in text
    with pytest.raises(ValueError, match="restitution gives it"):
        deck("opensees", problem_of(follows(law)._replace(damper="typed"), "opensees"))


def test_chrono_takes_its_damper_from_the_restitution(capsys):
    code = codes()["chrono"]
    setting = read_setting(code_texts(code), COARSE)
    assert setting.penalty == code.method(12000.0, 18.0, 200)
    assert setting.follows_restitution
    assert "material.SetRestitution(0.5)" in code_lines(code, setting)
    assert "material.SetRestitution(0.5)" in code_lines(code, setting._replace(units="si"))
    typed = read_setting({"D": "40"}, setting)
    given = effective_restitution(typed.system, typed.penalty, 2.0)
    assert f"material.SetRestitution({given:.6g})" in code_lines(code, typed)
    assert main(["rules", "lsdyna-soft", "--eta", "2.76", "--code", "chrono", "--periods", "60"]) == 0
    assert "  -  " in capsys.readouterr().out


@pytest.mark.parametrize("key", ["step", "speed", "bifurcation"])
def test_scripts_of_studies_take_the_damper_that_follows(key):
    setting, tab = follows("jankowski"), VIEWS[key](FakeHost())
    tab.build()
    tab.restore(tab.read_view("", "solver:newmark" if key == "bifurcation" else "", ""))
    assert "--D" not in tab.command(setting)
    assert "None" in tab.python(setting)
