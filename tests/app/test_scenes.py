import pytest
from vibroscope.app.explorer.parameters import MAIN_FIELDS
from vibroscope.app.explorer.presets import buttons, opening_setting, preset_of, scenes
from vibroscope.app.explorer.reading import read_setting
from vibroscope.app.explorer.state import Setting
from vibroscope.app.page.address import read_opening

from tests.app.explanations import explained, runs_of


def test_scenes_carry_the_papers_numbers():
    found = scenes()
    assert [found[key].setting.eta for key in "ABCD"] == [1.08, 1.70, 2.76, 3.25]
    assert {n: found["9B"].texts()[n] for n in MAIN_FIELDS} == {"eta": "1.08", "K": "100", "D": "50", "steps": "2000"}
    assert [found[f"14{key}"].setting.steps for key in "ABCD"] == [2000, 4000, 6000, 8000]
    assert {(found[f"14{key}"].setting.K, found[f"14{key}"].setting.D) for key in "ABCD"} == {(12000, 18)}
    assert all("ur example" in found[f"10{key}"].tooltip for key in "ABC")


def test_every_scene_is_valid_and_recognised():
    for scene in scenes().values():
        setting = read_setting(scene.texts())
        assert scene.matches(setting)
        assert preset_of(setting) is not None
        assert not scene.matches(setting._replace(restitution=0.7))


def test_the_opening_scene_shows_a_wrong_motion_of_one_period_and_blames_a_number_that_can_be_set():
    runs = runs_of(opening_setting())
    assert runs.penalty.motion.impacts_per_period == 1  # it looks plausible
    explanation = explained(opening_setting())
    assert explanation.agree == "no"
    assert explanation.change.keys() <= {"K", "D", "steps"}
    assert explanation.change


@pytest.mark.parametrize(("key", "period", "impacts"), [("A", 1, 10), ("B", 0, None), ("C", 1, 1), ("D", 2, 0.5)])
def test_titles_say_what_the_reference_does(key, period, impacts):
    found = runs_of(read_setting(scenes()[key].texts())).reference.motion
    assert found.period == period
    assert impacts is None or found.impacts_per_period == impacts


def test_buttons_have_unequal_titles():
    shown = buttons()
    assert {scene.key for scene in shown} == {preset_of(read_setting(scene.texts())).key for scene in scenes().values()}
    assert len({scene.title for scene in shown}) == len(shown)


@pytest.mark.parametrize("query", ["", "?view=plane", "?theme=dark", "?utm_source=mail"])
def test_a_page_without_parameters_opens_with_the_scene(query):
    assert read_opening(query).setting == opening_setting()


@pytest.mark.parametrize(("query", "changed"), [("?units=si", {"units": "si"}), ("?eta=2", {"eta": 2.0})])
def test_a_link_that_leaves_out_defaults_keeps_its_meaning(query, changed):
    assert read_opening(query).setting == Setting()._replace(**changed)
    assert (Setting().eta, Setting().K, Setting().D, Setting().steps) == (1.08, 2500, 8, 2000)
