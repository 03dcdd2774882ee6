"""Scripts, commands and files must reproduce the numbers of the page."""

import csv
import io
import json

import numpy as np
import pytest
from hypothesis import given
from vibroscope.app.explorer.explanation import describe, paragraphs
from vibroscope.app.explorer.present import present
from vibroscope.app.explorer.reading import read_setting, read_values
from vibroscope.app.explorer.state import Setting
from vibroscope.app.export.formats import Series, as_csv, as_toml, loaded_from_toml
from vibroscope.app.export.report import Findings, as_report
from vibroscope.app.export.scripts import as_command, as_python
from vibroscope.app.export.tables import FIGURES, figure_table
from vibroscope.app.page.tabs import VIEWS
from vibroscope.app.runtime.json_text import json_text

from tests.app.command_line import run_shell
from tests.app.explanations import explained, runs_of
from tests.app.fakes import QueueingHost
from tests.app.settings_strategy import settings

PLAIN = Setting()
OTHER = PLAIN._replace(
    eta=2.3,
    K=9000.0,
    steps=100,
    located="yes",
    restitution=0.7,
    joint_damping="derived",
    threshold=0.01,
    start_xi1=-0.5,
    start_xi2=0.25,
    start_v2=-1.5,
)


STEPPED = read_setting(
    {
        "eta": "1.3",
        "K": "300",
        "steps": "400",
        "bodies": "wall",
        "clearance": "0.5",
        "integrator": "hht",
        "alpha": "-0.2",
    }
    | {"status": "end", "without_solution": "keep", "law": "flores", "damper": "restitution", "restitution": "0.7"}
    | {"start_xi1": "-0.5", "start_v1": "0.25", "base": "0.8", "force1": "0.3"}
)
SETTINGS = pytest.mark.parametrize("setting", [PLAIN, OTHER, STEPPED], ids=["plain", "other", "stepped"])


@SETTINGS
def test_the_script_finds_the_numbers_of_the_page(setting, capsys):
    space = {}
    exec(as_python(setting), space)
    printed, explanation = capsys.readouterr().out.splitlines(), explained(setting)
    assert explanation.headline in printed
    assert set(explanation.details) <= set(printed)
    named = {name: value for name, value in explanation.parts.items() if name != "total"}
    assert {f"{name} {value}" for name, value in named.items()} <= set(printed)
    assert any(line.startswith(f"total {explanation.parts['total']} of the ") for line in printed)
    np.testing.assert_array_equal(space["reference"].section, runs_of(setting).reference.response.section)
    np.testing.assert_array_equal(space["penalty"].section, runs_of(setting).penalty.response.section)


@SETTINGS
def test_the_commands_find_the_numbers_of_the_page(setting, tmp_path, capsys):
    commands = as_command(setting)
    for name in ("simulate", "compare"):
        commands = commands.replace(f"vibroscope {name}", f"vibroscope {name} --json")
    found = [json.loads(line) for line in run_shell(capsys, commands, tmp_path).splitlines()]
    np.testing.assert_array_equal(found[0]["section"], runs_of(setting).reference.response.section)
    np.testing.assert_array_equal(found[1]["section"], runs_of(setting).penalty.response.section)
    explanation = explained(setting)
    assert found[2]["verdict"] == explanation.headline
    assert found[2]["details"] == list(explanation.details)
    assert {name: found[2][name] for name in explanation.parts} == explanation.parts


@pytest.mark.parametrize("key", ["explore", "plane", "basin", "step", "code", "speed"])
def test_the_commands_of_a_tab_have_law_integrator_status_and_start(key):
    tab = VIEWS[key](QueueingHost())
    tab.build()
    lines = tab.command(STEPPED).splitlines()
    tab.close()
    scheme = "--integrator hht --alpha -0.2 --status end --without-solution keep --law flores"
    assert all(scheme in line for line in lines if "--steps" in line)
    exact = [line for line in lines if "--solver exact" in line]
    assert all("--law flores" in line for line in exact)
    assert exact or any("--steps" in line for line in lines)
    from_start = [line for line in lines if line.split()[:2] in (["vibroscope", "simulate"], ["vibroscope", "compare"])]
    from_start += [line for line in lines if "sweep step" in line]
    assert all("--initial=-0.5,0.25,0,0" in line for line in from_start)


@given(settings)
def test_the_parameters_read_back_exactly(setting):
    assert read_setting(loaded_from_toml(as_toml(setting)).texts) == setting


