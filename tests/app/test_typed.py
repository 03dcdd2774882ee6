"""Typed numbers: separators, decimal commas and units are read where they are unambiguous, else refused in words."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st
from vibroscope.app.explorer.errors import Refused
from vibroscope.app.explorer.parameters import FIELDS
from vibroscope.app.explorer.reading import read_setting
from vibroscope.app.explorer.state import Setting
from vibroscope.app.explorer.suggestion import make_question
from vibroscope.app.explorer.typed import parse_typed, plain_texts


def typed(name, text, **changes):
    """The value of one parameter after ``text`` was typed."""
    setting = Setting(**changes)
    return getattr(read_setting(plain_texts({name: {"typed": text}}, setting), setting), name)


@pytest.mark.parametrize(
    ("name", "text", "value"),
    [
        ("steps", "20,000", 20_000),
        ("steps", "20.000", 20_000),  # nobody writes the decimals of a whole number
        ("steps", "12 000", 12_000),
        ("steps", "12\u202f000", 12_000),
        ("steps", "12'000", 12_000),
        ("steps", "12_000", 12_000),
        ("steps", "2e3", 2000),
        ("steps", "2000.0", 2000),
        ("K", "12 000", 12_000.0),
        ("K", "12,500.25", 12_500.25),
        ("K", "12.500,25", 12_500.25),
        ("K", "12500,25", 12_500.25),
        ("K", "12 500,25", 12_500.25),
        ("K", "1.2e4", 12_000.0),
        ("K", "1,2E4", 12_000.0),
        ("K", "1.2 × 10^4", 12_000.0),
        ("K", "1,2·10⁴", 12_000.0),
        ("eta", "1,08", 1.08),
        ("eta", "1,125", 1.125),  # 1125 would be out of range
        ("eta", " 2.76 ", 2.76),
        ("d1", "0,005", 0.005),
        ("d1", ".005", 0.005),
        ("d1", "1 %", 0.01),
        ("restitution", "70%", 0.7),
        ("m1", "1,000,000", 1e6),
        ("m1", "1.000.000", 1e6),
    ],
)
def test_what_people_type_is_read(name, text, value):
    assert typed(name, text) == value


@pytest.mark.parametrize(
    ("name", "text", "words"),
    [
        ("K", "12,000", "can mean 12000 or 12: write 12000 or 12.0"),
        ("K", "12.000", "can mean 12000 or 12: write 12000 or 12.0"),
        ("m1", "1,125", "can mean 1125 or 1.125: write 1125 or 1.125"),
    ],
)
def test_a_text_with_two_meanings_is_refused_with_both(name, text, words):
    with pytest.raises(Refused, match=words) as refusal:
        typed(name, text)
    assert refusal.value.name == name
    for part in words.partition("write ")[2].split(" or "):
        assert typed(name, part) == float(part)


@pytest.mark.parametrize(
    "text",
    ["", "twelve", "12 00", "1,23.4", "1,2,3", "12,", "--3", "1e", "nan", "0x10", "²", "１", "5 apples", "9" * 41],
)
def test_what_is_no_number_is_refused_with_the_range(text):
    with pytest.raises(Refused, match=r"K must be a number from .* to .*, not “"):
        typed("K", text)


@pytest.mark.parametrize(
    ("name", "text", "words"),
    [
        ("d1", "1", "d₁ must be a number from 0 to below 1, not “1”."),
        ("step_scale", "0", "s must be a number from above 0 to 1e6, not “0”."),
        ("restitution", "0.5 mm", "e must be a number from 0 to 1 or in %, not “0.5 mm”."),  # no unit would do
    ],
)
def test_the_range_says_whether_its_ends_are_in_it(name, text, words):
    with pytest.raises(Refused) as refusal:
        typed(name, text)
    assert str(refusal.value) == words


UNITS = {"units": "mm-t-s", "omega1": 2 * math.pi * 15, "m1": 2.0, "amplitude": 0.5}


@pytest.mark.parametrize(
    ("name", "text", "value"),
    [
        ("eta", "28", 28 / 15),
        ("eta", "28 Hz", 28 / 15),
        ("kappa", "32 Hz", 32 / 15),
        ("omega1", "15 Hz", 2 * math.pi * 15),
        ("K", "12 kN/mm", 12e6 / (2 * (2 * math.pi * 15) ** 2)),
        ("K", "12,5", 12500 / (2 * (2 * math.pi * 15) ** 2)),  # N/mm
        ("D", "36 N s/m", 36 / (4 * 2 * math.pi * 15)),
        ("D", "0.036 N·s/mm", 36 / (4 * 2 * math.pi * 15)),
        ("m1", "0.002", 2.0),  # t
        ("m1", "2 kg", 2.0),
        ("amplitude", "500 µm", 0.5),
        ("threshold", "1 mm/s", 1 / (0.5 * 2 * math.pi * 15)),
    ],
)
def test_units_are_read(name, text, value):
    assert typed(name, text, **UNITS) == pytest.approx(value, rel=1e-14)


def test_a_typed_time_step_gives_the_steps_per_period():
    setting = Setting(**UNITS)
    assert typed("steps", "10 µs", **UNITS) == math.ceil(setting.period / 10e-6)
    assert typed("steps", f"{setting.period / 4000!r} s", **UNITS) == 4000


@pytest.mark.parametrize(
    ("name", "text", "words"),
    [
        ("K", "3 kg", r"K must be a number from .* N/mm, typed in N/m, kN/m, MN/m, N/mm, kN/mm, not “3 kg”"),
        ("eta", "28 km", r"f must be a number from 0\.015 to 15000 Hz, typed in Hz, kHz, .*not “28 km”"),
    ],
)
def test_another_unit_is_refused_with_those_that_fit(name, text, words):
    with pytest.raises(Refused, match=words):
        typed(name, text, **UNITS)


def test_a_unit_means_nothing_without_units():
    with pytest.raises(Refused, match="A unit can be typed once Units is SI or mm-t-s"):
        typed("K", "12 kN/mm")


@pytest.mark.parametrize(
    ("name", "text", "units"), [("d1", "0.1 kg", UNITS), ("K", "12 apples", {}), ("eta", "1/2", {}), ("K", "-1", {})]
)
def test_units_are_advised_only_where_they_help(name, text, units):
    with pytest.raises(Refused) as refused:
        typed(name, text, **units)
    assert "once" not in str(refused.value)


@pytest.mark.parametrize("units", [UNITS, {}])
@pytest.mark.parametrize("text", ["T/2000", "1/2000", "1 / 2,000"])
def test_a_step_can_be_typed_as_a_part_of_the_period(text, units):
    assert typed("steps", text, **units) == 2000


def test_a_tolerance_is_typed_like_any_other_number():
    found = [
        make_question(Setting(), {"tolerance": text}).search.tolerances.displacement
        for text in ("5", "5 %", "2,5", "0.5%")
    ]
    assert found == [0.05, 0.05, 0.025, 0.005]


def test_a_slider_and_an_address_have_plain_numbers_only():
    assert plain_texts({"K": "2500", "frame": "absolute"}, Setting()) == {"K": "2500", "frame": "absolute"}
    with pytest.raises(Refused):
        read_setting({"K": "12 000"})


@given(st.floats(1e-9, 1e12), st.sampled_from([",", " ", "'"]))
def test_every_grouped_number_means_what_was_printed(value, mark):
    assert float(f"{value:.6f}") in parse_typed(f"{value:,.6f}".replace(",", mark)).numbers


@given(st.sampled_from(list(FIELDS)), st.text(max_size=50) | st.floats().map(repr) | st.none() | st.integers())
def test_every_typed_text_is_read_or_refused(name, text):
    try:
        setting = read_setting(plain_texts({name: {"typed": text}}, Setting()))
    except Refused:
        return
    bounds = FIELDS[name].bounds
    assert not bounds or bounds[0] <= getattr(setting, name) <= bounds[1]
