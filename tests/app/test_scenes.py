from vibroscope.app.explorer.scenes import scene_key, scenes
from vibroscope.app.explorer.state import MAIN_FIELDS, read_setting


def test_scenes_carry_the_papers_numbers():
    found = scenes()
    assert [found[key].eta for key in "ABCD"] == [1.08, 1.70, 2.76, 3.25]
    assert {n: found["9B"].texts()[n] for n in MAIN_FIELDS} == {"eta": "1.08", "K": "100", "D": "50", "steps": "2000"}
    assert [found[f"14{key}"].steps for key in "ABCD"] == [2000, 4000, 6000, 8000]
    assert {(found[f"14{key}"].K, found[f"14{key}"].D) for key in "ABCD"} == {(12000, 18)}
    assert all("ur example" in found[f"10{key}"].tooltip for key in "ABC")


def test_every_scene_is_valid_and_recognised():
    for scene in scenes().values():
        setting = read_setting(scene.texts())
        assert scene.matches(setting)
        assert scene_key(setting) != ""
        assert not scene.matches(setting._replace(restitution=0.7))
