"""Contacts translated from code to code: round trips, published formulas and numbers, what is named, and refusals."""

import itertools
import json
import math
from dataclasses import replace

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from vibroscope.app.codes.catalogue import codes
from vibroscope.app.codes.contact_words import Around, Contact, Missing
from vibroscope.app.codes.translation import PHYSICAL, translate, translated_codes
from vibroscope.app.commands.cli import main
from vibroscope.engine import damping_of_restitution, restitution_of_damping

AROUND = Around(mass=2.0, lighter=3.0, step=1e-3, speed=0.7, area=1.2e-4)
FORMS = [
    (code, place)
    for code, entry in translated_codes().items()
    for place, form in enumerate(entry.contact)
    if form.writable
]


def near(numbers):
    """Equal to a number in a file, which has six digits."""
    return {n: pytest.approx(v, rel=2e-5) if isinstance(v, float) else v for n, v in numbers.items()}


def contact_of(code, words, around=AROUND):
    return translate(translated_codes()[code], words, PHYSICAL, around).contact


def words_of(found, place=0):
    return {word: float(text) for word, text in found.written[place].words.items() if " " not in text}


@pytest.mark.parametrize(("code", "place"), FORMS)
@given(size=st.floats(0.1, 10.0), ratio=st.floats(0.3, 0.9))
@settings(max_examples=10, deadline=None)
def test_words_that_are_written_are_read_as_the_same_contact(code, place, size, ratio):
    form = translated_codes()[code].contact[place]
    exponent = 2.2 if form.word_of("exponent") and form.law == "impact" else form.exponent
    stiffness = 1e6 * size
    contact = Contact(form.law, stiffness, 2 * ratio * math.sqrt(stiffness * 2.0), exponent)
    if form.law == "impact":
        contact = replace(contact, penetration=1e-4 * size)
    if form.says_restitution:
        contact = replace(contact, damping=None, restitution=ratio)
    words = form.write(contact, AROUND)
    around = replace(AROUND, speed=None) if form.formulas == "bilinear" else AROUND
    assert vars(form.read(words, around)) == near(vars(contact))


@pytest.mark.parametrize("code", ["gazebo", "bullet", "code-aster", "newton", "mujoco", "calculix", "comsol"])
def test_stiffness_and_damper_come_back_from_any_code_with_one_of_the_same_kind(code):
    there = translate(PHYSICAL, {"K": "3e5 N/m", "c": "40 N s/m"}, translated_codes()[code], AROUND)
    back = translate(translated_codes()[code], there.written[0].words, PHYSICAL, AROUND)
    assert words_of(back) == pytest.approx({"K": 3e5, "c": 40.0}, rel=1e-5)


# --- what the sources print -------------------------------------------------------------------------------------------


def test_mujoco_direct_and_positive_words_are_those_of_its_documentation():
    """A damping ratio of 1 is damping = 2 √stiffness; K and c are these times the mass."""
    positive, direct = contact_of("mujoco", {"solref": "0.02 1"}), contact_of("mujoco", {"solref": "-2500 -100"})
    assert (positive.stiffness, positive.damping) == pytest.approx((2 * 2500.0, 2 * 100.0))
    assert vars(direct) == near(vars(positive))
    assert direct.damping / 2 == pytest.approx(2 * math.sqrt(direct.stiffness / 2))


def test_mujoco_keeps_its_time_constant_at_two_steps():
    assert contact_of("mujoco", {"solref": "0.001 1"}).damping == pytest.approx(2 * 2 / 0.002)


def test_newton_says_what_mujoco_says_by_default():
    """Its defaults 2500 and 100 are MuJoCo's time constant of 0.02 s and damping ratio 1, for a mass of 1 kg."""
    found = translate(translated_codes()["newton"], {}, translated_codes()["mujoco"], Around(mass=1.0))
    assert found.written[0].words == {"solref": "-2500 -100"}


def test_erp_and_cfm_are_those_of_the_manual():
    """Erp = h kp/(h kp + kd), cfm = 1/(h kp + kd), and kp = erp/(cfm h), kd = (1 - erp)/cfm."""
    found = translate(translated_codes()["gazebo"], {"kp": "1e5", "kd": "25"}, translated_codes()["gazebo"], AROUND)
    assert words_of(found, 1) == pytest.approx({"soft_erp": 0.8, "soft_cfm": 1 / 125}, rel=1e-5)
    back = contact_of("gazebo", {"soft_erp": "0.8", "soft_cfm": "0.008"})
    assert (back.stiffness, back.damping) == pytest.approx((1e5, 25.0))


