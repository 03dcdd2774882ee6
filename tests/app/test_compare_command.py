"""``vibroscope compare``, as scripts and people see it."""

import json
import re
from dataclasses import replace

import numpy as np
import pytest
from vibroscope.engine import (
    HHT,
    ComparisonQuestion,
    Newmark,
    Reference,
    System,
    TimeStepping,
    compare,
    motion,
    percent,
    verdict,
    written,
)
from vibroscope.engine.divergence.alone import Change
from vibroscope.engine.divergence.conditions import conditions
from vibroscope.engine.divergence.sentences import detail_sentences
from vibroscope.engine.facts import print_statement

from tests.app.command_line import run_command

NUMBERS = ("total", "time_step", "regularisation", "joint_damping")


def run(capsys, text, *more):
    return run_command(capsys, "compare", *text.split(), *more)


def test_json_is_the_contract(capsys):
    status, out, _ = run(capsys, "--eta 2.76 --K 12000 --D 18 --steps 2000 --json")
    found = json.loads(out)
    expected = compare(ComparisonQuestion(System(), 2.76, Newmark(12000, 18, 2000)))
    assert status == 0
    assert [found[name] for name in NUMBERS] == [getattr(expected, name) for name in NUMBERS]
    assert 0 <= found["residual"] < 1e-10
    assert found["verdict"] == verdict(expected).headline
    assert (found["blame"], found["change"]) == (["status"], {"located": True})
    described = motion(System(), 2.76, Reference()).as_dict()
    assert found["reference"].keys() == described.keys()
    for name in ("type", "period", "impacts_per_period", "contacts_per_period", "contact_share"):
        assert found["reference"][name] == described[name]
    np.testing.assert_allclose(found["reference"]["section"], described["section"], rtol=1e-12)
    assert found["reference"]["peak_force"] is None  # impacts
    assert found["penalty"].keys() == described.keys()
    assert (found["penalty"]["type"], found["penalty"]["period"]) == ("periodic", 1)
    assert found["penalty"]["step_noise"] > 0
    assert found["pointwise"]
    assert found["split"]["in_step"]
    assert found["impacts"]["matched"] == 1
    assert "alone" not in found  # it was not asked for


def test_options_reach_the_engine(capsys, tmp_path):
    path = tmp_path / "own.toml"
    path.write_text("[system]\nrestitution = 0.4\n")
    setting = "--eta 1.08 --K 2500 --D 8 --steps 500 --located --periods 300 --keep 4 --joint-damping derived --json"
    _, out, err = run(capsys, setting, "--system", str(path), "--series")
    assert err == ""
    found = json.loads(out)
    penalty = Newmark(2500, 8, 500, located=True)
    options = {"reference": Reference("derived"), "periods": 300, "keep": 4}
    expected = compare(ComparisonQuestion(System(restitution=0.4), 1.08, penalty, **options))
    assert found["total"] == expected.total
    assert found["joint_damping"] == 0
    series = {name: np.array(rows) for name, rows in found["series"].items()}
    assert series["total"].shape == (4, len(series["time"]))
    assert np.abs(sum(series[name] for name in NUMBERS[1:]) - series["total"]).max() < 1e-10


def test_what_a_code_chooses_reaches_the_engine(capsys):
    setting = "--eta 1.08 --K 2500 --D 8 --steps 500 --integrator hht --alpha -0.2 --status end --without-solution keep"
    found = json.loads(run(capsys, f"{setting} --periods 100 --keep 10 --json")[1])
    method = TimeStepping(2500, 8, 500, HHT(-0.2), "end", "keep")
    expected = compare(ComparisonQuestion(System(), 1.08, method, periods=100, keep=10))
    assert (found["integrator"], found["status"], found["law"]) == ("hht", "end", "kelvin-voigt")
    assert found["total"] == expected.total
    assert found["steps_without_solution"] == expected.runs.penalty.steps_without_solution > 0
    assert found["steps_with_two"] == expected.runs.penalty.steps_with_two
    parts = expected.split_time_step()
    assert found["split_time_step"]["status"] == expected.parts.relative(parts.status)
    assert found["split_time_step"]["integrator"] == expected.parts.relative(parts.integrator)


