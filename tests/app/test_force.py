"""A contact force that samples do not show is drawn and named as what it is: an impulse with its duration and mean."""

import numpy as np
import pytest
from vibroscope.app.explorer.compute import compute_runs
from vibroscope.app.explorer.explanation import describe
from vibroscope.app.explorer.method_words import force_text
from vibroscope.app.explorer.present import present
from vibroscope.app.explorer.state import Setting

SHORT = Setting(eta=2.0, K=100000.0, D=20.0, steps=500, located="yes", units="si")


@pytest.fixture(scope="module")
def runs():
    return compute_runs(SHORT)


def test_the_drawn_force_has_the_impulse_of_each_contact(runs):
    columns = present(runs)
    drawn, impulses = columns["force_penalty"], columns["impulse_penalty"]["impulse"]
    assert len(impulses)
    assert drawn["force"].max() > 0
    assert np.all(np.diff(drawn["t"]) >= 0)
    area = np.trapezoid(drawn["force"].astype(float), drawn["t"].astype(float))
    assert area == pytest.approx(impulses.sum(), rel=1e-2)


def test_a_force_without_samples_is_an_impulse_in_words(runs):
    run = runs.penalty
    text = force_text(SHORT.scale, run.response.eta, run.motion, run.response.method)
    assert text.startswith("contacts too short to sample a peak force: impulse ")
    impulse, duration, mean = (float(text.split(word)[1].split()[0]) for word in ("impulse ", "period in ", "mean "))
    assert " ms of contact" in text
    assert mean * duration == pytest.approx(1e3 * impulse, rel=0.02)


def test_an_impact_has_an_impulse_and_no_peak_force(runs):
    run = runs.reference
    text = force_text(SHORT.scale, run.response.eta, run.motion, run.response.method)
    assert text.startswith("impacts have an impulse and no peak force: impulse ")
    lasting = compute_runs(SHORT._replace(eta=1.08)).reference
    text = force_text(SHORT.scale, 1.08, lasting.motion, lasting.response.method)
    assert "in permanent contact; impacts have an impulse and no peak force" in text


def test_the_peak_of_a_motion_that_scatters_is_that_of_the_periods_in_view():
    """`engine.motion` looks at more periods and finds a higher one."""
    for eta, words in ((2.76, "N in 2 periods."), (1.08, "N.")):
        runs = compute_runs(Setting(eta=eta, K=12000.0, D=18.0, steps=2000, units="si"))
        assert describe(runs).penalty[1].endswith(words)
