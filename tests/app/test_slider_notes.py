"""A typed number that its slider does not reach has a word below it that says so."""

import pytest
from vibroscope.app.explorer.state import Setting
from vibroscope.app.page.controls.controls import Controls

TWO = Setting(bodies="two", mass_ratio=2.0, kappa=2.0, joint_damping="derived")  # the stiffer spring is 8 k₁


@pytest.mark.parametrize(
    ("setting", "name", "words"),
    [
        (TWO._replace(K=5.0), "K", "softer than the stiffer spring, below the slider, which begins at 8"),
        (TWO._replace(K=1e7), "K", "above the slider, which ends at 800000"),
        (TWO._replace(D=1e-3), "D", "below the slider, which begins at 0.115"),
        (TWO._replace(eta=100.0), "eta", "above the slider, which ends at 6"),
        (
            TWO._replace(K=5.0, units="si"),
            "K",
            "K = 5 without dimension; softer than the stiffer spring, below the slider,",
        ),
        (Setting(K=7.0), "K", "below the slider, which begins at 10"),
    ],
)
def test_a_number_beyond_its_slider_says_so(setting, name, words):
    controls = Controls()
    controls.show_setting(setting)
    assert controls.shown["notes"][name].startswith(words)


def test_numbers_within_their_sliders_and_no_damping_have_no_such_note():
    controls = Controls()
    controls.show_setting(TWO._replace(K=8.0, D=0.0))
    assert list(controls.shown["notes"]) == ["steps"]