def test_a_run_without_a_solution_is_a_result(capsys):
    setting = "--eta 2.76 --K 12000 --D 18 --steps 500 --status end --periods 100 --keep 10"
    found = json.loads(run(capsys, f"{setting} --json")[1])
    assert (found["total"], found["split_time_step"], found["steps_without_solution"]) == (None, None, 1)
    assert found["change"] == {"without_solution": "halve"}
    assert "stopped at a step without a solution" in run(capsys, setting)[1]


def test_irregular_motion_says_that_statistics_are_compared(capsys):
    found = json.loads(run(capsys, "--eta 1.7 --K 12000 --D 18 --steps 500 --json")[1])
    assert not found["pointwise"]
    assert "statistics" in found["verdict"]
    assert found["statistics"]["total"] > found["statistics"]["floor"] > 0
    assert found["reference"]["lyapunov"] == pytest.approx(0.27, abs=0.03)
    assert (found["reference"]["type"], found["penalty"]["type"]) == ("chaotic", "chaotic")


def test_a_run_that_blew_up_is_a_result(capsys):
    status, out, _ = run(capsys, "--eta 2.76 --K 60000 --D 1 --steps 100 --json", "--series")
    found = json.loads(out)
    assert status == 0
    assert [found[name] for name in (*NUMBERS, "split", "series")] == [None] * 6
    assert found["penalty"]["type"] == "diverged"
    assert "blew up" in found["verdict"]


OPENING = "--eta 1.08 --K 100 --D 50 --steps 2000"


@pytest.fixture(scope="module")
def expected():
    """What the engine finds over each number alone."""
    return verdict(compare(ComparisonQuestion(System(), 1.08, Newmark(100, 50, 2000)))).alone


def test_the_difference_over_each_number_alone_is_printed(expected, capsys):
    _, out, _ = run(capsys, OPENING, "--alone", "--units")
    tables = dict(zip(expected.curves, re.split(r"\n\n", out)[-6:-3], strict=True))
    for name, curve in expected.curves.items():
        lines = tables[name].splitlines()
        present, best = (next(line for line in lines if line.endswith(words)) for words in ("present", "at best"))
        assert percent(expected.total) in present
        assert percent(curve.best.left) in best
        assert float(present.split()[0]) == curve.present
    assert float(next(line for line in tables["D"].splitlines() if "present" in line).split()[1]) == 100  # 2D, N·s/m
    assert "2D / (N.s/m)" in tables["D"]
    assert written(expected.curves["K"].equal) in next(li for li in tables["K"].splitlines() if "equal" in li)
    assert written(expected.curves["K"].resolved) in next(li for li in tables["K"].splitlines() if "10 steps" in li)
    assert "ended early" in tables["K"]
    assert tables["steps"].splitlines()[-1].split()[0] == "none"
    assert f"The joint damping makes {percent(expected.floor)}" in out
    assert "At best: the middle of the values that leave at most 1.25 times the least" in out
    share = re.search(r"by the median of those within (\d+) % of each;", " ".join(out.split()))[1]
    tried = expected.curves["K"].values  # coarse and fine ones; of the fine ones two on each side count
    assert float(share) == pytest.approx(100 * (min(tried[2:] / tried[:-2]) - 1), abs=1)


def test_nothing_that_leaves_more_than_there_is_stands_as_the_best(expected):
    comparison = compare(ComparisonQuestion(System(), 1.08, Newmark(100, 50, 2000)))
    method = comparison.runs.penalty.method
    contact, worse = conditions(System(), 1.08, method, comparison.closing_speed), Change("status", 2.0, 2.0, method)
    for curves, said in ((expected.curves, True), ({}, False)):
        found = replace(expected, curves=curves, choices=(worse,))
        lines = map(print_statement, detail_sentences(comparison, found, contact, None))
        assert any("What is left at best" in line for line in lines) == said


