"""The system entered field by field in physical units: what is typed comes true, what is not typed stays."""

import math

import pytest
from hypothesis import given, reject
from hypothesis import strategies as st
from vibroscope.app.explorer.drawing import drawing_in_words
from vibroscope.app.explorer.errors import Refused
from vibroscope.app.explorer.physical_fields import (
    PHYSICAL_FIELDS,
    entered,
    is_shown,
    physical_bounds,
    physical_numbers,
    values_of_system,
)
from vibroscope.app.explorer.reading import read_setting
from vibroscope.app.explorer.state import Setting
from vibroscope.app.explorer.typed import plain_texts
from vibroscope.engine import Units, system_of_physical
from vibroscope.engine.system_file import parse_system, physical_text

TWO = Setting()._replace(bodies="two", joint_damping="derived", units="si")
WALL = Setting()._replace(bodies="wall", coordinate="xi1", units="si")


def enter(setting, **typed):
    """The setting after each number was typed in turn, as the browser sends it."""
    for name, text in typed.items():
        texts = {name: {"typed": text}}
        setting = read_setting(entered(plain_texts(texts, setting), setting), setting)
    return setting


# an FE analyst's system, by hand
ANALYST = {
    "mass1_kg": "2",
    "frequency1_Hz": "15",
    "mass2_kg": "1.2",
    "frequency2_Hz": "32",
    "damping1_ratio": "1 %",
    "damping2_ratio": "0.01",
    "restitution": "0.7",
    "base_amplitude_mm": "0.5",
    "clearance_mm": "250 µm",
    "eta": "28 Hz",
}


@pytest.mark.parametrize(
    ("numbers", "clearance"),
    [({}, 0.5), ({"mass1_kg": "2.4", "frequency1_Hz": "12", "mass2_kg": "0.9", "clearance_mm": "0.2 mm"}, 0.4)],
)
def test_a_link_has_no_digits_that_conversions_add(numbers, clearance):
    base = {"base_amplitude_mm": "0.5"}  # last, in which lengths are counted
    setting = enter(
        TWO, **{name: text for name, text in (ANALYST | numbers | base).items() if name not in base}, **base
    )
    assert setting.clearance == clearance
    assert enter(setting, frequency1_Hz="13", clearance_mm="0.3").clearance == 0.6


def test_a_system_of_ones_own_is_entered_as_on_a_data_sheet():
    setting = enter(TWO, **ANALYST)
    system = setting.system
    assert (system.mu, system.d1, system.d2, system.restitution, system.d3) == (0.6, 0.01, 0.01, 0.7, None)
    assert system.kappa == pytest.approx(32 / 15, rel=1e-14)
    assert system.clearance == pytest.approx(0.5, rel=1e-14)  # of 0.5 mm
    assert setting.eta == pytest.approx(28 / 15, rel=1e-14)
    assert (setting.m1, setting.amplitude) == (2.0, 0.5)
    assert setting.omega1 == pytest.approx(2 * math.pi * 15, rel=1e-14)
    numbers = physical_numbers(setting)
    assert numbers["stiffness1_N_per_m"] == pytest.approx(2 * (2 * math.pi * 15) ** 2, rel=1e-12)
    assert numbers["damping2_Ns_per_m"] == pytest.approx(2 * 0.01 * 1.2 * 2 * math.pi * 32, rel=1e-12)
    assert numbers["base_acceleration_m_per_s2"] == pytest.approx(5e-4 * (2 * math.pi * 28) ** 2, rel=1e-12)


@pytest.mark.parametrize("setting", [TWO, WALL, enter(TWO, **ANALYST), Setting(units="si")], ids=lambda s: s.bodies)
def test_a_number_that_is_typed_as_it_is_shown_changes_nothing(setting):
    for name, value in physical_numbers(setting).items():
        if name not in ("length_mm", "joint_damping_ratio") and is_shown(name, setting):
            assert entered({name: repr(value)}, setting) == {}, name


@st.composite
def typed_numbers(draw):
    """A field of two bodies, and a number that it may hold."""
    name = draw(st.sampled_from([name for name in PHYSICAL_FIELDS if name not in ("length_mm", "joint_damping_ratio")]))
    low, high = physical_bounds(name)
    return name, draw(st.floats(max(low, 1e-3), min(high, 1e3)))


@given(typed_numbers())
def test_what_is_typed_is_what_the_field_shows_then(typed):
    (name, value), setting = typed, enter(TWO, **ANALYST)
    try:
        after = enter(setting, **{name: repr(value)})
    except Refused:  # such as a damper above critical damping, or a frequency out of range
        reject()
    assert physical_numbers(after)[name] == pytest.approx(value, rel=1e-11)
    if name not in ("mass1_kg", "stiffness1_N_per_m", "frequency1_Hz"):
        for other in ("mass1_kg", "stiffness1_N_per_m", "clearance_mm"):
            if other != name:
                assert physical_numbers(after)[other] == pytest.approx(physical_numbers(setting)[other], rel=1e-11)


