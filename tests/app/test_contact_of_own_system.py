"""K and D of a system of one's own: they follow from it, by a rule that is named, until they are typed."""

import math

import pytest
from vibroscope.app.explorer.errors import Refused
from vibroscope.app.explorer.link import parse_address, print_address
from vibroscope.app.explorer.physical_fields import entered
from vibroscope.app.explorer.presets import opening_setting
from vibroscope.app.explorer.reading import read_setting
from vibroscope.app.explorer.typed import plain_texts
from vibroscope.app.export.formats import as_toml, loaded_from_toml
from vibroscope.app.page.controls.controls import Controls
from vibroscope.engine import restitution_of_damping

from tests.app.command_line import PHYSICAL

BRACKET = {"mass1_kg": "0.8", "frequency1_Hz": "22", "damping1_ratio": "0.02", "clearance_mm": "0.3"}
BRACKET |= {"restitution": "0.6", "base_acceleration_m_per_s2": "4"}


def send(setting, texts):
    return read_setting(entered(plain_texts(texts, setting), setting), setting)


def own(**typed):
    """The page after "a body and a wall", SI and each number were chosen and typed in turn."""
    setting = send(send(opening_setting(), {"units": "si"}), {"bodies": "wall"})
    for name, text in (BRACKET | typed).items():
        setting = send(setting, {name: {"typed": text}})
    return setting


def shown(setting):
    controls = Controls()
    controls.show_setting(setting)
    return controls


def test_a_new_system_is_not_judged_on_the_numbers_of_the_demo():
    """A contact of 0.8 kg at 22 Hz lasts 1 % of 1/22 s, and keeps 0.6 of the speed."""
    setting = own()
    k, c = 2500 * 0.8 * (2 * math.pi * 22) ** 2, setting.scale.physical("contact_damping", setting.D)
    assert math.pi * math.sqrt(0.8 / k) == pytest.approx(0.01 / 22)
    assert setting.scale.physical("contact_stiffness", setting.K) == pytest.approx(k, rel=1e-5)
    ratio = -math.log(0.6) / math.hypot(math.pi, math.log(0.6))
    assert c == pytest.approx(2 * ratio * math.sqrt(k * 0.8), rel=1e-5)
    notes = shown(setting).shown["notes"]
    assert "a contact lasts 1 % of the shorter natural period, until K is typed" in notes["K"]
    assert "from e = 0.6 until it is typed" in notes["D"]


def test_they_follow_the_system_until_they_are_typed():
    setting = own()
    softer = send(setting, {"restitution": {"typed": "0.3"}})
    assert softer.D > setting.D
    assert restitution_of_damping("kelvin-voigt", softer.D, softer.K) == pytest.approx(0.3, rel=1e-4)
    typed = send(setting, {"K": {"typed": "5e6 N/m"}})
    assert typed.scale.physical("contact_stiffness", typed.K) == pytest.approx(5e6)
    assert restitution_of_damping("kelvin-voigt", typed.D, typed.K) == pytest.approx(0.6, rel=1e-4)
    both = send(typed, {"D": {"typed": "100"}})
    again = send(both, {"restitution": {"typed": "0.3"}})
    assert (again.K, again.D, again.stiffness, again.damper) == (typed.K, both.D, "typed", "typed")


def test_i_do_not_know_d_is_a_choice():
    typed = send(send(own(), {"K": {"typed": "5e6"}}), {"D": {"typed": "100"}})
    offers = shown(typed).shown["offers"]
    assert offers["D"]["text"] == "I do not know D"
    known = send(typed, offers["D"]["set"])
    assert restitution_of_damping("kelvin-voigt", known.D, known.K) == pytest.approx(0.6, rel=1e-4)
    assert "D" not in shown(known).shown["offers"]
    assert not shown(known).fields["D"]["locked"]


def test_a_link_and_a_file_bring_back_that_they_follow():
    setting = own()
    assert read_setting(parse_address(print_address(setting))) == setting
    assert read_setting(loaded_from_toml(as_toml(setting)).texts) == setting


def test_a_data_sheet_without_a_contact_has_one_that_follows():
    setting = read_setting(loaded_from_toml(PHYSICAL).texts, opening_setting())
    assert (setting.K, setting.stiffness, setting.damper) == (2500.0, "system", "restitution")
    assert restitution_of_damping("kelvin-voigt", setting.D, setting.K) == pytest.approx(0.5, rel=1e-4)


def test_a_data_sheet_beside_a_setting_has_the_contact_of_that():
    setting = read_setting(loaded_from_toml(f"[setting]\nK = 5000.0\nD = 9.0\n{PHYSICAL}").texts, opening_setting())
    assert (setting.K, setting.D, setting.stiffness, setting.damper) == (5000.0, 9.0, "typed", "typed")


def test_what_was_computed_with_a_number_is_set_with_it():
    """A click on "K = 8000 leaves 3 %" sets K beside the D of that run."""
    setting = own()
    applied = read_setting(setting.with_contact({"K": "8000"}), setting)
    assert (applied.K, applied.D, applied.damper) == (8000.0, setting.D, "typed")


def test_a_restitution_that_no_damper_gives_is_refused_beside_its_field():
    setting = send(own(), {"law": "cut"})
    with pytest.raises(Refused, match="less than any damping gives") as refused:
        send(setting, {"restitution": {"typed": "0"}})
    assert refused.value.name == "restitution"


def test_a_scene_keeps_its_own():
    """Other numbers of the paper's pendulums are explored with the K and D that are set."""
    scene = opening_setting()
    assert send(scene, {"restitution": {"typed": "0.6"}}).D == scene.D
    assert send(scene, {"kappa": {"typed": "2.6"}}).K == scene.K
