"""The cheat sheet: its formulas, read as displayed, give what the solvers give; its keywords are the codes'."""

import math
import re
from dataclasses import replace

import numpy as np
import pytest
from vibroscope.app.codes.catalogue import codes
from vibroscope.engine import (
    ComparisonQuestion,
    ExactPenalty,
    Newmark,
    Record,
    Reference,
    compare,
    equal_restitution_damping,
    read_system,
    restitution_of_damping,
    simulate,
)

from tests.displayed import ROOT, value

SHOWN = re.findall(r"^    (\S+) += (.+?)(?: {3,}.*)?$", (ROOT / "docs/cheatsheet.md").read_text(), re.MULTILINE)
FORMULAS = {name: formula for name, formula in reversed(SHOWN) if name != "k"}
OF_DEPTH, OF_FORCE = (formula for name, formula in SHOWN if name == "k")
FILES = [read_system(ROOT / f"docs/{name}.toml") for name in ("my", "two")]


def symbols_of(file, ratio):
    """m₁, k₁ and the restitution of a system, its closing speed, and what the page makes of them for k = ratio k₁."""
    units, system = file.units, file.system
    reference = simulate(system, file.eta, Reference())
    parts = units.pendulums(replace(system, wall=False) if system.wall else system)
    known = {"m₁": parts["m1"], "k₁": parts["k1"], "e": system.restitution, "N": len(reference.impacts.time) / 50}
    impulse = reference.impacts.impulse.sum() / 50
    known |= {"m₂": parts["m2"], "J": units.physical("impulse", impulse), "ω₁": units.omega1, "k": ratio * parts["k1"]}
    names = ("m*", "v", "ζ", "c", "t_c", "Δt", "F", "h", "K", "D")
    for name in names:
        known[name] = known["m₁"] if name == "m*" and system.wall else value(FORMULAS[name], known)
    return known


def test_every_formula_is_read():
    assert FORMULAS.keys() == {"m*", "v", "ζ", "c", "t_c", "Δt", "F", "h", "K", "D"}


@pytest.mark.parametrize("file", FILES, ids=["wall", "two bodies"])
@pytest.mark.parametrize(("ratio", "accuracy"), [(600, 0.06), (1e6, 0.005)])
def test_a_contact_has_the_duration_rebound_and_force_of_the_formulas(file, ratio, accuracy):
    """A softer contact is longer, so that the springs and loads of the bodies act in it, too."""
    found, units = symbols_of(file, ratio), file.units
    method = ExactPenalty(found["K"], found["D"])
    assert found["K"] == pytest.approx(ratio)
    assert found["m*"] == pytest.approx(units.m1 * file.system.mass_share)
    run = simulate(file.system, file.eta, method, record=Record(1, 1_000_000))
    duration = units.physical("time", np.median(np.diff(run.contacts)))
    assert found["t_c"] == pytest.approx(duration, rel=accuracy)
    speed = units.physical("velocity", run.impacts.closing_speed.max())
    peak = units.physical("force", run.trajectory.force.max())
    assert found["F"] * speed / found["v"] == pytest.approx(peak, rel=accuracy)
    mass = file.system.mass_share
    e = restitution_of_damping("kelvin-voigt", method.damping, method.stiffness, mass=mass)
    assert e == pytest.approx(found["e"], rel=1e-6)


@pytest.mark.parametrize("file", FILES, ids=["wall", "two bodies"])
def test_the_closing_speed_follows_from_the_impulse(file):
    speeds = simulate(file.system, file.eta, Reference()).impacts.closing_speed
    assert symbols_of(file, 600)["v"] == pytest.approx(file.units.physical("velocity", speeds.mean()), rel=1e-9)


def test_a_stiffness_keeps_the_penetration_or_force_that_is_allowed():
    known = symbols_of(FILES[0], 600)
    for formula, name in ((OF_DEPTH, "δ"), (OF_FORCE, "F")):
        k = value(formula, known | {name: 2e-5 if name == "δ" else 1000.0})
        undamped = known["v"] * math.sqrt((known["m*"] / k) if name == "δ" else known["m*"] * k)
        assert undamped == pytest.approx(2e-5 if name == "δ" else 1000.0)


@pytest.mark.parametrize("ratio", [100, 584, 3000])
def test_twenty_steps_in_a_contact_keep_the_part_of_the_time_step_small(ratio):
    file, near = FILES[0], ratio * np.linspace(0.9, 1.1, 9)
    steps = round(file.units.physical("time", 2 * math.pi / file.eta) / symbols_of(file, ratio)["Δt"])
    methods = [Newmark(k, equal_restitution_damping(file.system, k), steps) for k in near]
    assert (
        np.median([compare(ComparisonQuestion(file.system, file.eta, method)).time_step for method in methods]) < 0.02
    )


@pytest.mark.parametrize(("factor", "grows"), [(0.999, False), (1.001, True)])
def test_the_explicit_step_is_the_largest_stable_one(factor, grows):
    """Central differences whose damper takes the velocity of half a step before, as explicit codes do."""
    found = symbols_of(FILES[0], 600)
    h, k, c = factor * found["h"], found["k"] / found["m*"], found["c"] / found["m*"]
    kick = np.array([[1.0, 0.0], [-h * k, 1.0 - h * c]])
    drift = np.array([[1.0, h], [0.0, 1.0]])
    assert (np.abs(np.linalg.eigvals(drift @ kick)).max() > 1) == grows


def test_the_numbers_of_the_example_follow():
    found = symbols_of(FILES[0], 5.8e7 / 98696)
    assert [float(f"{found[name]:.2g}") for name in ("v", "ζ", "c", "t_c", "Δt", "F")] == [
        0.026,
        0.071,
        5400,
        0.0021,
        0.0001,
        890,
    ]
    assert float(f"{value(OF_DEPTH, found | {'δ': 1.7e-5}):.2g}") == 5.8e7


@pytest.mark.parametrize(
    ("code", "first", "takes"),
    [
        ("abaqus-standard", "Abaqus, surface contact", ("k/A", "c/A")),
        ("abaqus-explicit", "Abaqus/Explicit", ("k/A", "ζ")),
        ("ansys", "Ansys, surface contact", ("−k/A",)),
        ("calculix", "CalculiX", ("k/A", "c/A")),
    ],
)
def test_the_keywords_take_what_the_codes_take(code, first, takes):
    row = re.search(rf"^\| {re.escape(first)} \| (.*) \|$", (ROOT / "docs/cheatsheet.md").read_text(), re.MULTILINE)[1]
    blanks = {"k/A": "{k/area}", "−k/A": "-{k/area}", "c/A": "{c/area}", "ζ": "{zeta}"}
    lines = "\n".join(codes()[code].input)
    assert all(symbol in row and blanks[symbol] in lines for symbol in takes)
    assert not [symbol for symbol in ("c/A", "ζ") if symbol not in takes and blanks[symbol] in lines]
