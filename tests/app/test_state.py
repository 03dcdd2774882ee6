"""Whatever comes from outside is taken whole or not at all, and what is printed reads back exactly."""

import math
from itertools import pairwise
from urllib.parse import quote

import pytest
from hypothesis import given
from hypothesis import strategies as st
from vibroscope.app.explorer.history import History
from vibroscope.app.explorer.scenes import scene_of, scenes
from vibroscope.app.explorer.state import (
    MAIN_FIELDS,
    Explorer,
    Refused,
    Setting,
    check_together,
    parse_address,
    print_address,
    read,
    texts_of,
)


def values_of(name):
    rule = Explorer.param[name]
    if name == "kappa3":
        return st.floats(1.01, 1.8)  # below every kappa drawn
    if name == "kappa":
        return st.floats(1.9, 10)
    if name == "steps":
        return st.integers(*rule.bounds)
    return st.sampled_from(rule.objects) if hasattr(rule, "objects") else st.floats(*rule.bounds)


settings = st.builds(Setting, **{name: values_of(name) for name in Setting._fields})
DEFAULT = Explorer().setting()


def restored(query):
    explorer = Explorer()
    explorer.apply(parse_address(query))
    return explorer.setting()


@given(settings, settings)
def test_an_address_restores_its_setting_and_what_is_pinned_exactly(setting, pinned):
    query = "?" + print_address(setting, "speed", pinned)
    assert restored(query) == setting
    texts = parse_address(query)
    assert texts["tab"] == "speed"
    assert restored("?" + texts["pin"]) == pinned


def test_values_that_make_no_system_together_are_refused_whole():
    explorer = Explorer()
    with pytest.raises(Refused, match=r"kappa3 must lie between 1 and kappa = 1\.5"):
        explorer.apply({"kappa": "1.5", "eta": "2"})
    assert explorer.setting() == DEFAULT
    explorer.apply({"kappa": "1.5", "kappa3": "1.2"})
    check_together(explorer.setting())


def test_a_drag_is_undone_as_a_whole_and_redone_until_something_else_is_moved():
    history, steps = History(), [DEFAULT._replace(eta=eta) for eta in (1.0, 1.1, 1.2)]
    for i, (before, after) in enumerate(pairwise(steps)):
        history.record(before, after, now=0.1 * i)
    other = steps[-1]._replace(K=99.0)
    history.record(steps[-1], other, now=0.3)
    assert history.undo(other) == steps[-1]
    assert history.undo(steps[-1]) == steps[0]
    assert history.undo(steps[0]) is None
    assert history.redo(steps[0]) == steps[-1]
    assert history.redo(steps[-1]) == other
    assert history.undo(other) == steps[-1]
    history.record(steps[-1], steps[0], now=9.0)
    assert not history.can_redo


def test_moves_that_lie_apart_in_time_are_undone_one_by_one():
    history, steps = History(), [DEFAULT._replace(eta=eta) for eta in (1.0, 1.1, 1.2)]
    history.record(steps[0], steps[1], now=0.0)
    history.record(steps[1], steps[2], now=5.0)
    assert history.undo(steps[2]) == steps[1]
    assert history.undo(steps[1]) == steps[0]


@given(settings)
def test_printed_values_read_back_exactly(setting):
    assert Setting(**read(texts_of(setting))) == setting


@given(st.text(max_size=200))
def test_no_query_does_anything_but_apply_or_refuse(query):
    check(query)


@given(st.lists(st.tuples(st.sampled_from(Setting._fields), st.text(max_size=50) | st.floats().map(repr))))
def test_no_value_does_anything_but_apply_or_refuse(pairs):
    check("&".join(f"{name}={quote(text)}" for name, text in pairs))


def check(query):
    explorer = Explorer()
    before = explorer.setting()
    refused = ""
    try:
        explorer.apply(parse_address(query))
    except Refused as error:
        refused = str(error)
    valid(explorer.setting())
    assert not refused or explorer.setting() == before


def valid(setting):
    for name in ("eta", "K", "D", "steps"):
        low, high = Explorer.param[name].bounds
        value = getattr(setting, name)
        assert math.isfinite(value)
        assert low <= value <= high


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
        "steps=7",
        "K=1e6",
        "D=0",
        "frame=both",
        "joint_damping=",
        "eta=1.7&K=nan",
        "eta=4.0000001",
        "kappa3=2.5",
        "restitution=1.1",
        "threshold=-1",
        "located=maybe",
        "eta=0.49999",
    ],
)
def test_bad_addresses_are_refused_whole(query):
    explorer = Explorer()
    with pytest.raises(Refused):
        explorer.apply(parse_address(query))
    assert explorer.setting() == Explorer().setting()


def test_a_refusal_names_value_and_range():
    with pytest.raises(Refused, match=r"eta must be a number from 0\.5 to 4, not “7”"):
        read({"eta": "7"})


def test_a_refusal_quotes_briefly_and_without_control_characters():
    with pytest.raises(Refused) as refusal:
        read({"eta": "\x00" * 100})
    assert len(str(refusal.value)) < 120
    assert "\x00" not in str(refusal.value)


@pytest.mark.parametrize("value", [1.5, None, ["1"], {"a": 1}, True, float("nan")])
def test_forged_values_that_are_no_text_are_refused(value):
    for name in Setting._fields:
        with pytest.raises(Refused):
            read({name: value})


def test_unknown_names_are_left_alone():
    assert restored("?utm_source=mail&eta=2") == Explorer(eta=2.0).setting()


def test_bounds_hold_for_direct_assignment_too():
    with pytest.raises(ValueError, match="must be at most"):
        Explorer().eta = 7.0


def test_scenes_carry_the_papers_numbers():
    found = scenes()
    assert [found[key].eta for key in "ABCD"] == [1.08, 1.70, 2.76, 3.25]
    assert {n: found["9B"].texts()[n] for n in MAIN_FIELDS} == {"eta": "1.08", "K": "100", "D": "50", "steps": "2000"}
    assert [found[f"14{key}"].steps for key in "ABCD"] == [2000, 4000, 6000, 8000]
    assert {(found[f"14{key}"].K, found[f"14{key}"].D) for key in "ABCD"} == {(12000, 18)}
    assert all("ur example" in found[f"10{key}"].tooltip for key in "ABC")


def test_every_scene_is_valid_and_known_again():
    for scene in scenes().values():
        explorer = Explorer()
        explorer.apply(scene.texts())
        assert scene.matches(explorer.setting())
        assert scene_of(explorer.setting()) != ""
        assert not scene.matches(explorer.setting()._replace(restitution=0.7))