def test_drake_dissipates_in_proportion_and_takes_an_allowance():
    found = contact_of("drake", {"point_contact_stiffness": "1e6 N/m", "hunt_crossley_dissipation": "0.5"})
    assert (found.law, found.stiffness, found.damping) == ("hunt-crossley", 1e6, 5e5)
    allowed = contact_of("drake", {"penetration_allowance": "1 mm"})
    assert allowed.stiffness == pytest.approx(2 * 9.81 / 1e-3)
    scale = math.sqrt(2.0 / allowed.stiffness)
    assert allowed.damping / allowed.stiffness == pytest.approx(scale / 1e-3)  # of critical damping at the allowance


def test_adams_has_its_defaults_in_millimetres():
    found = contact_of("adams", {})
    assert found.stiffness == pytest.approx(1e5 * 1e3**2.2)
    assert (found.damping, found.exponent, found.penetration) == (1e4, 2.2, pytest.approx(1e-5))


def test_adams_gives_its_small_part_a_stiffness():
    """Of 4e-6 kg and 1 mm: 5 M g = K 0.001^2.2 with forces in N and lengths in mm."""
    stiffness = 5 * 4e-6 * 9.80665 / 0.001**2.2
    found = contact_of("adams", {"k": f"{stiffness!r} N/mm", "c": "0"})
    assert found.stiffness * 1e-6**2.2 == pytest.approx(5 * 4e-6 * 9.80665)


def test_ls_dyna_takes_the_larger_of_two_stiffnesses():
    of_step = 0.1 * 3.0 / 1e-6
    assert contact_of("ls-dyna-explicit", {"SOFT": "1", "VDC": "20"}).stiffness == pytest.approx(of_step)
    stiff = contact_of("ls-dyna-explicit", {"SOFT": "1", "k0": "1e7 N/m", "VDC": "20"})
    assert stiff.stiffness == pytest.approx(0.1 * 1e7)


def test_ls_dyna_has_the_stiffness_of_its_elements_unless_soft_is_1():
    """By default SOFT = 0: k = SLSFAC SFS k0, and neither SOFSCL nor the step plays a part."""
    around = Around(mass=0.5, step=1e-5)
    for more in ({}, {"SOFT": "0"}, {"SOFT": "0", "SOFSCL": "0.3"}):
        found = contact_of("ls-dyna-explicit", {"k0": "1000 N/mm", "VDC": "20"} | more, around)
        assert found.stiffness == pytest.approx(1e5)
        assert found.damping == pytest.approx(0.2 * 2 * math.sqrt(1e5 * 0.5))
    assert contact_of("ls-dyna-explicit", {"k0": "1000 N/mm", "SOFT": "1"}, around).stiffness == pytest.approx(5e8)
    there = translate(PHYSICAL, {"K": "3e5 N/m", "c": "40 N s/m"}, codes()["ls-dyna-explicit"], around)
    back = translate(codes()["ls-dyna-explicit"], there.written[0].words, PHYSICAL, around)
    assert there.written[0].line.startswith("SOFT = 1 and SOFSCL = ")
    assert words_of(back) == pytest.approx({"K": 3e5, "c": 40.0}, rel=1e-5)


def test_abaqus_explicit_has_a_fraction_of_critical_damping_by_default():
    found = contact_of("abaqus-explicit", {"overclosure": "1e9"})
    assert found.stiffness == pytest.approx(1.2e5)
    assert found.damping == pytest.approx(0.03 * 2 * math.sqrt(1.2e5 * 2.0))
    for damping in (0.0, 1e5):
        own = contact_of("abaqus-explicit", {"overclosure": "1e9", "damping": f"{damping}"})
        assert own.damping == pytest.approx(damping * 1.2e-4)