def test_the_json_has_the_curves_where_they_are_asked_for(expected, capsys):
    found = json.loads(run(capsys, OPENING, "--alone", "--json")[1])["alone"]
    assert found == json.loads(json.dumps(expected.as_dict()))
    assert [*found["curves"]] == ["K", "D", "steps"]


def test_nothing_to_search_for_is_said(capsys):
    out = run(capsys, "--eta 2.76 --K 1e6 --D 18 --steps 10 --alone")[1]
    assert "There is nothing to search for over K, D and the step." in out
    assert json.loads(run(capsys, "--eta 2.76 --K 1e6 --D 18 --steps 10 --alone --json")[1])["alone"] is None


def test_text_holds_the_verdict_and_the_parts(capsys):
    _, out, _ = run(capsys, "--eta 1.08 --K 2500 --D 8 --steps 2000")
    assert "The joint damping is to blame" in " ".join(out.split())
    lines = [line.split("  ")[0] or line.strip().split("  ")[0] for line in out.splitlines()]
    once = " ".join(out.split())
    assert "In the motion the bodies part with" in once
    assert "the restitution e asks for" in once
    assert "Alone means two bodies that meet once" in once
    for name in (
        "difference (rms)",
        "time step",
        "status",
        "integrator",
        "contact time",
        "pulling",
        "joint damping",
        "reference",
        "penalty",
    ):
        assert name in lines
    assert "nan" not in out


def test_the_number_of_a_motion_that_does_not_repeat_is_of_its_periods(capsys):
    """Without any change but in a last digit the same motion is 7 to 15 % off."""
    texts = [run(capsys, f"--eta {eta} --K 12000 --D 18 --steps 2000")[1] for eta in (2.5, 2.76)]
    numbers = [re.search(r"\(rms\) +(.*)", text)[1] for text in texts]
    assert numbers[0] == "2.4 %"
    low, high = re.fullmatch(r"about 12 % \((.*) % to (.*) % in 5 parts of the kept periods, .*\)", numbers[1]).groups()
    assert 4 < float(low) < 12 < float(high) < 25


def test_columns_hold_the_longest_name_of_a_law(capsys):
    short = "--steps 100 --periods 60 --keep 8"  # the search within a verdict takes long with this law
    _, out, _ = run(capsys, f"--eta 1.08 --K 100 --law constant-restitution --status located {short}")
    begins = [re.search(r"\S  +(\S.*)", line) for line in out.splitlines()]
    rows = [found for found in begins if found and found.group(1)[0].isdigit()]
    assert any("(law constant-restitution)" in found.string for found in rows)
    assert len({found.start(1) for found in rows}) == 1


def test_steps_leave_and_a_number_leaves(capsys):
    text = " ".join(run(capsys, "--eta 2.76 --K 2500 --D 8 --steps 12 --located")[1].split())
    assert re.search(r"[0-9] steps a period leave \d", text)


def test_the_verdict_is_in_units_where_units_are_asked_for(capsys, tmp_path):
    """K in N/m and 2D in N·s/m, as they are typed; the time in seconds."""
    file = tmp_path / "my.toml"
    file.write_text(
        "[physical]\nmass1_kg = 25\nstiffness1_N_per_m = 98696\nwall = true\nrestitution = 0.8\n"
        "base_acceleration_m_per_s2 = 1\nclearance_mm = 0.5\nfrequency_Hz = 10\n"
    )
    numbers = ["--K", "5.7e7 N/m", "--D", "6283 N.s/m", "--steps", "400", "--units"]
    status, out, _ = run(capsys, "--system", str(file), *numbers)
    assert status == 0
    text = " ".join(out.partition("difference (rms)")[2].split())
    assert re.search(r"lasts [\d.]+ ms: [\d.]+ steps", text)
    assert not re.search(r"(?<!2)D = [\d.]+(?! N·s/m)\b|K = [\d.]+ [^N]", text)
