"""No sentence holds nan or inf, and no JSON: comparisons of random settings, extremes included, and every wording."""

import math
import re
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from vibroscope.app.commands.cli import main
from vibroscope.app.commands.compare import as_json, lines_of
from vibroscope.app.runtime.json_text import json_text
from vibroscope.engine import (
    ComparisonQuestion,
    Excitation,
    Newmark,
    Reference,
    System,
    compare,
    counted,
    many,
    percent,
    rounded,
    verdict,
)

from tests.served import ROOT
from tests.share import share

NO_NUMBER = re.compile(r"(?<![\w/])[+-]?(?:nan|inf|infinity)\b", re.IGNORECASE)
COUNT = 24
UNBOUNDED = "--eta 4 --K 339.3662542650282 --D 16.436229883249432 --steps 9 --joint-damping derived --threshold 0"


def extreme(rng, low, high, edges):
    """A number between the limits, evenly in the logarithm; every third time one of the edges."""
    return float(rng.choice(edges)) if rng.random() < 1 / 3 else float(np.exp(rng.uniform(np.log(low), np.log(high))))


def random_change(rng):
    """Of a system: a wall or any two bodies, a clearance of either sign, and what drives them, or does not."""
    sign, kind = rng.choice((-1.0, 1.0), 4), rng.integers(3)
    amplitudes = {name: extreme(rng, 1e-3, 1e3, (0, 0, 1e6)) for name in ("force1", "force2", "constant1", "constant2")}
    drive = {name: turn * value for (name, value), turn in zip(amplitudes.items(), sign, strict=True)}
    bodies = ({}, {"wall": True}, {"mu": extreme(rng, 1e-3, 1e3, (1, 1e-9)), "d3": None})[kind]
    clearance = float(rng.choice(sign)) * extreme(rng, 1e-3, 1e2, (0, 1e6))
    excitation = Excitation(base=float(rng.choice((0, 1, 1e-6))), base_phase=rng.uniform(-3, 3), **drive)
    return bodies | {"clearance": clearance, "excitation": excitation}


def random_case(rng):
    """A system, η, Newmark and the reference, from where nothing moves to where everything blows up."""
    kappa = rng.uniform(1.2, 6)
    restitution = extreme(rng, 1e-2, 0.9, (0, 0.5))
    damping = {name: extreme(rng, 1e-3, 0.5, (0.001, 0.9)) for name in ("d1", "d2")}
    system = System(kappa=kappa, kappa3=rng.uniform(1.01, kappa - 0.01), restitution=restitution, **damping)
    if rng.random() < 0.7:
        system = replace(system, **random_change(rng))
    contact = extreme(rng, 1, 1e7, (0.01, 404.8, 1e9)), extreme(rng, 1e-1, 1e3, (0, 15.87))
    method = Newmark(*contact, int(extreme(rng, 8, 2000, (8, 11))), located=bool(rng.random() < 0.2))
    reference = Reference(str(rng.choice(("table", "derived"))), extreme(rng, 1e-4, 0.1, (0, 0.002)))
    return system, extreme(rng, 0.4, 8, (0.5, 4, 20)), method, reference


def test_comparisons_hold_numbers_or_words():
    rng, found = np.random.default_rng(7), []
    for _ in range(share(COUNT)):
        system, eta, method, reference = random_case(rng)
        length = {"periods": 60, "keep": 8} if system.excitation.drives else {"periods": 2, "keep": 2}
        comparison = compare(ComparisonQuestion(system, eta, method, reference=reference, **length))
        arguments = comparison, verdict(comparison)
        json_text(as_json(*arguments))
        text = "\n".join(map(str, lines_of(*arguments)))
        found += [(system, eta, method, text)] if NO_NUMBER.search(text) else []
    assert not found


@pytest.mark.parametrize("more", [["--units"], ["--json"]])
def test_sections_of_a_solution_that_does_not_stay_bounded(capsys, more):
    assert main(["compare", *UNBOUNDED.split(), *more]) == 0
    out = capsys.readouterr().out
    assert not NO_NUMBER.search(out)
    assert "there is nothing to compare" in out
    assert "not known (chance" not in out


UNDAMPED = """[physical]
mass1_kg = 1
frequency1_Hz = 1
mass2_kg = 1
stiffness2_N_per_m = 1.96341
base_amplitude_mm = 1
frequency_Hz = 1
constant1_N = -710.127
restitution = 0.5
"""


def test_bodies_that_nothing_damps_and_that_never_touch(capsys, tmp_path):
    file = tmp_path / "my.toml"
    file.write_text(UNDAMPED)
    method = ["--eta", "2.76", "--K", "12000", "--D", "18", "--steps", "100"]
    assert main(["motion", "--solver", "newmark", *method, "--system", str(file), "--units", "none"]) == 0
    out, err = capsys.readouterr()
    said = " ".join(out.split())
    assert "without a time step the motion is quasi-periodic" in said
    assert "the other frequency is 0.362319 of the first" in said  # 1/2.76, of body 1
    assert "the band does not shrink with the step (±0.71 at T/100, ±0.71 at T/400" in said
    assert not NO_NUMBER.search(out)
    assert err == "vibroscope: base displacement 1 mm is held over the frequency\n"


def test_a_motion_about_a_point_thousands_of_amplitudes_away(capsys, tmp_path):
    """In shares of where the constant force holds body 1, the section repeats itself after 80 periods."""
    file = tmp_path / "my.toml"
    file.write_text(UNDAMPED.replace("1.96341", "12"))
    method = ["--eta", "2.76", "--K", "12000", "--D", "18", "--steps", "100"]
    assert main(["motion", "--solver", "newmark", *method, "--system", str(file)]) == 0
    said = " ".join(capsys.readouterr().out.split())
    assert "motion quasi-periodic" in said
    assert "repeats" not in said


@given(st.floats(), st.floats() | st.none(), st.integers(1, 6))
def test_wordings_of_any_number(value, beside, digits):
    texts = [percent(value, beside), rounded(value, digits), counted(value, "turn"), many(value)]
    assert not [text for text in texts if NO_NUMBER.search(text)]
    assert ("not known" in texts[1]) == (not math.isfinite(value))


def test_every_share_passes_through_percent():
    """Written otherwise 180 % becomes "1.8e+02 %", and one number has other digits in another place."""
    by_hand = re.compile(r":\.[0-9]g\} %|:\.[0-9]%\}")
    found = [path for path in (ROOT / "app").rglob("*.py") if by_hand.search(path.read_text(encoding="utf-8"))]
    assert found == []