@pytest.mark.parametrize(
    "text", ["1000 N/mm³", "1000 N/mm^3", "1000 MPa/mm", "1000 N/mm3", "1e6 MPa/m", "1e12 N/m³", "1e12"]
)
def test_numbers_per_area_take_units(text):
    words = {"overclosure": text, "damping": "2e-4 N s/mm^3"}
    found = contact_of("abaqus-standard", words)
    assert (found.stiffness, found.damping) == pytest.approx((1e12 * 1.2e-4, 2e5 * 1.2e-4))
    comsol = contact_of("comsol", {"E_char": "200 GPa", "hmin": "1 mm"})
    assert comsol.stiffness == pytest.approx(2e11 / 1e-3 * 1.2e-4)


@pytest.mark.parametrize(("slave", "master"), [(3.0, 6.0), (6.0, 3.0), (4.0, 4.0), (1.0, 1e12)])
def test_ls_dyna_has_the_critical_damping_of_its_lighter_node(slave, master):
    """2mω with m = min(mslave, mmaster), ω = √(k(mslave + mmaster)/(mmaster mslave)); SOFT = 1 has the same m."""
    around = Around(mass=slave * master / (slave + master), lighter=min(slave, master), step=1e-3)
    found = contact_of("ls-dyna-explicit", {"k0": "1e7 N/m", "VDC": "20"}, around)
    omega = math.sqrt(1e6 * (slave + master) / (master * slave))
    assert found.damping == pytest.approx(0.2 * 2 * min(slave, master) * omega)
    soft = contact_of("ls-dyna-explicit", {"SOFT": "1"}, around)
    assert soft.stiffness == pytest.approx(0.1 * min(slave, master) / 1e-6)


def test_without_the_lighter_mass_a_body_meets_a_wall_and_a_wrong_one_is_refused():
    words = {"SOFT": "1", "VDC": "20"}
    wall, both = (contact_of("ls-dyna-explicit", words, Around(2.0, each, 1e-3)) for each in (None, 2.0))
    assert vars(wall) == vars(both)
    for mass in (1.9, 4.1):
        with pytest.raises(ValueError, match="one to two times the reduced mass"):
            contact_of("ls-dyna-explicit", words, replace(AROUND, lighter=mass))


def test_impact_material_is_made_as_the_wiki_says():
    """K1 = Keff + E/(a δm²), K2 = Keff - E/((1 - a) δm²), E = kh δm^2.5 (1 - e²)/2.5, δy = a δm with a = 0.1."""
    stiffness, e, deepest = 3e8, 0.65, 2e-3
    mean, lost = stiffness * math.sqrt(deepest), stiffness * deepest**2.5 * (1 - e**2) / 2.5
    words = {
        "K1": repr(mean + lost / (0.1 * deepest**2)),
        "K2": repr(mean - lost / (0.9 * deepest**2)),
        "dy": repr(0.1 * deepest),
    }
    form = codes()["opensees"].contact[1]
    found = form.read(words, Around())
    assert (found.stiffness, found.restitution) == pytest.approx((stiffness, e))
    assert form.read(words | {"dy": f"-{words['dy']}"}, Around()) == found  # as its input has it


def test_comsol_has_the_modulus_over_the_smallest_element():
    found = contact_of("comsol", {"E_char": "2e11", "hmin": "1 mm", "tau": "1 us"})
    assert found.stiffness == pytest.approx(2e11 / 1e-3 * 1.2e-4)
    assert found.damping == pytest.approx(1e-6 * found.stiffness)


def test_the_damper_of_comsol_acts_only_while_the_overclosure_is_increasing():
    """All energy of its spring at the deepest penetration comes back: e = ω δₘ/v₀, of a damped quarter of a cycle."""
    words = {"pn": "1e10", "tau": "0.5 ms"}
    found = translate(codes()["comsol"], words, PHYSICAL, AROUND)
    omega = math.sqrt(found.contact.stiffness / 2.0)
    ratio = 0.5 * 0.5e-3 * omega
    damped = math.sqrt(1 - ratio**2)
    assert found.restitution == pytest.approx(math.exp(-ratio * math.acos(ratio) / damped))


# --- another law ------------------------------------------------------------------------------------------------------


