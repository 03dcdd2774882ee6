"""Settings from the environment, the gate, the limits, the log, the metrics, the cache's bound: without a server."""

import io
import json
import logging
import math
import os
import subprocess
import sys
from pathlib import Path

import pytest
from bokeh.document import Document
from bokeh.models import ColumnDataSource, Plot, Range1d
from hypothesis import given, settings
from hypothesis import strategies as st
from vibroscope.app.runtime import limits, logs, metrics
from vibroscope.app.runtime.limits import Bucket, TooMuch, check_cost
from vibroscope.app.runtime.settings import Settings, describe, from_environment, put_in_force, unknown, variable_of
from vibroscope.app.server import validation as gate
from vibroscope.app.server.housekeeping import bound_cache, drop_oldest
from vibroscope.engine import Reference, System, sweep_eta
from vibroscope.engine.sweeps import cache

from tests.browserless import changed, event, mapped

JSON = st.recursive(
    st.none() | st.booleans() | st.floats() | st.integers() | st.text(max_size=8),
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(st.sampled_from(["type", "entries", "id", "x"]), inner),
    max_leaves=12,
)


def test_the_environment_is_read_and_the_command_line_wins():
    environment = {"VIBROSCOPE_PORT": "8000", "VIBROSCOPE_ORIGINS": "a.example, b.example:81", "VIBROSCOPE_THREADS": ""}
    chosen = from_environment(environment, given={"port": 9000, "address": None})
    assert (chosen.port, chosen.origins, chosen.address) == (9000, ("a.example", "b.example:81"), "127.0.0.1")


@pytest.mark.parametrize(
    ("variable", "text"),
    [
        ("VIBROSCOPE_PORT", "65536"),
        ("VIBROSCOPE_PORT", "²"),
        ("VIBROSCOPE_THREADS", "0"),
        ("VIBROSCOPE_SESSIONS", "-1"),
        ("VIBROSCOPE_STEPS", "1e9"),
        ("VIBROSCOPE_ORIGINS", "http://a.example/x"),
        ("VIBROSCOPE_ADDRESS", "a b"),
        ("VIBROSCOPE_ADDRESS", "..."),
        ("VIBROSCOPE_ADDRESS", "a" * 64),
        ("VIBROSCOPE_ADDRESS", "[::1]"),
        ("VIBROSCOPE_ADDRESS", "1::2::3"),
        ("VIBROSCOPE_CACHE_DIR", __file__),
        ("VIBROSCOPE_LOG_FORMAT", "xml"),
        ("VIBROSCOPE_PROXIED", "true"),
        ("BOKEH_SECRET_KEY", "short"),
    ],
)
def test_what_is_wrong_is_named(variable, text):
    with pytest.raises(ValueError, match=variable):
        from_environment({variable: text})


@pytest.mark.parametrize(
    ("address", "host"),
    [
        ("127.0.0.1", "127.0.0.1"),
        ("Local-1.example", "local-1.example"),
        ("::", "[::]"),
        ("0:0:0::1", "[::1]"),
    ],
)
def test_an_address_is_written_as_browsers_write_it(address, host):
    assert from_environment({}, given={"address": address}).host == host


def test_everything_wrong_comes_in_one_line_and_secrets_stay_out_of_it():
    with pytest.raises(ValueError, match="not 7 characters") as caught:
        from_environment({"VIBROSCOPE_PORT": "x", "BOKEH_SECRET_KEY": "hunter2"})
    assert "VIBROSCOPE_PORT" in str(caught.value)
    assert "hunter2" not in str(caught.value)
    assert "\n" not in str(caught.value)
    assert "secret_key" not in repr(Settings())


def test_a_wrong_setting_ends_the_command_with_status_2():
    command = [Path(sys.executable).parent / "vibroscope", "serve"]
    environment = {**os.environ, "VIBROSCOPE_SESSIONS": "many"}
    told = subprocess.run(command, env=environment, capture_output=True, text=True, timeout=60)
    assert told.returncode == 2
    assert told.stderr.count("\n") == 1
    assert "VIBROSCOPE_SESSIONS must be a whole number from 1" in told.stderr


