"""``vibroscope validate``, its published cases, and the shelf of published systems."""

import json
import math
import tomllib
from dataclasses import replace
from importlib import import_module
from pathlib import Path

import pytest
from vibroscope.app.commands import cli
from vibroscope.app.commands import validate as command
from vibroscope.app.runtime.files import asset
from vibroscope.app.validation import cases, validate
from vibroscope.engine import ComparisonQuestion, ExactPenalty, Newmark, compare, simulate, system_of_physical, verdict

ROOT = Path(__file__).parents[2]
CASES = {case.key: case for case in cases()}
SHELF = tomllib.loads(asset("validation/shelf.toml"))["system"]
CODES = ("Code_Aster", "Budd", "Dankowicz", "Nordmark", "Shaw", "Kirchner", "Reference-FMUs", "Spheral", "Textbook")


@pytest.mark.parametrize("key", CASES)
def test_our_figures_are_the_recomputed_ones(key):
    found = list(validate([CASES[key]]))
    assert found
    for compared in found:
        assert compared.agrees, f"{compared.quantity.what}: {compared.ours!r}"


def test_the_benchmarks_and_six_more_cases_are_there():
    more = [key for key in CASES if not key.startswith("B")]
    assert {key.split("-")[0] for key in CASES if key.startswith("B")} == {"B1", "B2", "B3", "B4", "B5", "B6"}
    assert len(more) >= 6
    assert len({code for key in more for code in CODES if CASES[key].source.find(code) >= 0}) >= 4


def test_where_the_published_figure_is_off_both_stand_with_the_reason():
    greatest, _ = validate([CASES["B2"]])
    assert greatest.quantity.published == 629.3
    assert greatest.ours == pytest.approx(1120.3451, abs=1e-3)
    assert "keeps every other one" in greatest.quantity.note
    for case in CASES.values():
        for quantity in case.quantities:
            off = quantity.published is not None and abs(quantity.published / quantity.recomputed - 1) > 1e-3
            assert quantity.note or not off, f"{case.key}, {quantity.what}"


def test_our_own_comparison_blames_the_time_step():
    """More exactly what a step does not know of contact: the same steps, located, do nearly as well as none."""
    case = CASES["B2-step"]
    found = verdict(compare(ComparisonQuestion(case.system, case.eta, case.method)))
    assert found.blame == ("status",)
    assert found.left < 0.5 * compare(ComparisonQuestion(case.system, case.eta, case.method)).total


def test_a_wall_and_a_mirrored_body_give_the_same_force():
    (wall, _), (twin, _) = validate([CASES["B2"]]), validate([CASES["B2-twin"]])
    assert twin.ours == pytest.approx(wall.ours, rel=1e-10)


@pytest.fixture
def recompute_published(monkeypatch):
    """The script of this name."""
    monkeypatch.syspath_prepend(ROOT / "tests" / "data")
    return import_module("recompute_published")


@pytest.mark.parametrize(
    "key",
    ["B1", "B3-2.2", "B4", "B5", "backlash", "bounces", "FMU", "contraction", "restitution", "SDND108", "SDND122"],
)
def test_the_file_holds_what_the_script_recomputes(recompute_published, capsys, key):
    """Those of closed form; the others take seconds each."""
    assert recompute_published.compare([key])
    assert key in capsys.readouterr().out


def test_the_script_notices_a_wrong_figure(recompute_published, tmp_path, monkeypatch, capsys):
    wrong = tmp_path / "cases.toml"
    wrong.write_text(asset("validation/cases.toml").replace("recomputed = 9950.37", "recomputed = 9950.38"))
    monkeypatch.setattr(recompute_published, "FILE", wrong)
    assert not recompute_published.compare(["B1"])
    assert "DIFFERS" in capsys.readouterr().out


# ---------------------------------------------------------------------------------------------------------- the command


def test_the_table_has_what_the_issue_asks_for(capsys):
    assert cli.main(["validate", "B1", "B2"]) == 0
    printed = capsys.readouterr().out
    assert "sdnd101a.comm" in printed
    assert "published" in printed
    assert "44 % low" in printed
    assert "8 figures of 2 cases, all as recomputed" in printed


def test_the_value_of_a_formula_is_not_shown_as_a_printed_figure(capsys):
    assert cli.main(["validate", "B3", "B4"]) == 0
    printed = capsys.readouterr().out
    assert " 6.66666667* " in printed
    assert " 0.1 " in printed
    assert "prints a formula and no figure" in printed
    for case in CASES.values():  # whoever prints figures rounds them, or gives a whole number
        exact = [each for each in case.quantities if each.published and len(repr(each.published)) > 15]
        assert case.formula or not exact or case.source.startswith(("Code_Aster", "Modelica")), case.key


def test_json_has_one_object_a_figure(capsys):
    assert cli.main(["validate", "B2", "--json"]) == 0
    greatest, instant = json.loads(capsys.readouterr().out)
    assert (greatest["published"], greatest["unit"]) == (629.3, "N")
    assert greatest["difference"] == pytest.approx(0.78, abs=0.01)
    assert instant["published"] is None
    assert instant["difference"] is None


def test_a_figure_that_is_not_ours_gives_status_1(monkeypatch, capsys):
    case = CASES["B5"]
    wrong = replace(case, quantities=(replace(case.quantities[0], recomputed=3.0),))
    monkeypatch.setattr(command, "cases", lambda: (wrong,))
    assert cli.main(["validate"]) == 1
    assert "1 NOT as recomputed" in capsys.readouterr().out


# ------------------------------------------------------------------------------------------------------------ the shelf


@pytest.mark.parametrize("entry", SHELF, ids=[entry["key"] for entry in SHELF])
def test_a_system_of_the_shelf_can_be_solved_as_it_stands(entry):
    """It says what it answers, where it is from and what is assumed; its steps resolve a contact; the bodies touch."""
    assert entry["question"].endswith("?")
    assert entry["source"]
    assert entry["note"]
    system, units, eta, _ = system_of_physical(entry["physical"])
    stiffness = units.model("stiffness", entry["contact_stiffness_N_per_m"])
    damping = units.model("damping", entry["contact_damping_Ns_per_m"])
    duration = math.pi / math.sqrt(stiffness / system.mass_share)
    assert 10 < duration * entry["steps"] * eta / (2 * math.pi) < 80
    kinds = ("displacement", "velocity") * 2
    start = [units.model(kind, x) for kind, x in zip(kinds, entry.get("start_SI", ()), strict=False)] or system.rest
    exact = simulate(system, eta, ExactPenalty(stiffness, damping), periods=20, keep=20, initial=start)
    assert exact.ok
    assert len(exact.contacts) > 0
    assert simulate(system, eta, Newmark(stiffness, damping, entry["steps"]), periods=20, keep=1, initial=start).ok


def test_the_shelf_has_the_systems_that_the_issue_names():
    named = {"thrown", "wall", "twins", "buildings", "tube", "pair", "gap", "valve", "hammer"}
    assert named <= {entry["key"] for entry in SHELF}