def test_another_law_keeps_restitution_and_penetration_at_the_closing_speed():
    found = translate(codes()["adams"], {"c": "1 Ns/mm"}, codes()["drake"], AROUND)
    there = found.written[0].contact
    e = restitution_of_damping(
        "hunt-crossley", 0.5 * there.damping, there.stiffness, mass=2.0, closing_speed=0.7, exponent=1
    )
    assert e == pytest.approx(found.restitution, rel=1e-6)
    deepest = (3.2 * 2.0 * 0.7**2 / (2 * found.contact.stiffness)) ** (1 / 3.2)
    assert 0.5 * there.stiffness * deepest**2 == pytest.approx(0.5 * 2.0 * 0.7**2)
    assert any("without dampers K gives the same deepest penetration" in text for text in found.written[0].changed)


def test_a_wanted_restitution_gives_the_damper_of_the_law():
    found = translate(PHYSICAL, {"K": "1e6 N/m", "e": "0.75"}, codes()["mujoco"], Around(mass=1.0))
    damping = -float(found.written[0].words["solref"].split()[1])
    assert damping == pytest.approx(2 * damping_of_restitution("cut", 0.75, 1e6), rel=1e-5)
    assert found.written[0].restitution == pytest.approx(0.75)


def test_the_same_restitution_can_be_asked_for_where_the_damper_could_stay():
    words = {"K": "1e6", "c": "500"}
    kept = translate(PHYSICAL, words, codes()["mujoco"], Around(mass=1.0))
    assert kept.written[0].restitution > kept.restitution
    assert any("in place of" in text for text in kept.written[0].changed)
    same = translate(PHYSICAL, words, codes()["mujoco"], Around(mass=1.0), "restitution")
    assert same.written[0].restitution == pytest.approx(kept.restitution)


def test_impact_material_does_not_give_the_restitution_that_its_formulas_are_for():
    found = translate(PHYSICAL, {"K": "1e5", "e": "0.67"}, codes()["opensees"], Around(mass=1.0, speed=1.0))
    made = found.written[1]
    assert made.restitution > 0.75
    assert any("it gives" in text for text in made.changed)


def test_impact_material_can_be_given_the_restitution_that_is_asked_for():
    around = Around(mass=1.0, speed=1.0)
    made = translate(PHYSICAL, {"K": "1e5", "e": "0.67"}, codes()["opensees"], around, "restitution").written[1]
    assert made.restitution == pytest.approx(0.67, abs=1e-5)
    back = translate(codes()["opensees"], made.words, PHYSICAL, around)  # its words alone say so, too
    assert back.restitution == pytest.approx(0.67, abs=1e-5)
    assert any("its formulas are for the restitution 0.43" in text for text in made.changed)
    least = translate(PHYSICAL, {"K": "1e5", "e": "0.3"}, codes()["opensees"], around, "restitution").written[1]
    assert any("its formulas give no restitution below 0.605" in text for text in least.changed)


def test_impact_material_that_stays_below_its_bend_is_its_first_line():
    words = {"K1": "1e8", "K2": "5e7", "dy": "1 mm"}  # 1 kg at 1 m/s comes to 0.1 mm
    found = translate(codes()["opensees"], words, PHYSICAL, Around(mass=1.0, speed=1.0))
    assert found.restitution == 1.0
    assert float(found.written[0].words["K"]) == pytest.approx(1e8)


def test_what_the_other_code_cannot_say_is_named():
    found = translate(codes()["mujoco"], {}, codes()["adams"], Around(mass=1.0))
    assert any("solimp" in text and text.startswith("MuJoCo alone") for text in found.unsaid)
    assert any("friction" in text and text.startswith("Adams alone") for text in found.unsaid)
    assert any("0.01 mm" in text for text in found.written[0].changed)
    assert translate(codes()["gazebo"], {}, codes()["gazebo"], Around()).left_out  # erp and cfm without a step