def test_help_names_every_variable_and_a_misspelt_one_is_noticed():
    for name in Settings.__dataclass_fields__:
        assert variable_of(name) in describe()
    assert unknown({"VIBROSCOPE_PROT": "1", "VIBROSCOPE_BROWSER": "/x", "PATH": "/"}) == ["VIBROSCOPE_PROT"]


def test_no_key_is_used_twice():
    assert from_environment({}).secret_key != from_environment({}).secret_key


# -- the gate --------------------------------------------------------------------


def document():
    doc, ends, source = Document(), Range1d(0, 1), ColumnDataSource({"x": [1.0]})
    doc.add_root(ends)
    doc.add_root(source)
    return doc, ends, source


@given(JSON)
@settings(max_examples=300, deadline=None)
def test_the_gate_takes_any_json_and_lets_no_odd_number_through(value):
    doc, ends, source = document()
    assert gate.sift(value, doc)[0] == []
    assert gate.sift({"events": [changed(source.id, "data", value)]}, doc)[0] == []
    passed, _ = gate.sift({"events": [changed(ends.id, "start", value), value]}, doc)
    for change in passed:
        assert isinstance(change["new"], int | float)
        assert math.isfinite(change["new"])


def test_the_gate_lets_a_zoom_through():
    doc, ends, _ = document()
    zoom = changed(ends.id, "start", 0.5)
    assert gate.sift({"events": [zoom, changed(ends.id, "name", "x")]}, doc) == ([zoom], 1)


@pytest.mark.parametrize(("size", "passes"), [(0, True), (1440, True), (4.01, False), (-1, False), (10**9, False)])
def test_a_frame_has_a_whole_number_of_pixels(size, passes):
    doc, plot = Document(), Plot()
    doc.add_root(plot)
    told = changed(plot.id, "inner_width", size)
    assert gate.sift({"events": [told]}, doc) == (([told], 0) if passes else ([], 1))


@pytest.mark.parametrize(
    ("name", "told", "passes"),
    [
        ("tap", {"sx": 1, "sy": 2, "x": 0.5, "y": None, "modifiers": mapped({"shift": False})}, True),
        ("tap", {"x": "0.5"}, False),
        ("tap", {"z": 1}, False),
        ("rangesupdate", {"x0": 0, "x1": 1, "y0": 0, "y1": 1}, True),
        ("rangesupdate", {"x": 1}, False),
        ("data_event", {"data": mapped({"painted": 1})}, True),
        ("data_event", {"x": 1}, False),
        (["tap"], {}, False),
    ],
)
def test_an_event_holds_what_its_kind_has_and_nothing_else(name, told, passes):
    doc, plot = Document(), Plot()
    doc.add_root(plot)
    said = event(name, mapped({"model": {"id": plot.id}, **told}))
    assert gate.sift({"events": [said]}, doc) == (([said], 0) if passes else ([], 1))


def test_a_tap_is_on_a_plot():
    doc, ends, _ = document()
    assert gate.sift({"events": [event("tap", mapped({"model": {"id": ends.id}, "x": 1}))]}, doc) == ([], 1)


def test_what_a_browser_reports_of_itself_is_not_worth_a_word():
    doc, ends, _ = document()
    idle = {"events": [changed(ends.id, "scroll_position", 120)]}
    assert gate.sift(idle, doc) == ([], 1)
    assert not gate.worth_a_word(idle)
    assert gate.worth_a_word({"events": [*idle["events"], changed(ends.id, "name", "x")]})


# -- limits ----------------------------------------------------------------------


