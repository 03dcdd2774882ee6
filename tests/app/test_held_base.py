"""A system keeps how it was given, in panel, link and file: the base's acceleration over the frequency, Hz, g."""

import json

import pytest
from vibroscope.app.explorer.field_units import held_in_words
from vibroscope.app.explorer.link import parse_address, print_address
from vibroscope.app.explorer.physical_fields import entered
from vibroscope.app.explorer.reading import read_setting
from vibroscope.app.explorer.state import Setting
from vibroscope.app.explorer.typed import plain_texts
from vibroscope.app.export.formats import as_toml, loaded_from_toml
from vibroscope.app.page.controls.controls import Controls
from vibroscope.app.page.shared.figure import eta_axis
from vibroscope.engine.physical import G

from tests.app.command_line import run_command

WALL = Setting()._replace(bodies="wall", coordinate="xi1", units="si")
# the review's bracket: 0.8 kg at 22 Hz against a stop at 0.3 mm, shaken with 4 m/s² at 18 Hz
BRACKET = {"mass1_kg": "0.8", "frequency1_Hz": "22", "damping1_ratio": "0.02", "clearance_mm": "0.3"}
BRACKET |= {"restitution": "0.6", "eta": "18 Hz", "base_acceleration_m_per_s2": "4"}
FILE = """[physical]
mass1_kg = 0.8
frequency1_Hz = 22.0
damping1_ratio = 0.02
wall = true
clearance_mm = 0.3
restitution = 0.6
base_acceleration_m_per_s2 = 4.0
frequency_Hz = 18.0
"""


def enter(setting, **typed):
    """The setting after each number was typed in turn, as the browser sends it."""
    for name, text in typed.items():
        texts = plain_texts({name: {"typed": text}}, setting)
        setting = read_setting(entered(texts, setting), setting)
    return setting


def choose(setting, **texts):
    return read_setting(entered(texts, setting), setting)


def shown(setting):
    """Text and unit of each number of the panel."""
    controls = Controls()
    controls.show_setting(setting)
    return {name: (text, controls.fields[name]["unit"]) for name, text in controls.shown["numbers"].items()}


def test_the_panel_holds_four_metres_per_second_squared_over_the_frequency():
    setting = enter(WALL, **BRACKET)
    for frequency in ("18", "25", "26.4"):
        found = shown(enter(setting, eta=f"{frequency} Hz"))
        assert found["base_acceleration_m_per_s2"] == ("4", "m/s²")
        assert found["frequency1_Hz"] == ("22", "Hz")
        assert found["clearance_mm"] == ("0.3", "mm")
        assert not {"base_amplitude_mm", "stiffness1_N_per_m", "base_acceleration_g"} & found.keys()


def test_a_link_and_a_file_bring_back_what_was_entered():
    setting = enter(WALL, **BRACKET)
    setting = enter(setting, eta="25 Hz")
    by_link = read_setting(parse_address(print_address(setting)))
    by_file = read_setting(loaded_from_toml(as_toml(setting)).texts)
    assert by_link == by_file == setting
    assert shown(by_link)["base_acceleration_m_per_s2"] == ("4", "m/s²")
    of_sheet = read_setting(loaded_from_toml(FILE).texts)
    assert shown(of_sheet)["frequency1_Hz"] == ("22", "Hz")
    assert shown(enter(of_sheet, eta="25 Hz"))["base_acceleration_m_per_s2"] == ("4", "m/s²")


@pytest.mark.parametrize("text", ["0.4 g", f"{0.4 * G} m/s²", f"{400 * G} mm/s²"])
def test_an_acceleration_may_be_typed_in_g(text):
    setting = enter(enter(WALL, **BRACKET), base_acceleration_m_per_s2=text)
    assert shown(setting)["base_acceleration_m_per_s2"] == ("3.92266", "m/s²")
    in_g = choose(setting, held="acceleration", acceleration_form="g")
    assert shown(in_g)["base_acceleration_g"] == ("0.4", "g")
    assert held_in_words(in_g) == "base acceleration 0.4 g"
    assert shown(read_setting(parse_address(print_address(in_g))))["base_acceleration_g"] == ("0.4", "g")


