"""Comparisons, verdicts and sweeps with every contact law, with a D and with a damper that follows from e."""

import json

import numpy as np
import pytest
from vibroscope.app.commands.cli import main
from vibroscope.engine import (
    CONTACT_LAWS,
    LAWS_BY_RESTITUTION,
    Comparison,
    ComparisonQuestion,
    PlaneStudy,
    System,
    TimeStepping,
    compare,
    effective_restitution,
    motion,
    simulate,
    sweep,
    verdict,
)
from vibroscope.engine.contact import contact_frequency, equal_damping, spring_duration
from vibroscope.engine.divergence.encounters import delivered_restitution, mean_closing_speed

from tests.law_numbers import law_numbers
from tests.share import every

SYSTEM, ETA = System(), 2.76
SHORT = {"periods": 300, "keep": 10}
CASES = [(law, 18.0) for law in CONTACT_LAWS] + [(law, None) for law in LAWS_BY_RESTITUTION]


def stepping(law, damping, steps=1000, **more):
    return TimeStepping(12000, damping, steps, law=law, **law_numbers(law, penetration=0.001), **more)


@pytest.mark.parametrize(("law", "damping"), every(CASES))
def test_every_law_has_a_verdict_and_parts_that_add_up(law, damping, monkeypatch):
    """What the motions are is taken from the kept periods, since evidence for it takes seconds."""
    monkeypatch.setattr(Comparison, "decided", lambda self, _: self)
    found = compare(ComparisonQuestion(SYSTEM, ETA, stepping(law, damping), **SHORT))
    words = verdict(found)
    text = " ".join((words.headline, *words.details))
    assert "nan" not in text
    assert "None" not in text
    assert damping is not None or "D = " not in text
    (bounce,) = (line for line in words.details if line.startswith("In the motion the bodies part"))
    delivered = delivered_restitution(found.runs.penalty)
    assert abs(float(bounce.split("with ")[1].split()[0]) - delivered) < 0.006
    split = found.split()
    rest = split.contact_time + split.wrong_restitution - found.parts.regularisation
    assert np.nanmax(np.abs(rest)) < 1e-10
    assert np.isnan(split.ratio) == (law != CONTACT_LAWS[0])
    if law != CONTACT_LAWS[0]:
        speed = mean_closing_speed(found.runs.derived)
        assert split.restitution == effective_restitution(SYSTEM, found.runs.exact.method, speed)


@pytest.mark.parametrize("law", CONTACT_LAWS)
def test_the_equal_damping_of_a_law_gives_the_restitution(law):
    equal = equal_damping(SYSTEM, stepping(law, 18.0), 12000, 0.7)
    assert effective_restitution(SYSTEM, stepping(law, equal), 0.7) == pytest.approx(SYSTEM.restitution, abs=1e-6)


def test_where_the_damper_follows_from_e_there_is_no_D_to_change():
    found = compare(ComparisonQuestion(SYSTEM, ETA, stepping("flores", None), **SHORT))
    assert np.isnan(equal_damping(SYSTEM, found.runs.penalty.method, 12000, 1.0))
    assert "D" not in verdict(found).alone.curves


@pytest.mark.parametrize("law", ["kelvin-voigt", "hunt-crossley", "impact"])
def test_an_undamped_contact_lasts_as_long_as_the_formula_says(law):
    run = simulate(SYSTEM, 2.76, stepping(law, 0.0, 20_000).limit, periods=20, keep=5)
    starts = np.isin(run.impacts.time, run.contacts[:, 0])
    speeds = -np.diff(run.impacts.velocity_before, axis=1)[starts, 0]
    took = np.diff(run.contacts[np.isin(run.contacts[:, 0], run.impacts.time)], axis=1)[:, 0]
    fast = speeds > 0.3 * speeds.max()
    expected = spring_duration(SYSTEM.mass_share, run.method, speeds)
    np.testing.assert_allclose(took[fast], expected[fast], rtol=0.1)
    if law == CONTACT_LAWS[0]:
        np.testing.assert_allclose(expected, np.pi / contact_frequency(SYSTEM, 12000))


def test_a_motion_whose_damper_remembers_is_described():
    assert motion(SYSTEM, ETA, stepping("flores", None, 500)).near_period


@pytest.mark.parametrize("damping", [["--D", "750"], []])
def test_compare_writes_a_law_as_strict_json(damping, capsys):
    numbers = ["--K", "12000", "--steps", "1000", "--law", "flores", "--periods", "300", "--keep", "10", "--json"]
    assert not main(["compare", "--eta", str(ETA), *numbers, *damping])
    report = json.loads(capsys.readouterr().out)
    assert report["split"]["damping_ratio"] is None
    assert report["split"]["restitution"] == pytest.approx(0.5, abs=0.04)


def test_the_plane_without_a_time_step_has_the_law(tmp_path):
    axes, short = {"K": [12000.0], "D": [18.0]}, {"parts": False, "transient": 20, "sample": 5}
    plain, law = (
        sweep(PlaneStudy(SYSTEM, stepping(name, 18.0).limit, 2.76, **axes, **short), out=tmp_path / name)
        for name in ("kelvin-voigt", "flores")
    )
    assert plain["contact_share"].item() != law["contact_share"].item()
