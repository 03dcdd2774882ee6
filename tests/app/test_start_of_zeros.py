"""Rest is said, not meant by zeros: where rest lies elsewhere, zeros that are typed are a start of their own."""

import pytest
from vibroscope.app.explorer.link import parse_address, print_address
from vibroscope.app.explorer.reading import read_setting
from vibroscope.app.explorer.state import Setting
from vibroscope.app.explorer.typed import plain_texts
from vibroscope.app.export.scripts import as_command, as_python
from vibroscope.app.page.controls.controls import Controls

LOADED = Setting(bodies="two", mass_ratio=0.6, clearance=0.5, constant1=-0.2, constant2=0.3)


def typed(setting, **texts):
    """The setting after numbers were typed."""
    return read_setting(plain_texts({name: {"typed": text} for name, text in texts.items()}, setting), setting)


def test_fields_show_rest_and_zeros_in_their_place_are_an_own_start():
    controls = Controls()
    controls.show_setting(LOADED)
    rest = LOADED.system.rest
    assert float(controls.shown["numbers"]["start_xi1"]) == rest[0] == -0.2
    assert LOADED.initial == rest
    one = typed(LOADED, start_xi1="0")
    assert one.initial == (0.0, 0.0, rest[2], 0.0)  # what is not typed stays where it was
    both = typed(one, start_xi2="0")
    assert (both.initial, both.from_rest) == ((0.0, 0.0, 0.0, 0.0), False)
    assert read_setting({"zero_start": "rest"}, both).initial == rest


def test_links_files_and_commands_carry_a_start_of_zeros():
    zeros = typed(LOADED, start_xi1="0", start_xi2="0")
    assert read_setting(parse_address(print_address(zeros))) == zeros
    assert read_setting(zeros.texts()) == zeros
    assert "--initial=0,0,0,0" in as_command(zeros)
    assert "initial=(0.0, 0.0, 0.0, 0.0)" in as_python(zeros)
    assert "--initial" not in as_command(LOADED)


@pytest.mark.parametrize("name", ["start_xi1", "start_xi2"])
def test_a_zero_that_names_no_start_means_rest(name):
    assert read_setting({name: "0"}, LOADED).initial == LOADED.system.rest
    assert read_setting({"start_v1": "1"}, LOADED).initial == (0.0, 1.0, 0.0, 0.0)


def test_two_ways_to_write_one_start_are_one_setting():
    one, other = read_setting({"start_v1": "1"}, LOADED), read_setting({"start_v1": "1", "zero_start": "zero"}, LOADED)
    assert one == other
