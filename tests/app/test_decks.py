"""Decks describe the system that is set: their text, read back, gives the forces that a data sheet gives."""

import math
import subprocess
from itertools import product

import pytest
from vibroscope.app.export.decks import DECKS, DeckProblem, deck, usual_length
from vibroscope.engine import (
    HHT,
    Excitation,
    Newmark,
    NewmarkBeta,
    System,
    TimeStepping,
    Units,
    parse_measurement,
    simulate,
)
from vibroscope.engine.integrators import INTEGRATORS, GeneralisedAlpha, HHTInterpolated
from vibroscope.engine.physical import physical_entry

from tests.app.deck_readers import keywords, read_ansys, read_keywords, read_modelica, read_opensees, run_fake

ALL = Excitation(
    base=0.8, base_phase=0.3, force1=0.7, force1_phase=1.0, force2=-0.4, force2_phase=2.0, constant1=0.2, constant2=-0.1
)
MM = Units(omega1=30.0, m1=5.0, base_amplitude=2.0, system="mm-t-s")
SECOND = {"stiffness_factor2": 2.0, "damping_factor2": 0.5}
SYSTEMS = {
    "paper": (System(), None),
    "clearance": (System(mu=0.8, d3=None, clearance=0.3, excitation=ALL), Units(40.0, 3.0, 0.5)),
    "preload": (System(clearance=-0.3, excitation=ALL), MM),
    "wall": (System(wall=True, clearance=0.5, excitation=ALL), MM),
    "wall without spring": (System(wall=True, spring1=0.0, d1=0.02, clearance=0.5, excitation=ALL), MM),
    "wall with preload": (System(wall=True, clearance=-0.2), None),
    "hammer": (System(mu=0.8, spring1=0.0, kappa=1.5, d3=None, clearance=0.3, excitation=ALL), MM),
    "two without springs": (System(mu=0.8, spring1=0.0, kappa=0.0, excitation=ALL), MM),
    "two stops": (System(mu=0.8, d3=None, clearance=0.3, clearance2=0.6, excitation=ALL, **SECOND), MM),
    "wall, pressed to the second stop": (System(wall=True, clearance=0.5, clearance2=-0.45, **SECOND), None),
}
ETA, STEPS = 1.7, 40


def problem_of(name, damping=18.0, **more):
    system, units = SYSTEMS[name]
    return DeckProblem(system, ETA, Newmark(12000, damping, STEPS), units, periods=2, keep=1, **more)


def expected(problem):
    """Masses in the deck's units, and the forces at an instant and a state, from the numbers of a data sheet."""
    units = problem.units or Units(1.0, 1.0, 1000.0)
    mm = units.system == "mm-t-s"
    mass, length = (1e-3, 1e3) if mm else (1.0, 1.0)
    entry = physical_entry(problem.system, units, problem.eta)
    omega = 2 * math.pi * entry["frequency_Hz"]
    drive = problem.system.excitation

    def force(i, t, x, v):
        m, k = entry[f"mass{i}_kg"], entry[f"stiffness{i}_N_per_m"]
        ratio = entry.get(f"damping{i}_ratio", 0.0)  # without a spring the entry has the damper itself
        c = entry.get(f"damping{i}_Ns_per_m", 2 * ratio * math.sqrt(m * k))
        base = drive.base * units.base_amplitude / 1e3
        harmonic = m * base * omega**2 * math.cos(omega * t + drive.base_phase)
        own = entry.get(f"force{i}_N", 0.0) * math.cos(omega * t + getattr(drive, f"force{i}_phase"))
        return harmonic + own + entry.get(f"constant{i}_N", 0.0) - k * x / length - c * v / length

    count = 1 if problem.system.wall else 2
    scale = units.m1 * units.omega1
    stiffness, damping = problem.method.stiffness * scale * units.omega1, 2 * problem.method.damping * scale

    def forces(t, x, v):
        overlap = (x[0] - x[1]) / length - entry["clearance_mm"] / 1e3
        push = stiffness * overlap + damping * (v[0] - v[1]) / length if overlap >= 0 else 0.0
        beyond = (x[1] - x[0]) / length - entry.get("clearance2_mm", math.inf) / 1e3
        if beyond >= 0:
            pull = entry["stiffness_factor2"] * stiffness * beyond
            push -= pull + entry["damping_factor2"] * damping * (v[1] - v[0]) / length
        return [force(i, t, x[i - 1], v[i - 1]) + (push if i == 2 else -push) for i in range(1, count + 1)]

    return [entry[f"mass{i}_kg"] * mass for i in range(1, count + 1)], forces