def test_a_change_of_mass_keeps_the_form_that_is_shown():
    setting = enter(TWO, **ANALYST)
    spring = enter(setting._replace(spring1_form="stiffness"), mass1_kg="4")
    assert physical_numbers(spring)["frequency1_Hz"] == pytest.approx(15 / math.sqrt(2), rel=1e-9)
    frequency = enter(setting, mass1_kg="4")  # as it was given
    assert physical_numbers(frequency)["frequency1_Hz"] == pytest.approx(15, rel=1e-9)


def test_contact_and_start_keep_their_physical_values_while_the_slider_reaches_them():
    setting = enter(TWO, **ANALYST)._replace(start_xi2=2.0)
    stiffness = setting.K * setting.scale.factor("stiffness")
    after = enter(setting, frequency1_Hz="16", base_amplitude_mm="1")
    assert after.K * after.scale.factor("stiffness") == pytest.approx(stiffness, rel=1e-10)
    assert after.start_xi2 == pytest.approx(1.0)
    assert enter(setting, frequency1_Hz="15000").K == setting.K  # else it would be out of reach


@pytest.mark.parametrize(
    ("name", "text", "words"),
    [
        ("mass1_kg", "0", r"m₁ must be a number from 1e-15 to 1e12 kg, not “0”"),
        ("mass1_kg", "-2", r"m₁ must be"),
        ("clearance_mm", "1e308", r"g₀ must be a number from -1e15 to 1e15 mm"),
        ("stiffness1_N_per_m", "2 kg", r"k₁ must be .* typed in N/m, kN/m, MN/m, N/mm, kN/mm, not “2 kg”"),
        ("damping1_ratio", "1", r"d₁ must be a number from 0 to below 1, not “1”"),
        ("damping1_Ns_per_m", "1e6", r"c₁ must be from 0 to below 376.991 N·s/m so that the body can swing; 1e6 was"),
        ("mass2_kg", "1e12", r"m₂ must be from 2e-9 to 2e9 kg beside m₁ = 2; 1e12 was given"),
        ("stiffness2_N_per_m", "1e12", r"k₂ must be from 0.0106592 to 1.06592e10 N/m beside body 1 at 15 Hz; 1e12 was"),
        ("frequency1_Hz", "1e12", r"f₁ must be from 1.59155e-7 to 1.59155e8 Hz beside m₁ = 2; 1e12 was"),
    ],
)
def test_a_bad_number_is_refused_in_one_line_beside_its_field(name, text, words):
    with pytest.raises(Refused, match=words) as refused:
        enter(enter(TWO, **ANALYST), **{name: text})
    assert refused.value.name == name
    assert "\n" not in str(refused.value)


@pytest.mark.parametrize("forged", ["", "nan", "x", 3.0, None, {"typed": "1", "more": "2"}])
def test_forged_numbers_are_refused(forged):
    with pytest.raises(Refused):
        read_setting(entered(plain_texts({"mass1_kg": forged}, TWO), TWO), TWO)


@pytest.mark.parametrize(("mass", "spring"), [("5e4", "3e9"), ("1e-6", "1e-3")])
def test_a_system_of_any_size_can_be_entered_body_after_body(mass, spring):
    setting = enter(TWO, mass1_kg=mass, stiffness1_N_per_m=spring, mass2_kg=mass, stiffness2_N_per_m=spring)
    assert setting.system.mu == pytest.approx(1)
    assert setting.system.kappa == pytest.approx(1)
    assert setting.omega1 == pytest.approx(math.sqrt(float(spring) / float(mass)))


def test_a_base_at_rest_and_again_in_motion():
    setting = enter(TWO, **ANALYST)
    still = enter(setting, base_amplitude_mm="0")
    assert (still.base, still.amplitude, still.is_driven) == (0.0, 0.25, False)  # the clearance, as in a file
    forced = enter(still, force1_N="10", length_mm="2")
    assert forced.is_driven
    assert physical_numbers(forced)["clearance_mm"] == pytest.approx(0.25)
    again = enter(still, base_acceleration_m_per_s2="9.81")
    assert again.system.excitation.base_amplitude(again.eta) == pytest.approx(1.0)
    assert again.held == "acceleration"
    assert again.amplitude == pytest.approx(9810 / (2 * math.pi * 28) ** 2)


