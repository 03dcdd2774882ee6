"""Limits on costs and rates, the log, the metrics and the size of the cache folder."""

import io
import json
import logging
import os
import sys

import pytest
from tornado.websocket import WebSocketClosedError
from vibroscope.app.explorer.errors import Refused
from vibroscope.app.explorer.reading import read_setting
from vibroscope.app.runtime import limits, logs, metrics
from vibroscope.app.runtime.limits import TokenBucket
from vibroscope.app.runtime.settings import Settings, use_settings
from vibroscope.app.server.housekeeping import limit_cache, trim_cache
from vibroscope.engine import EtaStudy, Reference, System, sweep
from vibroscope.engine.sweeps import cache


def test_cost_is_bounded_by_the_setting():
    use_settings(Settings(steps=4_100_000))
    try:
        read_setting({"steps": "2000"})  # just as many
        with pytest.raises(Refused, match="65,600,000 steps, and this server does 4,100,000"):
            read_setting({"steps": "32000"})
    finally:
        use_settings(Settings())


def test_a_bucket_empties_and_fills_again(monkeypatch):
    now = 0.0
    monkeypatch.setattr(limits.time, "monotonic", lambda: now)
    bucket = TokenBucket(rate=2, burst=3)
    assert [bucket.take() for _ in range(4)] == [True, True, True, False]
    now = 1.0
    assert [bucket.take() for _ in range(3)] == [True, True, False]


def test_a_long_message_is_logged_in_part():
    try:
        raise RuntimeError("e" * 100_000)
    except RuntimeError:
        record = logging.makeLogRecord({"msg": "m" * 100_000 + "end", "exc_info": sys.exc_info()})
    for form in (logs.Text(), logs.Json()):
        line = form.format(record)
        assert len(line) < 25_000
        assert "mend" in line


def test_an_event_is_one_line_of_text_also_with_a_traceback_or_a_message_of_several_lines():
    try:
        raise RuntimeError("first\nsecond\u2028third")
    except RuntimeError:
        record = logging.makeLogRecord({"msg": "Uncaught\nGET /", "exc_info": sys.exc_info(), "levelname": "ERROR"})
    line = logs.Text().format(record)
    assert len(line.splitlines()) == 1
    assert " ERROR Uncaught | GET / | Traceback (most recent call last): | File " in line
    assert line.endswith("RuntimeError: first | second | third")


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
    entry = json.loads(line)
    assert entry["event"] == "refused"
    assert entry["seconds"] == 0.25
    assert entry["name"].startswith("a�b�")
    assert len(entry["name"]) == 200


def test_only_the_traceback_of_a_closed_connection_is_left_out():
    def record(error):
        return logging.LogRecord("tornado", logging.ERROR, "", 0, "x", None, (type(error), error, None))

    assert not logs.is_not_a_closed_connection(record(WebSocketClosedError()))
    assert logs.is_not_a_closed_connection(record(ValueError()))


def test_durations_are_cumulative():
    durations = metrics.Durations("test_seconds", "x")
    for seconds in (0.0005, 0.001, 0.02, 50):
        durations.add(seconds)
    lines = dict(line.split() for line in durations.lines() if not line.startswith("#"))
    assert lines['test_seconds_bucket{le="0.001"}'] == "2"
    assert lines['test_seconds_bucket{le="0.03"}'] == "3"
    assert lines['test_seconds_bucket{le="+Inf"}'] == lines["test_seconds_count"] == "4"


def test_a_gauge_has_a_line_for_each_value_of_its_label():
    plain, labelled = metrics.Gauge("test", "x"), metrics.Gauge("test_by", "x", "pool")
    assert plain.lines()[2:] == ["test 0"]
    assert labelled.lines()[2:] == []
    labelled.read = lambda: {"solver": 2, "study": 0}
    assert labelled.lines()[2:] == ['test_by{pool="solver"} 2', 'test_by{pool="study"} 0']


def test_the_least_recently_used_study_is_deleted_first_also_while_serving(tmp_path, monkeypatch):
    monkeypatch.setenv("VIBROSCOPE_CACHE_DIR", str(tmp_path))
    monkeypatch.setattr(cache, "BYTES_KEPT", cache.BYTES_KEPT)  # restored
    trim_cache()  # nothing there is no error
    for age, name in ((3, "old"), (2, "newer"), (0, "young")):
        folder = tmp_path / "studies" / name
        folder.mkdir(parents=True)
        (folder / "data").write_bytes(b"x" * 600_000)
        os.utime(folder, (os.stat(folder).st_mtime - age * 86400,) * 2)
    limit_cache(2)
    trim_cache()
    assert len([*(tmp_path / "studies").iterdir()]) == 3
    limit_cache(1)
    sweep(
        EtaStudy(System(), Reference(), values=[2.7, 2.8], transient=20, sample=5), keep=True
    )  # as the engine keeps one more
    left = [path.name for path in (tmp_path / "studies").iterdir()]
    assert len(left) == 2
    assert "young" in left