def test_cost_is_bounded_by_the_setting():
    put_in_force(Settings(steps=5_000_000))
    try:
        check_cost(2000, 2050)
        with pytest.raises(TooMuch, match="65,600,000 steps, and this server does 5,000,000"):
            check_cost(32_000, 2050)
    finally:
        put_in_force(Settings())


def test_a_bucket_empties_and_fills_again(monkeypatch):
    now = 0.0
    monkeypatch.setattr(limits.time, "monotonic", lambda: now)
    bucket = Bucket(rate=2, burst=3)
    assert [bucket.take() for _ in range(4)] == [True, True, True, False]
    now = 1.0
    assert [bucket.take() for _ in range(3)] == [True, True, False]


# -- logs, metrics, cache -----------------------------------------------------------


def test_an_event_is_one_line_of_json_whatever_it_holds():
    written = io.StringIO()
    handler = logging.StreamHandler(written)
    handler.setFormatter(logs.Json())
    log = logging.getLogger("vibroscope")
    log.addHandler(handler)
    log.setLevel(logging.INFO)
    try:
        logs.event("refused", name="a\nb\x1b[0m" + "x" * 500, seconds=0.25)
    finally:
        log.removeHandler(handler)
    (line,) = written.getvalue().splitlines()
    told = json.loads(line)
    assert told["event"] == "refused"
    assert told["seconds"] == 0.25
    assert told["name"].startswith("a�b�")
    assert len(told["name"]) == 200


def test_only_the_traceback_of_a_closed_page_is_left_out():
    def record(error):
        return logging.LogRecord("tornado", logging.ERROR, "", 0, "x", None, (type(error), error, None))

    from tornado.websocket import WebSocketClosedError

    assert not logs.left_in_the_middle(record(WebSocketClosedError()))
    assert logs.left_in_the_middle(record(ValueError()))


def test_durations_are_cumulative():
    durations = metrics.Durations("test_seconds", "x")
    metrics._ALL.remove(durations)
    for seconds in (0.0005, 0.001, 0.02, 50):
        durations.add(seconds)
    lines = dict(line.split() for line in durations.lines() if not line.startswith("#"))
    assert lines['test_seconds_bucket{le="0.001"}'] == "2"
    assert lines['test_seconds_bucket{le="0.03"}'] == "3"
    assert lines['test_seconds_bucket{le="+Inf"}'] == lines["test_seconds_count"] == "4"


def test_a_gauge_has_a_line_for_each_value_of_its_label():
    plain, told_apart = metrics.Gauge("test", "x"), metrics.Gauge("test_by", "x", "pool")
    for gauge in (plain, told_apart):
        metrics._ALL.remove(gauge)
    assert plain.lines()[2:] == ["test 0"]
    assert told_apart.lines()[2:] == []
    told_apart.read = lambda: {"solver": 2, "study": 0}
    assert told_apart.lines()[2:] == ['test_by{pool="solver"} 2', 'test_by{pool="study"} 0']


def test_the_oldest_of_the_cache_goes_first_while_serving_too(tmp_path, monkeypatch):
    monkeypatch.setenv("VIBROSCOPE_CACHE_DIR", str(tmp_path))
    monkeypatch.setattr(cache, "BYTES_KEPT", cache.BYTES_KEPT)  # restored
    drop_oldest()  # nothing there is no error
    for age, name in ((3, "old"), (2, "newer"), (0, "young")):
        folder = tmp_path / "studies" / name
        folder.mkdir(parents=True)
        (folder / "data").write_bytes(b"x" * 600_000)
        os.utime(folder, (os.stat(folder).st_mtime - age * 86400,) * 2)
    bound_cache(2)
    drop_oldest()
    assert len([*(tmp_path / "studies").iterdir()]) == 3
    bound_cache(1)
    sweep_eta(System(), Reference(), [2.7, 2.8], transient=20, sample=5, keep=True)  # as the engine keeps one more
    left = [path.name for path in (tmp_path / "studies").iterdir()]
    assert len(left) == 2
    assert "young" in left
