"""The keys of a system file: the tables of the reference have all that the reader knows, with their true defaults."""

import re
from pathlib import Path

import pytest
from vibroscope.engine import SystemFile, parse_system
from vibroscope.engine.physical import EITHER, KEYS, NEEDED, WALL
from vibroscope.engine.system_file import described_keys

from docs.system_keys import rows

TABLES = "system", "excitation", "units", "physical"
PAGE = (Path(__file__).parents[2] / "docs/reference/files.md").read_text()
LEAST = {"mass1_kg": 2.0, "stiffness1_N_per_m": 800.0, "mass2_kg": 1.0, "stiffness2_N_per_m": 900.0}
DRIVEN = LEAST | {"base_amplitude_mm": 1.0, "frequency_Hz": 3.0}


def parsed(table, entry):
    lines = (f"{name} = {str(value).lower()}" for name, value in entry.items())
    return parse_system("\n".join([f"[{table}]", *lines]).encode())


def all_known(table):
    """The keys that the reader knows, in its own words."""
    with pytest.raises(ValueError, match="known: ") as refusal:
        parsed(table, {"qqqqq": 1.0})
    return re.search("known: (.*)", str(refusal.value))[1].split(", ")


@pytest.mark.parametrize("table", TABLES)
def test_the_reference_has_every_key_that_the_reader_knows(table):
    assert [row[0] for row in rows(table)] == all_known(table)
    assert f"```{{eval-rst}}\n.. system-keys:: {table}\n```" in PAGE
    assert all(all(row) for row in rows(table))


@pytest.mark.parametrize("table", TABLES[:3])
def test_a_default_is_what_is_taken_where_a_key_is_left_out(table):
    keys = described_keys(table)
    for name, key in keys.items():
        if not isinstance(key.default, str):
            assert parsed(table, {name: key.default}) == SystemFile(), name


@pytest.mark.parametrize("name", KEYS)
def test_a_default_of_a_physical_key_is_what_is_taken_where_it_is_left_out(name):
    default, others = KEYS[name].default, {one for pair in EITHER if name in pair for one in pair}
    without = {each: value for each, value in DRIVEN.items() if each not in others | {name}}
    if isinstance(default, str) and default.startswith(NEEDED):
        with pytest.raises(ValueError, match=name):
            parsed("physical", without)
    elif not isinstance(default, str):
        driven = without | {"length_mm": 1.0} if name == "base_amplitude_mm" else without
        outside = not KEYS[name].allowed.holds(default)  # of an amplitude, which is 0 only where it is left out
        given = parsed("physical", driven if outside else driven | {name: default})
        assert (given.system, given.units) == (parsed("physical", driven).system, parsed("physical", driven).units)
        other = parsed("physical", without | {name: {"base_amplitude_mm": 2.0, "clearance_mm": -0.5}.get(name, 0.25)})
        assert (given.system, given.units) != (other.system, other.units)


def test_the_ends_of_a_range_are_what_the_reader_refuses():
    for name, key in KEYS.items():
        beyond = key.allowed.high if key.allowed.open_high else key.allowed.high * 2 + 1
        with pytest.raises(ValueError, match=re.escape(f"{name} must be {key.allowed.words(key.unit)}")):
            parsed("physical", {each: v for each, v in DRIVEN.items() if each not in others_of(name)} | {name: beyond})


def others_of(name):
    """What the entry may not give beside a key."""
    beside = {one for pair in EITHER if name in pair for one in pair}
    return beside | {"base_amplitude_mm"} if name == "length_mm" else beside


def test_a_wall_needs_no_second_body():
    entry = {name: value for name, value in DRIVEN.items() if "2" not in name} | {WALL: True}
    assert parsed("physical", entry).system.wall
    assert "wall = true" in KEYS["mass2_kg"].default


@pytest.mark.parametrize(
    ("keys", "words"),
    [
        ("mass_kg = 1\nwall = true", "did you mean mass1_kg?"),
        ("mass_kg = 1\nwall = false", "did you mean mass1_kg or mass2_kg?"),
        ("constant_N = 1\nwall = true", "did you mean constant1_N?"),
    ],
)
def test_an_unknown_key_is_answered_with_the_nearest_that_this_system_may_have(keys, words):
    with pytest.raises(ValueError, match=re.escape(words)):
        parse_system(f"[physical]\n{keys}\n".encode())
