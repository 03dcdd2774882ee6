"""A second stop on the page: chosen, typed, loaded from a file and linked; where it cannot be, refused in words."""

import pytest
from vibroscope.app.explorer.compute import compute_runs
from vibroscope.app.explorer.drawing import drawing_in_words
from vibroscope.app.explorer.errors import Refused
from vibroscope.app.explorer.explanation import describe
from vibroscope.app.explorer.link import parse_address, print_address
from vibroscope.app.explorer.physical_fields import entered
from vibroscope.app.explorer.present import present
from vibroscope.app.explorer.reading import read_setting
from vibroscope.app.explorer.state import Setting
from vibroscope.app.export.formats import as_toml, loaded_from_toml
from vibroscope.app.page.controls.controls import system_fields

from tests.served import ROOT

FILE = """[physical]
mass1_kg = 25.0
frequency1_Hz = 10.0
wall = true
clearance_mm = 0.5
force1_N = 12.0
frequency_Hz = 12.0
"""
TWO = Setting(stops="two", clearance=0.5, clearance2=0.8)


def test_a_file_with_a_second_stop_sets_it_and_one_without_takes_it_away():
    given = FILE + "clearance2_mm = 2.0\nrestitution2 = 0.3\nstiffness_factor2 = 4.0\n"
    setting = read_setting(loaded_from_toml(given).texts)
    assert (setting.stops, setting.restitution2, setting.stiffness_factor2) == ("two", 0.3, 4.0)
    assert setting.clearance2 * setting.amplitude == pytest.approx(2.0)
    assert read_setting(loaded_from_toml(as_toml(setting)).texts, Setting()) == setting
    assert read_setting(parse_address(print_address(setting))) == setting
    assert not read_setting(loaded_from_toml(FILE).texts, setting).system.two_stops


def test_the_impact_pair_of_the_documentation_is_free_between_two_walls():
    setting = read_setting(loaded_from_toml((ROOT / "docs/pair.toml").read_text()).texts)
    assert (setting.bodies, setting.spring1, setting.stops) == ("wall", 0.0, "two")
    words = "A body without a spring and a wall, 0.005 m apart; a second wall on the other side leaves 0.01 m of play."
    assert drawing_in_words(setting) == words
    fields = system_fields(setting)
    assert {"clearance2_mm", "restitution2", "stiffness_factor2", "damping_factor2"} <= fields.keys()
    assert "clearance2" not in fields
    moved = read_setting(setting.texts() | {"start_xi1": "0.8", "start_v1": "3.5"})
    runs = compute_runs(moved)
    assert "symmetric between the stops" in " ".join(describe(runs).reference)
    assert present(runs)["impulse_reference"]["impulse"].min() < 0 < present(runs)["impulse_reference"]["impulse"].max()


def test_its_fields_are_there_while_it_is_chosen_and_it_begins_like_the_first():
    names = {"clearance2", "restitution2", "stiffness_factor2", "damping_factor2"}
    assert not names & system_fields(Setting()).keys()
    assert names <= system_fields(TWO).keys()
    chosen = read_setting(entered({"stops": "two"}, Setting(clearance=0.3, restitution=0.7)), Setting(clearance=0.3))
    assert (chosen.clearance2, chosen.restitution2, chosen.system.play) == (0.3, 0.7, 0.6)
    for clearance in (0.0, -0.3):  # touching at rest, and pressed together
        one = Setting(clearance=clearance)
        assert read_setting(entered({"stops": "two"}, one), one).system.play == 1.0
    assert not read_setting({"stops": "one"}, chosen).system.two_stops


@pytest.mark.parametrize(
    ("texts", "name", "words"),
    [
        (
            {"clearance2": "-1"},
            "clearance",
            "leaves no play between the two stops: give clearances whose sum is above 0",
        ),
        ({"restitution2": "1.5"}, "restitution2", "restitution2 must be a number from 0 to 1"),
        ({"start_xi1": "-0.9"}, "start_xi2", "must be at least minus the clearance of the second stop, -0.8, not -0.9"),
    ],
)
def test_what_it_cannot_be_is_refused_in_words(texts, name, words):
    with pytest.raises(Refused, match=words) as refused:
        read_setting(texts, TWO)
    assert refused.value.name in (name, *texts)