def read(code, problem, monkeypatch, tmp_path):
    """Masses and forces that a deck describes."""
    text = deck(code, problem)
    if code == "modelica":
        forces, masses = read_modelica(text)
        return masses, forces
    if code == "opensees":
        model, _ = read_opensees(text, monkeypatch, tmp_path)
    else:
        model = (read_ansys if code == "ansys" else read_keywords)(text)
        start = [problem.scale.physical("displacement", problem.start[place]) for place in (0, 2)]
        model = model._replace(shifts=start)
    return [body.mass for body in model.bodies], model.forces


@pytest.mark.parametrize(("code", "name"), [*product(DECKS, SYSTEMS)])
def test_a_deck_has_the_forces_of_the_system(code, name, monkeypatch, tmp_path):
    problem = problem_of(name)
    masses, forces = read(code, problem, monkeypatch, tmp_path)
    true_masses, true_forces = expected(problem)
    assert masses == pytest.approx(true_masses, rel=1e-12)
    length, speed = problem.length, problem.scale.physical("velocity", 1.0)
    wall = 0.0 if problem.system.wall else 1.0
    for k, x, v in product((0, 7, 55), ((0.4, 1.1), (1.2, 0.3)), ((0.0, 0.0), (0.6, -0.9))):
        state = [length * x[0], wall * length * x[1]], [speed * v[0], wall * speed * v[1]]
        found, true = forces(k * problem.step, *state), true_forces(k * problem.step, *state)
        assert found == pytest.approx(true, rel=1e-10, abs=1e-10 * problem.scale.physical("force", 1.0))


@pytest.mark.parametrize("depth", [0.01, 0.05])
def test_modelica_has_the_spring_of_two_stiffnesses(depth):
    method = TimeStepping(12000.0, 18.0, STEPS, law="bilinear", penetration=0.02, stiffening=3.0)
    problem = DeckProblem(System(), ETA, method, MM, periods=2, keep=1)
    forces, _ = read_modelica(deck("modelica", problem))
    length, speed = problem.length, problem.scale.physical("velocity", 1.0)
    pressed, free = (forces(0.0, [x * length, 0.0], [0.7 * speed, 0.0])[1] for x in (depth, -depth))
    spring = 12000.0 * (min(depth, 0.02) + 3.0 * max(depth - 0.02, 0.0))
    assert pressed - free == pytest.approx(problem.scale.physical("force", spring + 2 * 18.0 * 0.7), rel=1e-10)


@pytest.mark.parametrize("x", [(0.9, 0.2), (0.2, 0.9)])
@pytest.mark.parametrize("name", ["clearance", "two stops"])
def test_without_damper_calculix_has_a_spring(name, x, monkeypatch, tmp_path):
    problem = problem_of(name, damping=0.0)
    _, forces = read("calculix", problem, monkeypatch, tmp_path)
    _, true = expected(problem)
    state = [each * problem.length for each in x], [0.0, 0.0]
    assert forces(0.0, *state) == pytest.approx(true(0.0, *state), rel=1e-10)


STARTS = None, (0.9, 0.2, 0.0, 0.0), (-0.9, -0.2, 0.0, 0.0)  # at rest, in contact, and with the second stop


@pytest.mark.parametrize(("name", "initial"), [*product(SYSTEMS, STARTS)])
def test_opensees_begins_with_the_accelerations_of_the_equations(name, initial, monkeypatch, tmp_path):
    problem = problem_of(name, initial=initial)
    model, fake = read_opensees(deck("opensees", problem), monkeypatch, tmp_path)
    masses, forces = expected(problem)
    start = problem.start
    x = [problem.scale.physical("displacement", start[place]) for place in (0, 2)]
    v = [problem.scale.physical("velocity", start[place]) for place in (1, 3)]
    wanted = [force / mass for force, mass in zip(forces(0.0, x, v), masses, strict=True)]
    bodies = range(1, len(masses) + 1)
    for kind, values in {"Accel": wanted, "Vel": v, "Disp": [x[0] - model.shifts[0], x[1]]}.items():
        given = {node: value for node, _, value, _ in fake.found(f"setNode{kind}")}
        size = max(map(abs, values)) or 1.0
        assert [given.get(i, 0.0) for i in bodies] == pytest.approx(values[: len(masses)], rel=1e-9, abs=1e-9 * size)