def test_a_system_that_is_typed_is_counted_in_the_length_of_its_file():
    """And so has its parting speed: it is counted in that length. A length that was typed stays."""
    sheet = {"mass1_kg": 25.0, "stiffness1_N_per_m": 98696.0, "clearance_mm": 0.5, "force1_N": 20.0, "wall": True}
    units = system_of_physical(sheet | {"restitution": 0.8, "frequency_Hz": 10.0}).units
    typed = {name: str(value) for name, value in sheet.items() if name != "wall"}
    for names in (list(typed), list(reversed(typed))):
        setting = enter(WALL, base_amplitude_mm="0")
        for name in names:
            setting = enter(setting, **{name: typed[name]})
        assert setting.amplitude == pytest.approx(units.base_amplitude, rel=1e-9)
        assert setting.system.excitation.force1 == pytest.approx(1.0)
    own = enter(enter(setting, length_mm="2"), force1_N="10")
    assert own.amplitude == 2.0


def test_another_kind_of_system_takes_over_what_the_present_one_has():
    two = read_setting(entered({"bodies": "two"}, Setting()), Setting())
    assert two.system.mass_ratio == Setting().system.mass_ratio
    assert two.system.d3 is None
    back = read_setting(entered({"bodies": "pendulums"}, two), two)
    assert back.system == Setting().system
    equal = two._replace(kappa=1.0)
    assert read_setting(entered({"bodies": "pendulums"}, equal), equal).system == Setting().system
    wall = read_setting(entered({"bodies": "wall"}, two._replace(start_xi2=1.0)), two)
    assert (wall.system.wall, wall.coordinate, wall.initial) == (True, "xi1", (0.0, 0.0, 0.0, 0.0))
    for kappa in (0.9 * wall.kappa3, 1.1 * wall.kappa3):  # which that of the joined pendulums is to exceed
        other = wall._replace(kappa=kappa)
        kept = kappa if kappa > wall.kappa3 else Setting().kappa
        assert read_setting(entered({"bodies": "pendulums"}, other), other).kappa == kept


@pytest.mark.parametrize("setting", [enter(TWO, **ANALYST), enter(WALL, mass1_kg="3", force1_N="2"), Setting()])
def test_the_values_of_a_system_describe_it_whole(setting):
    file = parse_system(physical_text(setting.system, Units(20.0, 3.0, 2.5), setting.eta).encode())
    values = values_of_system(setting.system, file.units, file.eta)
    assert Setting()._replace(**values).system == setting.system


def test_a_body_that_loses_its_spring_keeps_all_else_and_takes_one_again():
    before = enter(WALL, mass1_kg="25", frequency1_Hz="10", damping1_ratio="7 %", clearance_mm="0.5", eta="1.2")
    free = enter(before, stiffness1_N_per_m="0")
    assert (free.spring1, free.system.spring1, free.damper1_form) == (0.0, 0.0, "damper")
    for name, value in physical_numbers(before).items():
        if name not in ("stiffness1_N_per_m", "frequency1_Hz", "damping1_ratio"):
            assert physical_numbers(free)[name] == pytest.approx(value, rel=1e-13), name
    assert (free.K, free.D, free.eta, free.omega1) == (before.K, before.D, before.eta, before.omega1)
    ball = enter(free._replace(eta=1.7), constant1_N="245", damping1_Ns_per_m="30")
    numbers = physical_numbers(ball)
    assert (numbers["constant1_N"], numbers["damping1_Ns_per_m"]) == pytest.approx((245, 30), rel=1e-12)
    assert (ball.omega1, ball.eta) == (before.omega1, 1.7)
    with pytest.raises(Refused, match="or its damper, c₁"):
        enter(ball, damping1_ratio="0.1")
    again = enter(ball, stiffness1_N_per_m="98696")
    assert (again.spring1, again.system.d1) == (1.0, pytest.approx(30 / (2 * 25 * again.omega1), rel=1e-12))


def test_each_of_two_bodies_may_lose_its_spring():
    before = enter(TWO, **ANALYST)
    for body, number in (("1", "spring1"), ("2", "kappa")):
        free = enter(before, **{f"stiffness{body}_N_per_m": "0"})
        assert (getattr(free.system, number), getattr(free, f"damper{body}_form")) == (0.0, "damper")
        for name, value in physical_numbers(before).items():
            follows = f"stiffness{body}_N_per_m", f"frequency{body}_Hz", f"damping{body}_ratio", "joint_damping_ratio"
            if name not in follows:
                assert physical_numbers(free)[name] == pytest.approx(value, rel=1e-13), name
    both = enter(free, stiffness1_N_per_m="0")
    assert both.system.has_free_body
    assert drawing_in_words(both).startswith("Two bodies, the first and the second without a spring")
    with pytest.raises(Refused, match="Pendulums have springs"):
        enter(Setting()._replace(units="si"), stiffness1_N_per_m="0")