def test_what_is_held_can_be_changed_and_the_motion_stays():
    setting = enter(WALL, **BRACKET)
    moved = setting.system.excitation.base_amplitude(setting.eta)
    for held in ("velocity", "displacement", "acceleration"):
        other = choose(setting, held=held)
        assert other.system.excitation.base_amplitude(other.eta) == pytest.approx(moved, rel=1e-13)
        plain = choose(setting._replace(units="none"), held=held)
        assert plain.system.excitation.base_amplitude(plain.eta) == pytest.approx(moved, rel=1e-13)


def test_other_numbers_leave_what_was_given_of_the_base():
    setting = enter(enter(WALL, **BRACKET), mass1_kg="1.6", clearance_mm="0.5", restitution="0.7")
    assert shown(setting)["base_acceleration_m_per_s2"] == ("4", "m/s²")
    assert shown(setting)["frequency1_Hz"] == ("22", "Hz")
    still = enter(setting, base_acceleration_m_per_s2="0")
    assert shown(still)["base_acceleration_m_per_s2"] == ("0", "m/s²")
    assert shown(enter(still, base_acceleration_m_per_s2="3"))["base_acceleration_m_per_s2"] == ("3", "m/s²")


def test_an_axis_of_frequency_says_what_is_held():
    setting = enter(WALL, **BRACKET)
    assert eta_axis(setting)[0] == "frequency f / Hz, base acceleration 4 m/s² held"
    assert eta_axis(setting._replace(units="mm-t-s"))[0] == "frequency f / Hz, base acceleration 4 m/s² held"
    assert eta_axis(Setting())[0] == "frequency η = Ω/ω₁, base displacement held"
    assert eta_axis(Setting()._replace(base=0.0, force1=1.0))[0] == "excitation frequency η = Ω/ω₁"


def test_the_command_line_holds_it_and_says_so(tmp_path, capsys):
    """At 26.4 Hz the base moves by 4/(2π·26.4)² m = 0.1454 mm, not by the 0.3127 mm of 18 Hz."""
    path = tmp_path / "my.toml"
    path.write_text(FILE)
    run = "simulate", "--solver", "reference", "--system", str(path), "--periods", "50", "--keep", "1", "--json"
    _, out, err = run_command(capsys, *run, "--eta", "26.4 Hz")
    assert "base acceleration 4 m/s2 is held over the frequency" in err
    same = FILE.replace("base_acceleration_m_per_s2 = 4.0", "base_amplitude_mm = 0.14537460").replace("18.0", "26.4")
    path.write_text(same)
    _, expected, err = run_command(capsys, *run)
    assert "held" not in err
    millimetres = [
        json.loads(text)["section"][0][0] * length
        for text, length in ((out, 0.312719702599808), (expected, 0.14537460))
    ]
    assert millimetres[0] == pytest.approx(millimetres[1], rel=1e-5)


def test_the_file_of_the_command_line_keeps_the_form(tmp_path, capsys):
    path = tmp_path / "my.toml"
    path.write_text(FILE)
    _, out, _ = run_command(capsys, "system", "--system", str(path), "--to", "physical")
    for line in FILE.splitlines()[1:]:
        assert f"{line} " in out


def test_the_order_of_typing_does_not_change_the_separation_speed():
    """What is typed before the frequency is of another motion of the base, thousands of times as large."""
    late = {name: text for name, text in BRACKET.items() if name != "eta"} | {"eta": "18 Hz"}
    one, other = enter(WALL, **BRACKET), enter(WALL._replace(eta=0.01), **late)
    assert shown(one)["base_acceleration_m_per_s2"] == shown(other)["base_acceleration_m_per_s2"]
    assert other.threshold * other.amplitude == pytest.approx(one.threshold * one.amplitude, rel=1e-9)