def test_a_file_of_another_kind_is_refused():
    with pytest.raises(ValueError, match=r"no table \[setting\]"):
        loaded_from_toml("[motion]\nkappa = 2")


NOT_OF_COLUMNS = ("mechanism", "diagram", "alone_K", "alone_D", "alone_steps", "front", "comparison")


@pytest.mark.parametrize("figure", [name for name in FIGURES if name not in NOT_OF_COLUMNS])
def test_a_table_holds_every_point_of_its_figure(figure):
    table = figure_table(figure, present(runs_of(PLAIN)))
    rows = list(csv.DictReader(io.StringIO(as_csv(table))))
    assert len(rows) == sum(len(next(iter(series.columns.values()))) for series in table)
    for label, columns in table:
        for name, column in columns.items():
            written = [np.float32(row[name]) for row in rows if row["series"] == label]
            np.testing.assert_array_equal(written, column)


def test_a_cell_that_holds_no_number_is_empty_and_texts_are_quoted():
    table = [
        Series("a", {"x": np.array([0.1, np.nan, -np.inf])}),
        Series("b", {"y": np.array(["p,q"])}),
    ]
    assert as_csv(table).splitlines() == ["series,x,y", "a,0.1,", "a,,", "a,,", 'b,,"p,q"']


def test_the_data_file_holds_null_where_there_is_no_number():
    data = {"a": np.array([0.1, np.nan], np.float32), "b": [np.float64("inf"), {"c": np.array([[1, 2]])}], "d": True}
    assert json.loads(json_text(data)) == {"a": [0.1, None], "b": [None, {"c": [[1, 2]]}], "d": True}


def test_the_report_is_whole_and_asks_no_server():
    text = paragraphs(describe(runs_of(PLAIN)), None) | {"<b>": "a < b"}
    source = {"program": "vibroscope 1", "address": "?eta=1&K=<i>", "made": "today"}
    report = as_report(
        "Explore", Findings(text), PLAIN, [("<?xml?>\n<svg/>", "A < b.")] * 2, [as_command(PLAIN)], source
    )
    assert text["Reference"] in report
    assert "<b>" not in report
    assert "<i>" not in report
    assert "&lt;b&gt;" in report
    assert report.count("<figure><svg/><figcaption>A &lt; b.</figcaption>") == 2
    assert "src=" not in report
    assert "href=" not in report


def test_a_system_file_is_taken_with_its_units():
    loaded = loaded_from_toml("[system]\nkappa = 2.5\n[units]\nomega1 = 30\n")
    values = read_values(loaded.texts)
    assert len(loaded.assumed) == 2
    assert "gives no d3; 0.033 is taken" in loaded.assumed[1]
    assert loaded_from_toml("[setting]\nkappa = 2.5\n").assumed == ()
    assert (values["kappa"], values["omega1"], values["amplitude"]) == (2.5, 30.0, 1.07)
    assert "K" not in values


@pytest.mark.parametrize(
    "text",
    [
        "",
        "eta = 1",
        "setting = 3",
        "[setting]\neta = ",
        "[setting]\nomega = 2",
        "[setting]\nomega1 = 2",  # stands in [units]
        "[setting]\neta = 1\n[units]\nomega1 = -1",
        "[setting]\neta = [1, 2]",
        "[setting]\neta = true",
        "[setting]\neta = nan",
        "[system]\nkappa = 'x'",
        "[setting]\neta = 1\n[system]\nkappa = 'x'",  # no part of a file is ignored
        "[setting]\neta = 1\n[sistem]\nkappa = 2",
        "x=" + 20_000 * "[",
        "x = " + 5_000 * "9",
        "[setting]\n\ud800",
    ],
)
def test_a_file_with_a_fault_is_refused_whole(text):
    with pytest.raises(ValueError):  # noqa: PT011 - each with words of its own
        read_setting(loaded_from_toml(text).texts)


def test_a_file_may_hold_the_system_and_the_setting():
    text = "[system]\nkappa = 2.2\nmass_ratio = 0.6\n[units]\nm1 = 2.0\n[setting]\nK = 9000\n"
    found = read_setting(loaded_from_toml(text).texts)
    assert (found.kappa, found.m1, found.K) == (2.2, 2.0, 9000.0)
    assert found.system.mass_ratio == pytest.approx(0.6)
