"""``vibroscope recommend``, as scripts see it."""

import json
import math
import re

import pytest
from vibroscope.app.commands import recommend as command
from vibroscope.app.commands.cli import main
from vibroscope.engine import Impact, Newmark, Record, System, impact, simulate
from vibroscope.engine.divergence.error import Target

from tests.answers import recommended
from tests.app.command_line import run_command

QUICK = ["--tolerance", "0.5", "--steps-max", "256", "--K", "100", "--D", "1.7"]


@pytest.fixture(scope="module", autouse=True)
def searched_once():
    """Text and JSON are printed of one result."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(command, "recommend", lambda question, **_: recommended(question))
        yield


def run(capsys, *arguments):
    return run_command(capsys, "recommend", *arguments)


def test_json_is_the_contract(capsys):
    status, out, err = run(capsys, "--eta", "2.76", "--located", "--tolerance", "0.5", "--steps-max", "16", "--json")
    found = json.loads(out)
    assert (status, err) == (0, "")
    assert {"K", "D", "steps", "error", "met", "front", "reason"} <= set(found)
    assert (found["met"], found["reason"], found["located"]) == (True, "", True)
    method = Newmark(found["K"], found["D"], found["steps"], located=True)
    response = simulate(System(), 2.76, method, record=Record(50, 200, found["steps"]))
    assert found["error"] == pytest.approx(Target.find(System(), 2.76).error(response), rel=1e-12)
    assert [found["steps"], found["error"], found["K"], found["D"]] in found["front"]
    assert len(found["front_solves"]) == len(found["front"])


def test_a_tolerance_that_is_not_met_is_a_result(capsys):
    status, out, _ = run(capsys, "--eta", "2.76", "--tolerance", "0.01", "--steps-max", "64", "--json")
    found = json.loads(out)
    assert status == 0
    assert not found["met"]
    assert "time step" in found["reason"]
    assert found["error"] > 0.01
    status, out, _ = run(capsys, "--eta", "1.7", "--json")
    found = json.loads(out)
    assert (status, found["met"], found["K"], found["error"], found["front"]) == (0, False, None, None, [])


def test_the_error_that_is_least_is_named_as_in_the_table_where_nothing_meets_the_tolerance(capsys):
    out = run(capsys, "--eta", "2.76", "--tolerance", "0.02", "--steps-max", "256", "--K", "300", "--D", "4")[1]
    for part in out.split("eta = 2.76, ")[1:]:
        kept = re.search(r"the least robust error, which half .* is (\S+ %), with (\d+) steps per period", part)
        rows = re.findall(r"^ +(\d+) +\d+ +\S+ % +(\S+ %)", part, re.MULTILINE)
        assert kept.groups() == rows[-1][::-1]
        shown = re.search(r"^best found .* (\d+) steps per period(.*)$", part, re.MULTILINE)
        cheaper = ": cheaper than that of the least robust error, and in the search hardly worse"
        assert shown[2] == ("" if shown[1] == rows[-1][0] else cheaper)


def test_people_get_both_kinds_of_step_and_units(capsys):
    status, out, _ = run(capsys, "--eta", "3.25", *QUICK, "--units")
    assert status == 0
    assert "constant step, tolerance 50 %" in out
    assert "steps cut at contact changes, tolerance 50 %" in out
    assert out.count(" N/m, damper ") == 2
    assert out.count("\nset ") == 2


def test_a_range_is_a_design_curve(capsys):
    quickest = ["--tolerance", "0.5", "--steps-max", "16"]
    status, out, _ = run(capsys, "--eta-range", "3.2:3.25:2", *quickest)
    assert status == 0
    assert [line.split()[0] for line in out.splitlines()] == ["eta", "3.2000", "3.2500"]
    status, out, _ = run(capsys, "--eta-range", "3.2:3.25:2", *quickest, "--json")
    assert [one["eta"] for one in json.loads(out)] == [3.2, 3.25]


def test_another_system_gives_another_answer(capsys, tmp_path):
    path = tmp_path / "system.toml"
    path.write_text("[system]\nrestitution = 0.8\n")
    answers = [
        json.loads(run(capsys, "--eta", "3.25", *QUICK, *more, "--json")[1]) for more in ([], ["--system", str(path)])
    ]
    assert answers[0]["error"] != answers[1]["error"]


def test_one_setting_for_a_range_in_units(capsys):
    range_ = ["--eta-range", "2.7:2.76:2", "--one-setting", "--K", "5000", "--located", "--tolerance", "0.2", "--units"]
    assert main(["recommend", *range_, "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert (found["met"], found["K"]) == (True, 5000)
    assert [one["eta"] for one in found["etas"]] == pytest.approx([2.7, 2.73, 2.76])
    assert found["physical"]["stiffness"] == 5000
    assert found["physical"]["front"][0][2] == 5000
    assert main(["recommend", *range_]) == 0
    text = capsys.readouterr().out
    assert "limit             the range is limited at f = 0.4" in text
    assert re.search(r"^range +2D = \S+ to \S+ N·s/m where K = 5000 N/m$", text, re.MULTILINE)
    assert "K / N/m" in text


@pytest.mark.parametrize(
    ("arguments", "within"),
    [
        (["--eta", "2.76", "--tolerance", "0.2", "--steps-max", "4000", "--K", "12000"], True),
        (["--eta", "3.25", "--tolerance", "0.5", "--steps-max", "128", "--K", "40"], False),  # so soft that springs act
    ],
)
def test_with_the_step_that_is_recommended_a_contact_alone_is_within_the_tolerance_or_it_is_said(
    arguments, within, capsys
):
    out = run(capsys, *arguments, "--status", "start")[1]
    found = json.loads(run(capsys, *arguments, "--status", "start", "--json")[1])
    method, step = Newmark(found["K"], found["D"], found["steps"]), 2 * math.pi / (found["eta"] * found["steps"])
    one = Impact(method, 1.0, System().mass_share, step)
    e = impact(one).restitution
    assert (max(abs(e.least - 0.5), abs(e.greatest - 0.5)) <= 0.1) == within
    assert ("not within 0.1 at each touch" in out) == (not within)
    assert f"{e.least:.2f} to {e.greatest:.2f} with {one.steps_per_contact:.3g} steps in it" in out
    assert [found[f"contact_alone_restitution_{end}"] for end in e._fields] == pytest.approx(list(e), rel=1e-9)
    assert found["contact_alone_steps"] == pytest.approx(one.steps_per_contact, rel=1e-12)


def test_a_recommendation_says_its_ranges_its_contacts_and_what_it_was_verified_for(capsys):
    arguments = ["--eta", "3.25", "--tolerance", "0.5", "--steps-max", "512", "--K", "200", "--status", "start"]
    found = json.loads(run(capsys, *arguments, "--json")[1])
    assert (found["met"], found["K"], found["K_range"]) == (True, 200, None)
    assert (found["restitution_tolerance"], found["force_tolerance"]) == (0.1, 0.2)
    assert found["D_range"][0] < found["D"] < found["D_range"][1]
    assert abs(found["restitution"] - 0.5) <= 0.1
    assert abs(found["peak_force"] / found["peak_force_without_step"] - 1) <= 0.2
    out = run(capsys, *arguments)[1]
    assert "peak force        " in out
    assert "of the contact model, not of the system: it grows with K" in out
    assert "verified for      Newmark; contact status from the start of the step; contact law Kelvin–Voigt" in out
    loose = json.loads(
        run(capsys, *arguments, "--restitution-tolerance", "off", "--force-tolerance", "OFF", "--json")[1]
    )
    assert (loose["restitution_tolerance"], loose["force_tolerance"]) == (None, None)
    assert loose["steps"] < found["steps"]
