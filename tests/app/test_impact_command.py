"""`vibroscope impact`: what a person and a script read of one contact."""

import csv
import io
import json

import numpy as np
import pytest
from vibroscope.app.commands.cli import build_parser
from vibroscope.app.commands.numbers import resolve_units
from vibroscope.engine import ExactPenalty, System, effective_restitution

from tests.app.command_line import run_command

KV = ("--mass", "1 kg", "--speed", "1 m/s", "--K", "1e6 N/m")


def answered(capsys, *words):
    status, out, err = run_command(capsys, "impact", *words, "--json")
    assert (status, err) == (0, "")
    return json.loads(out)


def test_it_says_what_was_asked_for_and_what_the_step_gives(capsys):
    status, out, err = run_command(capsys, "impact", *KV, "--restitution", "0.5", "--steps-per-contact", "5")
    assert (status, err) == (0, "")
    assert "K = 1000000 N/m, c = 430.9 N s/m, damping ratio 0.215; 1 kg at 1 m/s; step 643.4 µs, 5 in a contact" in out
    assert "You asked for 0.50; with 5 steps in a contact you get 0.23 to 0.58." in out
    assert "From 18 steps on it stays within 0.05: a step of at most 178.9" in out


def test_a_code_has_its_own_integrator_status_and_law(capsys):
    words = (*KV, "--D", "50 N s/m", "--time-step", "0.5 ms")
    own = ("--integrator", "semi-implicit-euler", "--status", "start", "--law", "cut")
    assert answered(capsys, *words, "--code", "mujoco") == answered(capsys, *words, *own) != answered(capsys, *words)
    status, _, err = run_command(capsys, "impact", *words, "--code", "mujoco", "--law", "cut")
    assert (status, "leave --law out" in err) == (2, True)


def test_the_restitution_of_the_system_stands_in_for_one_that_is_not_given(capsys, tmp_path):
    file = tmp_path / "box.toml"
    file.write_text("[physical]\nwall = true\nmass1_kg = 2\nfrequency1_Hz = 20\nclearance_mm = 2\nrestitution = 0.5\n")
    words = ("impact", "--system", str(file), "--initial=-9mm,0,0,0", "--permitted-penetration", "0.1 mm", "--json")
    status, out, err = run_command(capsys, *words)
    assert (status, err) == (0, "vibroscope: --restitution is that of --system, 0.5\n")
    assert (0, out, "") == run_command(capsys, *words, "--restitution", "0.5")


def test_a_tolerance_may_be_in_percent(capsys):
    words = (*KV, "--restitution", "0.5", "--steps-per-contact", "5", "--tolerance")
    assert answered(capsys, *words, "5 %") == answered(capsys, *words, "0.05") != answered(capsys, *words, "8 %")


def test_the_json_has_units_in_its_keys_and_follows_the_typed_units(capsys):
    found = answered(capsys, *KV, "--restitution", "0.5", "--steps-per-contact", "5")
    assert found["asked"]["damping"] == pytest.approx(430.9, abs=0.1)  # c, as an FE code has it
    assert set(found["without_step"]) == {"restitution", "penetration_m", "force_N", "time_s"}
    with_step = found["with_step"]
    assert 0.2 < with_step["restitution"]["least"] < with_step["restitution"]["mean"] < 0.5
    assert with_step["steps"] == {"least": 5, "greatest": 6}
    assert with_step["blown_up"] == with_step["without_solution"] == 0.0
    assert found["largest_step"]["steps_per_contact"] == pytest.approx(18, abs=0.5)
    scaled = answered(
        capsys, "--mass", "1000 g", "--speed", "1000 mm/s", "--K", "1 kN/mm", "--D", "430.9 N s/m", "--time-step",
        f"{1e3 * found['asked']['time_step_s']} ms",
    )  # fmt: skip
    assert scaled["with_step"]["restitution"]["least"] == pytest.approx(with_step["restitution"]["least"], abs=1e-4)


def test_where_no_touch_has_a_result_there_are_no_numbers(capsys):
    words = (*KV, "--D", "10 N s/m", "--steps-per-contact", "0.5")
    out = run_command(capsys, "impact", *words)[1]
    assert "restitution none\n" in out
    assert "nan" not in out
    assert answered(capsys, *words)["with_step"]["restitution"] == dict.fromkeys(("least", "mean", "greatest"))


def test_it_says_what_the_damper_of_the_laws_authors_would_give(capsys):
    words = ("impact", "--K", "1e6", "--speed", "3 m/s")
    out = run_command(capsys, *words, "--law", "hunt-crossley", "--restitution", "0.6")[1]
    assert "restitution 0.6," in out
    given = effective_restitution(System(restitution=0.6), ExactPenalty(1e6, None, "hunt-crossley"), 3.0)
    assert f"by the formula of the law's authors, its damper gives {given:.2f}" in out
    for more in (
        ("--law", "constant-restitution", "--restitution", "0.6"),
        ("--law", "flores", "--D", "1e5"),
        ("--restitution", "0.6"),
    ):
        assert "authors" not in run_command(capsys, *words, *more)[1]
    assert "With --restitution its damper is the one" in " ".join(run_command(capsys, "impact", "--help")[1].split())


