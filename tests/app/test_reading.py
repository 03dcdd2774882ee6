"""Whatever comes from outside is accepted whole or not at all, and printed values read back exactly."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st
from vibroscope.app.explorer.errors import Refused, error_text
from vibroscope.app.explorer.link import parse_address
from vibroscope.app.explorer.parameters import FIELDS, SECOND_STOP_FIELDS
from vibroscope.app.explorer.reading import read_setting, read_values
from vibroscope.app.explorer.state import Setting
from vibroscope.engine.law_table import LAW_NUMBERS, laws_with
from vibroscope.engine.model import check_eta
from vibroscope.engine.simulate import starting_checkpoint

from tests.app.settings_strategy import settings


def read_query(query):
    return read_setting(parse_address(query))


def test_a_setting_has_the_fields_and_their_defaults():
    assert {name: field.default for name, field in FIELDS.items()} == Setting()._asdict()
    assert hash(Setting()) == hash(Setting(eta=1.08))


def test_every_number_has_finite_bounds():
    bounds = [end for field in FIELDS.values() if not field.choices for end in field.bounds]
    assert len(bounds) == 82
    assert all(map(math.isfinite, bounds))


def engine_takes(name, value):
    """Whether the engine takes a value, as the command line hands it over."""
    setting = Setting(**{name: value})
    if name == "mass_ratio":
        setting = setting._replace(bodies="two")
    if name == "spring1":
        setting = setting._replace(bodies="wall")
    if name in SECOND_STOP_FIELDS:
        setting = setting._replace(stops="two")
    if name == "kappa":
        setting = setting._replace(kappa3=(1 + value) / 2)
    if name in ("alpha", "rho"):
        setting = setting._replace(integrator={"alpha": "hht", "rho": "bathe"}[name])
    if name in LAW_NUMBERS:
        setting = setting._replace(law=laws_with(name)[-1 if name == "stiffening" else 0])
    try:
        float(setting.stiffness_of_step)
        check_eta(setting.eta)
        starting_checkpoint(setting.initial, setting.system, setting.eta, setting.penalty)
        return all((setting.system, setting.reference, setting.penalty, setting._replace(units="si").scale))
    except ValueError:
        return False


NUMBERS = [name for name, field in FIELDS.items() if not field.choices]


@pytest.mark.parametrize("name", [name for name in NUMBERS if name not in ("kappa3", "clearance2")])  # κ, g₀ limit
def test_the_page_takes_what_the_engine_and_the_command_line_take(name):
    low, high = FIELDS[name].bounds
    below, above = (low - 1, high + 1) if name == "steps" else (low - 1e-12 - 1e-9 * abs(low), 1.000001 * high or 1e-9)
    assert [engine_takes(name, value) for value in (below, low, high, above)] == [False, True, True, False]


def test_values_that_make_no_system_together_are_refused_whole():
    with pytest.raises(Refused, match=r"kappa3 must lie between 1 and kappa = 1\.5"):
        read_setting({"kappa": "1.5", "eta": "2"})
    assert read_setting({"kappa": "1.5", "kappa3": "1.2"}).kappa3 == 1.2


def test_values_that_are_not_given_stay():
    assert read_setting({"eta": "2"}, Setting(K=99.0)) == Setting(eta=2.0, K=99.0)


@given(settings)
def test_printed_values_read_back_exactly(setting):
    assert read_setting(setting.texts()) == setting


@given(st.text(max_size=200))
def test_every_query_is_read_or_refused(query):
    check(lambda: read_query(query))


@given(st.dictionaries(st.sampled_from(list(FIELDS)), st.text(max_size=50) | st.floats().map(repr)))
def test_every_text_is_read_or_refused(texts):
    check(lambda: read_setting(texts))


def check(read):
    try:
        setting = read()
    except Refused:
        return
    for name in ("eta", "K", "D", "steps"):
        low, high = FIELDS[name].bounds
        assert low <= getattr(setting, name) <= high


@pytest.mark.parametrize(
    "query",
    [
        "eta=²",
        "eta=nan",
        "eta=inf",
        "eta=1e999",
        "eta=" + "9" * 5000,
        "eta=1&eta=2",
        "eta=1_0",
        "eta=0x1",
        "eta=１",
        "eta=",
        "eta=1,08",
        "steps=2000.5",
        "steps=3",
        "steps=1e6",
        "K=1.01e12",
        "D=-0.1",
        "frame=both",
        "joint_damping=",
        "eta=1.7&K=nan",
        "eta=1001",
        "kappa3=2.5",
        "restitution=1.1",
        "threshold=-1",
        "located=maybe",
        "eta=0.000999",
        "d1=1",
    ],
)
def test_bad_addresses_are_refused(query):
    with pytest.raises(Refused):
        read_query(query)


def test_a_refusal_names_value_and_range():
    with pytest.raises(Refused, match=r"eta must be a number from 0\.001 to 1000, not “7000”"):
        read_values({"eta": "7000"})


def test_a_refusal_quotes_briefly_and_without_control_characters():
    with pytest.raises(Refused) as refusal:
        read_values({"eta": "\x00" * 100})
    assert len(str(refusal.value)) < 120
    assert "\x00" not in str(refusal.value)


@pytest.mark.parametrize("value", [1.5, None, ["1"], {"a": 1}, True, float("nan")])
def test_forged_values_that_are_no_text_are_refused(value):
    for name in FIELDS:
        with pytest.raises(Refused):
            read_values({name: value})


def test_unknown_names_are_ignored():
    assert read_query("?utm_source=mail&eta=2") == Setting(eta=2.0)


def test_the_page_shows_only_the_engines_own_messages():
    assert error_text(ValueError("K must be at most 1e9")) == "K must be at most 1e9"
    assert "/" not in error_text(OSError(13, "Permission denied", "/home/somebody/.cache"))
