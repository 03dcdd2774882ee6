"""Other systems: what the sliders cover, the shelf, files and links with a whole system."""

import math

import pytest
from vibroscope.app.explorer.compute import compute_runs
from vibroscope.app.explorer.errors import Refused
from vibroscope.app.explorer.explanation import describe, explain
from vibroscope.app.explorer.link import parse_address, print_address
from vibroscope.app.explorer.parameters import FIELDS, MAIN_FIELDS
from vibroscope.app.explorer.presets import preset_of, scenes, shelf
from vibroscope.app.explorer.reading import read_setting
from vibroscope.app.explorer.state import Setting, slider_range, widened
from vibroscope.app.explorer.suggestion import make_question
from vibroscope.app.export.formats import as_toml, loaded_from_toml
from vibroscope.app.export.scripts import as_command, as_python
from vibroscope.app.page.controls.controls import Controls
from vibroscope.app.page.session import Session
from vibroscope.engine import System

SYSTEMS = {
    "equal": System(kappa=1.0, mu=1.0, d3=None),
    "heavy": System(kappa=3.0, mu=50.0, d3=None),
    "slow": System(kappa=0.2, mu=0.5, d3=None),
    "wall": System(wall=True),
}


@pytest.mark.parametrize("name", MAIN_FIELDS)
def test_the_sliders_of_the_papers_bodies_are_what_they_were(name):
    assert slider_range(name, System()) == FIELDS[name].slider
    assert slider_range(name, System(restitution=0.9, d1=0.1, clearance=2.0)) == FIELDS[name].slider


@pytest.mark.parametrize("system", SYSTEMS.values(), ids=SYSTEMS)
def test_the_sliders_follow_the_springs_and_frequencies(system):
    mu = system.mass_ratio
    spring = 1.0 if system.wall else max(1.0, mu * system.kappa**2)
    share = 1.0 if system.wall else mu / (1 + mu)
    K, D, eta = (slider_range(name, system) for name in ("K", "D", "eta"))
    assert pytest.approx((spring, 1e5 * spring), rel=5e-3) == K
    ratios = [d / math.sqrt(k * share) for k, d in zip(K, D, strict=True)]
    assert ratios == pytest.approx([0.05, 0.5], rel=5e-3)
    lower, upper = min(1.0, *system.frequencies), max(1.0, *system.frequencies)
    assert eta[0] == pytest.approx(lower / 4, rel=5e-3)
    assert eta[1] == pytest.approx(max(5 / 3 * upper, 6 * lower), rel=5e-3)
    for name in MAIN_FIELDS:
        low, high = FIELDS[name].bounds
        assert low <= slider_range(name, system)[0] < slider_range(name, system)[1] <= high


@pytest.mark.parametrize("key", shelf())
def test_every_system_of_the_shelf_is_valid_cited_and_recognised(key):
    found = shelf()[key]
    setting = read_setting(found.texts(), read_setting({"restitution": "0.1", "clearance": "3", "threshold": "0.5"}))
    assert preset_of(setting).key == key
    assert preset_of(setting._replace(clearance=setting.clearance + 1)) is None
    assert found.tooltip
    assert found.caption.endswith("?")
    assert setting.units == "si"
    low, high = widened(slider_range("K", setting.system), setting.K)
    assert low <= setting.K <= high
    low, high = slider_range("eta", setting.system)
    assert low <= setting.eta <= high


def test_scenes_and_shelf_have_keys_and_titles_of_their_own():
    assert not scenes().keys() & shelf().keys()
    titles = [each.title for each in (*scenes().values(), *shelf().values())]
    assert len({each.title for each in shelf().values()} & {each.title for each in scenes().values()}) == 0
    assert len(titles) > len(shelf()) >= 7


def test_a_click_sets_system_units_and_contact_and_a_scene_leads_back():
    class Sets:
        def set(self, texts, *, fresh):
            self.setting = read_setting(texts, getattr(self, "setting", None))

    session = Sets()
    for key in shelf():
        Session.choose(session, key)
        assert preset_of(session.setting).key == key
    Session.choose(session, "no such")
    assert preset_of(session.setting).key == key
    Session.choose(session, "A")
    assert session.setting.system == System()
    assert preset_of(session.setting).key == "A"


@pytest.mark.parametrize("key", shelf())
def test_links_and_files_carry_the_whole_system(key):
    setting = shelf()[key].setting
    assert read_setting(parse_address(print_address(setting))) == setting
    assert read_setting(loaded_from_toml(as_toml(setting)).texts, Setting(clearance=7.0, force2=3.0)) == setting


PHYSICAL = b"""[physical]
mass1_kg = 25.0
frequency1_Hz = 10.0
wall = true
clearance_mm = -0.5
force1_N = 12.0
frequency_Hz = 12.0
"""


def test_a_file_in_physical_units_sets_system_units_and_frequency():
    setting = read_setting(loaded_from_toml(PHYSICAL.decode()).texts, Setting(clearance=7.0))
    assert (setting.bodies, setting.units, setting.m1, setting.base) == ("wall", "si", 25.0, 0.0)
    assert setting.eta == pytest.approx(1.2)
    assert setting.clearance * setting.amplitude == pytest.approx(-0.5)
    assert setting.system.rest[0] == pytest.approx(setting.clearance)


FREE = shelf()["thrown"].setting


def test_a_free_vibration_is_compared_from_its_start_in_words_script_and_commands(capsys):
    runs = compute_runs(FREE)
    assert (runs.penalty.response.periods, runs.penalty.response.keep) == (2, 2)
    assert runs.penalty.motion.peak_force * FREE.scale.factor("force") == pytest.approx(9950.37, rel=3e-3)  # SDND101
    found = explain(runs)
    assert "free vibration" in found.headline
    lasts, alone = found.in_units(FREE.scale).details
    assert lasts == "A contact of this K and D alone lasts 31.42 ms: 25.1 steps."
    assert "restitution of 1.00 without a step, 0.99 to 1.00 with 25.1 steps in it; 83 % of the touches part" in alone
    assert found.series["total"].shape[0] == 2
    assert "Free vibration. 4 impacts in 2 periods T" in describe(runs).lines(found)["reference"]
    exec(as_python(FREE), {})
    assert f"total {found.parts['total']}" in capsys.readouterr().out
    assert set(found.parts) == {"total", "time_step", "regularisation"}  # a wall has no joint damping
    assert "--periods 2" in as_command(FREE)
    assert "vibroscope compare" in as_command(FREE)
    assert slider_note(FREE)["name"].startswith("frequency that counts time")
    with pytest.raises(Refused, match="Nothing drives the bodies"):
        make_question(FREE, {})


def slider_note(setting):
    controls = Controls()
    controls.show_setting(setting)
    return controls.fields["eta"]


@pytest.mark.parametrize(("clearance", "words"), [(500.0, "Nothing touches"), (-500.0, "Permanent contact")])
def test_what_never_touches_and_what_never_parts_is_a_result_in_words(clearance, words):
    setting = Setting(bodies="two", mass_ratio=0.6, clearance=clearance, joint_damping="derived", steps=500)
    runs = compute_runs(setting)
    lines = describe(runs).lines(explain(runs))
    assert words in lines["reference"]
    assert words in lines["penalty"]