def test_it_says_what_steps_in_a_contact_count_where_the_contact_lasts_longer(capsys):
    words = ("--mass", "2 kg", "--speed", "3 m/s", "--restitution", "0.6", "--time-step", "20 us")
    hertz = (*words, "--permitted-force", "5 kN", "--law", "hunt-crossley")
    found = answered(capsys, *hertz)
    lasts = found["without_step"]["time_s"] / 20e-6
    assert lasts > found["asked"]["steps_per_contact"] + 10
    out = " ".join(run_command(capsys, "impact", *hertz)[1].split())
    assert f"half a cycle of its spring alone; without a step the contact lasts {lasts:.0f} steps" in out
    assert "half a cycle" not in run_command(capsys, "impact", *words, "--K", "1e6")[1]
    pressed = run_command(capsys, "impact", *words, "--K", "1e6", "--force", "100 N")[1]
    assert "half a cycle of its spring with the damper" in pressed


def test_without_a_step_it_gives_what_the_law_gives(capsys):
    found = answered(capsys, "--K", "1e6 N/m^1.5", "--D", "1e5", "--law", "hunt-crossley")
    assert found["with_step"] is None
    assert found["largest_step"] is None
    assert 0 < found["without_step"]["restitution"] < 1


@pytest.mark.parametrize("value", ["nan", "0", "-1"])
def test_a_stiffness_out_of_range_is_named_before_a_damper_that_is_missing(capsys, value):
    status, _, err = run_command(capsys, "impact", "--K", value)
    assert (status, f"K = {float(value)} is outside [1e-06, 1e+12]" in err) == (2, True)
    assert "the contact has no damper" in run_command(capsys, "impact", "--K", "1e6")[2]


def test_steel_on_steel_has_a_stiffness_and_a_damper_in_units_of_its_law(capsys):
    words = ("--law", "hunt-crossley", "--restitution", "0.6", "--speed", "0.3 m/s", "--time-step", "0.1 us")
    for K in (9e11, 3.051e12):
        found = answered(capsys, "--K", f"{K}", *words)
        assert found["without_step"]["restitution"] == pytest.approx(0.6)
        assert found["asked"]["damping"] > 2e12
    err = run_command(capsys, "impact", "--K", "3e12", "--restitution", "0.6")[2]
    assert "K = 3000000000000.0 is outside [1e-06, 1e+12]" in err


def test_all_integrators_and_statuses_stand_in_a_table(capsys):
    words = (*KV, "--restitution", "0.5", "--steps-per-contact", "10", "--law", "cut", "--tolerance", "0.3")
    rows = answered(capsys, *words, "--schemes")["schemes"]
    named = {(row["integrator"], row["status"]): row for row in rows}
    assert len(named) == len(rows) > 20
    assert list(named["moreau-jean", None]["restitution"].values()) == pytest.approx([0.5] * 3)
    assert ("central-difference", "end") not in named
    assert named["newmark", "located"]["steps_per_contact"] < named["newmark", "start"]["steps_per_contact"]


def test_the_rows_of_the_table_come_one_by_one():
    words = ["impact", "--mass", "2 kg", "--speed", "3 m/s", "--K", "1e6", "--D", "400 N s/m", "--time-step", "1 ms"]
    options = build_parser(["impact"]).parse_args([*words, "--force", "2 kN", "--schemes"])
    resolve_units(options)
    lines = iter(options.run(options).lines)
    first = next(line for line in lines if str(line).startswith("newmark"))
    assert first.split() == ["newmark", "start", "0.000", "0.000", "0.000", "-", "39.2"]


def test_bands_are_csv(capsys):
    out = run_command(capsys, "impact", *KV, "--restitution", "0.5", "--over", "steps-per-contact=5:50")[1]
    rows = list(csv.DictReader(io.StringIO(out)))
    assert [float(rows[0]["steps_per_contact"]), float(rows[-1]["steps_per_contact"])] == pytest.approx([5, 50])
    widths = [float(row["restitution_greatest"]) - float(row["restitution_least"]) for row in rows]
    assert widths[0] > 0.3 > 0.05 > widths[-1]
    words = (*KV, "--D", "40 N s/m", "--steps-per-contact", "8", "--over", "speed")
    rows = list(csv.DictReader(io.StringIO(run_command(capsys, "impact", *words)[1])))
    assert len({row["restitution_mean"] for row in rows}) == 1  # of a linear law
    assert float(rows[-1]["force_N"]) == pytest.approx(100 * float(rows[0]["force_N"]), rel=1e-6)


def test_a_band_is_of_the_stiffness_that_a_permitted_penetration_gives(capsys):
    words = ("--mass", "20 g", "--restitution", "0.7", "--over", "steps-per-contact=50:60")
    out = run_command(capsys, "impact", "--permitted-penetration", "0.1 mm", *words)[1]
    deepest = [float(line.split(",")[4]) for line in out.splitlines()[1:]]
    np.testing.assert_allclose(deepest, 1e-4, rtol=0.05)


