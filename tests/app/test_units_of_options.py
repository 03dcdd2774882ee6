"""Options with a unit: what they are in the model of a system file that has units, and what is said elsewhere."""

import argparse
import json
import math
from functools import partial

import pytest
from vibroscope.app.commands.cli import build_parser
from vibroscope.app.commands.numbers import STEPS, list_of, measured, resolve_units, span, state_numbers, step_numbers
from vibroscope.engine import parse_system, spaced

from tests.app.command_line import PHYSICAL, run_command

SYSTEM = parse_system(PHYSICAL.encode())
RUN = ("simulate", "--solver", "newmark", "--K", "584", "--D", "2", "--steps", "400", "--periods", "20", "--json")


@pytest.fixture
def own(tmp_path):
    path = tmp_path / "my.toml"
    path.write_text(PHYSICAL)
    return str(path)


def resolved(*words, system=SYSTEM):
    options = build_parser([words[0]]).parse_args(words)
    options.file = system
    resolve_units(options)
    return options


@pytest.mark.parametrize(
    ("option", "text", "model"),
    [
        ("K", "5.76e7 N/m", 5.76e7 / 98696),
        ("K", "57 600 N/mm", 5.76e7 / 98696),
        ("K", "57,5 MN/m", 5.75e7 / 98696),
        ("K", "12.000 kN/m", 1.2e4 / 98696),  # as a program writes 12
        ("D", "6280 N s/m", 6280 / (2 * math.sqrt(25 * 98696))),
        ("D", "6.28 N·s/mm", 6280 / (2 * math.sqrt(25 * 98696))),
        ("eta", "12 Hz", 24 * math.pi / math.sqrt(98696 / 25)),
        ("threshold", "1 mm/s", 1e-3 / (SYSTEM.units.factor("velocity"))),
        ("penetration", "10 µm", 1e-5 / SYSTEM.units.factor("displacement")),
        ("steps", "250 us", 400),  # of a period of 100 ms
        ("steps", "0.3 ms", 334),
    ],
)
def test_a_number_with_a_unit_is_that_of_the_model(option, text, model):
    options = resolved("simulate", "--solver", "newmark", f"--{option}", text)
    assert getattr(options, option) == pytest.approx(model, rel=1e-12)


def test_ranges_may_have_units_too():
    sweep = "sweep", "plane", "--K", "1e6 N/m:1e8N/m:5", "--D", "1:40:5", "--steps", "100 us", "--out", "a"
    options = resolved(*sweep)
    assert pytest.approx((1e6 / 98696, 1e8 / 98696, 5)) == options.K
    assert (options.D, options.steps) == ((1, 40, 5), 1000)
    over = "sweep", "eta", "--from", "8 Hz", "--to", "12 Hz", "--count", "5", "--solver", "reference", "--out", "a"
    low, high = (resolved(*over).low, resolved(*over).high)
    assert high / low == pytest.approx(1.5)
    assert low * SYSTEM.units.omega1 / (2 * math.pi) == pytest.approx(8)


def test_the_range_of_a_recommendation_may_have_units():
    low, high, n = resolved("recommend", "--eta-range", "8 Hz:12 Hz:5").eta_range
    assert (low, high) == pytest.approx(tuple(2 * math.pi * f / SYSTEM.units.omega1 for f in (8, 12)), rel=1e-12)
    assert spaced("eta", low, high, n).tolist() == pytest.approx([low * (1 + 0.125 * i) for i in range(5)], rel=1e-12)


def test_lists_may_have_units():
    steps = "sweep", "step", "--K", "584", "--D", "2", "--steps", "250 us, 125 us,1600", "--out", "a"
    assert resolved(*steps).steps == (400, 800, 1600)
    length, speed = (SYSTEM.units.factor(quantity) for quantity in ("displacement", "velocity"))
    model = pytest.approx((-1e-4 / length, 2e-3 / speed, 5e-4 / length, 0.0), rel=1e-12)
    state = "-0.1 mm,2 mm/s,0.5 mm,0"
    assert resolved("simulate", "--solver", "reference", f"--initial={state}").initial == model
    axes = "--x", "xi1:0:1 mm:9", "--y", "v1:-2 mm/s:2 mm/s:9"
    basin = resolved("sweep", "basin", *axes, f"--start={state}", "--solver", "reference", "--out", "a")
    assert basin.start == model
    assert basin.x == ("xi1", pytest.approx((0, 1e-3 / length, 9), rel=1e-12))
    assert basin.y == ("v1", pytest.approx((-2e-3 / speed, 2e-3 / speed, 9), rel=1e-12))


def test_a_run_with_units_is_the_run_without(own, capsys):
    with_units = [{"584": "57638464 N/m", "400": "0.00025 s"}.get(word, word) for word in RUN]
    outputs = [run_command(capsys, *words, "--system", own) for words in (RUN, with_units)]
    (first, second) = (json.loads(out) for _, out, _ in outputs)
    assert first["section"] == second["section"]


@pytest.mark.parametrize("read", [measured("contact_stiffness"), measured(STEPS)])
def test_what_has_two_meanings_or_none_is_no_number(read):
    with pytest.raises(argparse.ArgumentTypeError, match="is no number"):
        read("apples")
    with pytest.raises(argparse.ArgumentTypeError, match="can mean 12000 N/m or 12 N/m"):
        measured("contact_stiffness")("12,000 N/m")


def test_units_of_a_table_units_have_a_meaning_too():
    system = parse_system(b"[system]\nclearance = 0.1\n[units]\nomega1 = 10.0\nm1 = 2.0\n")
    assert pytest.approx(2.0) == resolved("simulate", "--solver", "newmark", "--K", "400 N/m", system=system).K


def test_a_range_of_any_number_with_a_dimension_may_have_units():
    over = "sweep", "eta", "--over", "clearance", "--from", "0.1 mm", "--to", "1 mm", "--count", "5"
    low = resolved(*over, "--solver", "reference", "--out", "a").low
    assert low == pytest.approx(1e-4 / SYSTEM.units.factor("displacement"), rel=1e-12)


@pytest.mark.parametrize(
    ("read", "text", "first"),
    [
        (partial(list_of, example="A,T", quantities=("acceleration", "time")), "30,11 ms", "30"),
        (partial(list_of, example="A,T", quantities=("acceleration", "time")), "30 g, 11", "11"),
        (partial(span, quantity="frequency"), "5:500 Hz:3", "5"),
        (state_numbers, "-300 mm,1,0,0", "1"),
    ],
)
def test_a_number_without_a_unit_beside_one_with_a_unit_is_refused(read, text, first):
    """It would be counted in units of the model, which nobody means who writes the other one in ms."""
    with pytest.raises(argparse.ArgumentTypeError, match=f": {first} has no unit beside numbers that have one: give a"):
        read(text)


def test_zero_and_steps_need_no_unit_beside_others():
    assert state_numbers("-300 mm,0,0,0")[1:] == (0.0, 0.0, 0.0)
    assert step_numbers("2000,0.1 ms")[0] == 2000