def test_opensees_writes_what_compare_reads(monkeypatch, tmp_path):
    run_fake(deck("opensees", problem_of("clearance")), monkeypatch, tmp_path)
    found = parse_measurement((tmp_path / "deck.csv").read_bytes(), SYSTEMS["clearance"][1])
    assert found.frame == "relative"
    assert len(found) == STEPS + 1
    assert found.span == pytest.approx(2 * math.pi / ETA)


def test_opensees_says_which_step_has_no_solution(monkeypatch, tmp_path):
    with pytest.raises(SystemExit, match=r"step 44 \(period 2\) has no solution"):
        run_fake(deck("opensees", problem_of("paper")), monkeypatch, tmp_path, fails=44)
    assert len((tmp_path / "deck.csv").read_text().splitlines()) == 1 + STEPS + 1  # a period, and the header


def test_calculix_has_a_command_that_makes_a_csv_file_of_its_result(tmp_path):
    problem = problem_of("preload")
    text = deck("calculix", problem)
    blocks = "".join(
        f"\n displacements (vx,vy,vz) for set OUT and time  {k * problem.step:.7E}\n\n"
        f"         2  {0.001 * k:.6E}  0.0E+00  0.0E+00\n         3  {-0.002 * k:.6E}  0.0E+00  0.0E+00\n"
        for k in range(1, 2 * STEPS + 1)
    )
    (tmp_path / "two_bodies.dat").write_text(blocks)
    command = next(line[3:] for line in text.splitlines() if line.startswith("** awk"))
    subprocess.run(command, shell=True, cwd=tmp_path, check=True)
    found = parse_measurement((tmp_path / "two_bodies.csv").read_bytes(), MM)
    assert len(found) == STEPS + 1
    start = problem.system.rest
    assert found.displacement[:, -1] * MM.base_amplitude == pytest.approx(
        [start[0] * MM.base_amplitude + 0.08, start[2] * MM.base_amplitude - 0.16]
    )


def test_integrators_in_the_words_of_each_code():
    def lines(code, integrator):
        return deck(code, DeckProblem(System(), ETA, TimeStepping(100, 1, STEPS, integrator, "end"), periods=1, keep=1))

    assert 'ops.integrator("Newmark", 0.6, 0.3025)' in lines("opensees", NewmarkBeta(0.3025, 0.6))
    assert 'ops.integrator("HHT", 0.9)' in lines("opensees", HHTInterpolated(-0.1))
    assert 'ops.integrator("HHTGeneralized", 0.8)' in lines("opensees", GeneralisedAlpha(0.8))
    assert "SUBSTEPS = 2" in lines("opensees", INTEGRATORS["tr-bdf2"]())
    for code in ("abaqus", "calculix"):
        (alpha,) = (p["ALPHA"] for name, p, _ in keywords(lines(code, HHT(-0.05))) if name == "DYNAMIC")
        assert float(alpha) == -0.05
    assert "TINTP,,0.275625,0.55,,,,,,,0.05,0" in lines("ansys", HHT(-0.05))


REFUSED = {
    "law": ("opensees", {"law": "cut"}, "OpenSeesPy cannot express law = 'cut'"),
    "averaged": ("opensees", {"integrator": HHT()}, "cannot express integrator = 'hht'"),
    "interpolated": ("calculix", {"integrator": HHTInterpolated()}, "cannot express integrator = 'hht-interpolated'"),
    "located": ("abaqus", {"status": "located"}, "cannot express status = 'located': it has 'end'"),
    "iterated": ("modelica", {}, "cannot express status = 'end': it has 'located'"),
    "halved": ("ansys", {"without_solution": "halve"}, "the deck's step is constant"),
    "numbers": ("calculix", {"integrator": NewmarkBeta(0.3, 0.6)}, "other numbers of Newmark's method"),
    "two stops": ("opensees", {"damping": None, "law": "flores"}, "law = 'flores' at two stops: this deck has kelvin"),
    "too long": ("calculix", {"steps": 200_000}, "100000 rows"),
    "modelica": ("modelica", {"integrator": HHT(), "status": "start"}, "Modelica cannot express the integrator"),
}