# --- refusals and the command -----------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("code", "words", "said"),
    [
        ("adams", {"k": "1 kg"}, "N/mm"),
        ("adams", {"e": "0.5"}, "from 1 to 10"),
        ("adams", {"kp": "1"}, "give k e c d"),
        ("mujoco", {"solref": "1 -2"}, "pair of one sign"),
        ("mujoco", {"solref": "soft"}, "list of numbers"),
        ("gazebo", {"soft_erp": "1.5", "soft_cfm": "1"}, "to 1"),
        ("gazebo", {"soft_erp": "0.2"}, "soft_cfm is missing"),
        ("opensees", {"K1": "1e6", "K2": "2e6", "dy": "1 mm"}, "restitution of 0 to 1"),
        ("code-aster", {"RIGI_NOR": "0", "AMOR_NOR": "1"}, "RIGI_NOR"),
        ("ls-dyna-explicit", {}, "k0 is missing"),
        ("ls-dyna-explicit", {"k0": "1e6", "SOFSCL": "0.2"}, "SOFT is missing"),
        ("ls-dyna-explicit", {"k0": "1e6", "SOFT": "2"}, "give SOFT=0 or SOFT=1"),
        ("abaqus-standard", {"overclosure": "1 N/mm", "damping": "0"}, "N/mm³"),
    ],
)
def test_a_word_that_is_wrong_is_refused_with_what_to_do(code, words, said):
    with pytest.raises(ValueError, match=said):
        translate(codes()[code], words, codes()["bullet"], AROUND)


def test_a_number_that_is_needed_is_asked_for():
    with pytest.raises(Missing, match="--mass"):
        contact_of("mujoco", {}, Around())
    with pytest.raises(Missing, match="--speed"):
        translate(codes()["adams"], {}, codes()["mujoco"], Around(mass=1.0))


def run(capsys, *words):
    status = main(["codes", "translate", *words])
    return status, capsys.readouterr()


def test_the_command_prints_both_and_the_middle(capsys):
    asked = ["--from", "mujoco", "solref=-1000 -10", "--mass", "2 kg", "--to", "adams"]
    status, printed = run(capsys, *asked)
    assert status == 0
    assert "K = 2000 N/m, c = 20 N·s/m" in printed.out
    assert "IMPACT(<distance>, <speed>, <free length>, 2, 1, 0.02, 0.01)" in printed.out
    found = json.loads(run(capsys, *asked, "--json")[1].out)
    assert found["contact"]["stiffness"] == 2000.0
    assert found["written"][0]["units"] == {"k": "N/mm", "c": "N·s/mm", "d": "mm"}


@pytest.mark.parametrize(
    ("key", "said"),
    [
        ("ansys", "the words of Ansys Mechanical APDL for a contact are not known; give one of physical"),
        ("ode", "did you mean gazebo? give one of physical"),
        ("Mujuco", "did you mean mujoco?"),
        ("lsdyna", "did you mean ls-dyna-explicit?"),
        ("xyz", "there is no such code; give one of physical"),
        ("ls-dyna-implicit", "are not known; did you mean ls-dyna-explicit?"),
    ],
)
def test_a_code_whose_words_are_not_known_is_refused_with_the_name_that_is_near(capsys, key, said):
    for words in (["--from", key, "--to", "adams"], ["--from", "adams", "--to", key]):
        status, printed = run(capsys, *words)
        assert status == 2
        assert said in printed.err


@pytest.mark.parametrize("code", translated_codes(write=True))
def test_what_is_written_is_read_again_or_named(code):
    """Of contacts without a damper, and with one that lets nothing rebound."""
    target = translated_codes()[code]
    for numbers in itertools.product(("1e-3", "1e6", "1e12"), ("0", "1e-9", "10", "1e4", "1e7")):
        for words in words_or_none(dict(zip("Kc", numbers, strict=True)), target):
            translate(target, words, PHYSICAL, AROUND)


def words_or_none(given, target):
    try:
        return [each.words for each in translate(PHYSICAL, given, target, AROUND).written]
    except ValueError:  # says which number is missing or out of range
        return []


def test_a_contact_that_does_not_rebound_is_not_written_with_a_restitution(capsys):
    status, printed = run(capsys, "--from", "gazebo", "kp=1e6", "kd=1e7", "--to", "physical", "--mass", "1 kg")
    assert status == 0
    assert "K = 1000000, c = 1e7" in printed.out
    assert "e =" not in printed.out
    assert "K and e: this contact is beyond these words: e must be a number from" in " ".join(printed.out.split())


def test_codes_alone_shows_them(capsys):
    for words in (["codes", "calculix"], ["codes", "show", "calculix"]):
        assert main(words) == 0
        assert "CalculiX (calculix)" in capsys.readouterr().out