def test_forces_over_time_are_csv(capsys):
    words = (*KV, "--restitution", "0.5", "--steps-per-contact", "5", "--over", "time")
    rows = list(csv.DictReader(io.StringIO(run_command(capsys, "impact", *words)[1])))
    courses = {name: [row for row in rows if row["touch"] == name] for name in ("best", "worst", "exact")}
    assert float(courses["worst"][0]["restitution"]) == pytest.approx(0.234, abs=1e-3)
    assert courses["exact"][0]["instant"] == ""
    assert max(float(row["force_N"]) for row in courses["exact"]) == pytest.approx(816.4, abs=0.1)
    for name, course in courses.items():
        times, forces = ([float(row[key]) for row in course] for key in ("time_s", "force_N"))
        e = float(course[0]["restitution"])
        wanted = pytest.approx(1 + e, rel=1e-6 if name != "exact" else 1e-3)  # 1 kg at 1 m/s
        assert np.trapezoid(forces, times) == wanted


def test_k_follows_from_what_is_permitted(capsys):
    words = ("--mass", "20 g", "--restitution", "0.7", "--steps-per-contact", "30")
    found = answered(capsys, *words, "--permitted-penetration", "0.1 mm")
    assert found["without_step"]["penetration_m"] == pytest.approx(1e-4, rel=1e-6)
    found = answered(capsys, *words, "--permitted-force", "1 kN")
    assert found["without_step"]["force_N"] == pytest.approx(1e3, rel=1e-6)
    assert found["without_step"]["restitution"] == pytest.approx(0.7)


def test_k_follows_from_two_materials(capsys):
    words = ("--radius", "10 mm", "--law", "hunt-crossley", "--restitution", "0.7")
    found = answered(capsys, "--materials", "steel,pla", *words)
    wanted = 4 / 3 / (0.91 / 210e9 + (1 - 0.36**2) / 3.5e9) * 0.01**0.5
    assert found["asked"]["stiffness"] == pytest.approx(wanted)
    assert found["asked"]["damping_ratio"] is None


def test_bounds_stand_around_k_and_the_damper(capsys):
    words = (*KV, "--restitution", "0.7", "--steps-per-contact", "4", "--integrator", "central-difference", "--bounds")
    found = answered(capsys, *words)
    ends = found["bounds"]["stiffness"]["no_energy_gained"]
    assert ends["least"] is None
    assert ends["greatest"] < found["bounds"]["stiffness"]["stable"]["greatest"]
    damper = found["bounds"]["damping"]["no_energy_gained"]
    assert damper["least"] < found["asked"]["damping"] < damper["greatest"]
    text = run_command(capsys, "impact", *words)[1]
    assert "K, this step      stable in contact to " in text
    assert "gains no energy from " in text


PART = """[physical]
mass1_kg = 25.0
stiffness1_N_per_m = 98696.0
damping1_ratio = 0.07
mass2_kg = 12.0
stiffness2_N_per_m = 198696.0
damping2_ratio = 0.05
clearance_mm = 0.0
restitution = 0.5
base_acceleration_m_per_s2 = 1.0
frequency_Hz = 8.0
"""


@pytest.fixture
def part(tmp_path):
    """A system in physical units whose bodies meet with many speeds."""
    file = tmp_path / "part.toml"
    file.write_text(PART)
    return str(file)


def test_it_answers_for_all_closing_speeds_of_a_motion(capsys, part):
    words = ("--system", part, "--K", "1e6 N/m^1.5", "--law", "hunt-crossley", "--restitution", "0.6")
    found = answered(capsys, *words, "--time-step", "1 ms")
    motion = found["motion"]
    counts = [each["count"] for each in motion["speeds"]]
    assert sum(counts) > 100
    assert len(counts) > 3
    assert found["asked"]["mass_kg"] == pytest.approx(25 * 12 / 37)
    speeds = motion["speed_m_per_s"]
    assert speeds["least"] < found["asked"]["speed_m_per_s"] < speeds["greatest"]
    e = motion["restitution"]
    assert e["least"] < 0.58 < found["with_step"]["restitution"]["mean"] < 0.62 < e["greatest"]
    text = run_command(capsys, "impact", *words, "--time-step", "1 ms")[1]
    assert f"motion            {sum(counts)} impacts with closing speeds from " in text
    assert "restitution 0." in text.partition("closing speeds")[2]


def test_an_impact_law_gives_its_restitution_with_any_step(capsys):
    words = ("--moreau-jean", "0.5", "--restitution", "0.5", "--time-step", "1 ms", "--speed", "2 m/s")
    text = run_command(capsys, "impact", *words)[1]
    assert "impact law, theta = 0.5; 1 kg at 2 m/s; step 1 ms" in text
    assert "impulse 3 N s" in text
    assert "penetration 1.5 mm, 0.75 of a step of flight" in text
    found = answered(capsys, *words)
    assert found["with_step"]["impulse_N_s"] == pytest.approx(3.0)
    assert found["with_step"]["restitution"]["least"] == pytest.approx(0.5)