@pytest.mark.parametrize("kind", REFUSED)
def test_what_a_code_cannot_express_is_refused(kind):
    code, given, words = REFUSED[kind]
    method = TimeStepping(**{"stiffness": 100, "damping": 1, "steps": STEPS, "status": "end", **given})
    with pytest.raises(ValueError, match=words) as refused:
        deck(code, DeckProblem(System(clearance2=9.0 if kind == "two stops" else None), ETA, method, periods=1, keep=1))
    assert "\n" not in str(refused.value)


@pytest.mark.parametrize("law", ["flores", "jankowski", "hunt-crossley", "lankarani-nikravesh"])
def test_opensees_has_materials_of_hertz(law, monkeypatch, tmp_path):
    from vibroscope.engine.kernels.equations.contact_law import ContactLaw, law_force
    from vibroscope.engine.law_table import CONTACT_LAWS, damper_of

    method = TimeStepping(12000, None, STEPS, status="end", law=law)
    problem = DeckProblem(System(clearance=0.1), ETA, method, MM, periods=1, keep=1)
    fake = run_fake(deck("opensees", problem), monkeypatch, tmp_path)
    kind, _, *numbers = fake.found("uniaxialMaterial")[2]
    depth, speed, touch = 0.03, 0.7, 1.3  # without dimension; the last: closing speed at touch
    length, velocity = MM.physical("displacement", 1.0), MM.physical("velocity", 1.0)
    if law == "jankowski":  # JankowskiImpact.cpp
        stiffness, ratio, mass, gap = numbers
        spring = stiffness * (depth * length) ** 1.5
        found = spring + 2 * ratio * math.sqrt(stiffness * math.sqrt(depth * length) * mass) * speed * velocity
    else:  # Hertzdamp.cpp
        stiffness, ratio, gap, power = numbers
        found = stiffness * (depth * length) ** power * (1 + ratio * speed / touch)
    gain, by_speed = damper_of(problem.system, method)
    numbers = ContactLaw(CONTACT_LAWS.index(law), 12000.0, 1.5, 0.0, 0.0, gain, float(by_speed))
    ours = law_force(numbers, gain / touch if by_speed else gain, depth, speed)
    assert kind == ("JankowskiImpact" if law == "jankowski" else "Hertzdamp")
    assert gap == pytest.approx(-0.1 * length)
    assert found == pytest.approx(MM.physical("force", ours), rel=1e-12)


def test_periods_that_fit_into_a_table():
    usual = {code: usual_length(code, System(), ETA, 2000, None) for code in ("opensees", "abaqus", "calculix")}
    assert usual == {"opensees": (300, 20), "abaqus": (300, 20), "calculix": (50, 20)}


def test_a_deck_of_a_throw_runs_to_its_contact_and_writes_all_from_its_start():
    thrown = System(wall=True, spring1=0.0, d1=0.0, clearance=50.0, excitation=Excitation(base=0.0))
    assert usual_length("opensees", thrown, 1.0, 2000, (0.0, 1.0, 0.0, 0.0)) == (9, 9)


def test_the_rest_of_a_preload_stays_where_it_is():
    problem = problem_of("wall with preload")
    found = simulate(problem.system, ETA, problem.method, periods=1, keep=1)
    assert found.ok
    assert problem.gap <= 0.0


def test_a_deck_says_in_its_head_where_a_step_has_no_solution_in_its_code():
    """A code with the contact status of the end stops there, or cuts the step, though Newmark's run reaches its end."""
    method = Newmark(100.0, 3.68, 32)
    assert simulate(System(), 1.08, method, periods=300).ok
    for code in ("opensees", "calculix", "abaqus", "ansys"):
        head = deck(code, DeckProblem(System(), 1.08, method))
        run = simulate(System(), 1.08, TimeStepping(100.0, 3.68, 32, status="end"), periods=300)
        assert f"WARNING: with the contact status of this code {run.message.what}:" in head
        assert "WARNING" not in deck(code, DeckProblem(System(), 1.08, Newmark(2500.0, 0.0, 2000), periods=2, keep=1))
    assert "WARNING" not in deck("modelica", DeckProblem(System(), 1.08, method))
