"""Studies kept in the user's cache: found by their numbers, mended, dropped, computed by one of several processes."""

import os
import shutil
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from vibroscope.engine import Reference, System
from vibroscope.engine.drivers.code_cache import cache_root, source_digest
from vibroscope.engine.sweeps import EtaStudy, RunOptions, cache, grow_cached, grow_picture
from vibroscope.engine.sweeps.store_location import FOLDER

from tests.waiting import PATIENCE

ETAS = np.linspace(2.6, 3.3, 24)


def study(e=0.5):
    return EtaStudy(System(restitution=e), Reference(), 2.6, transient=20, sample=5, values=ETAS)


def test_the_cache_finds_a_study_by_every_number_and_the_engine(tmp_path, monkeypatch):
    monkeypatch.setenv("VIBROSCOPE_CACHE_DIR", str(tmp_path))
    first = cache.cached_dataset(study())
    again = cache.cached_dataset(study())
    assert (first.attrs["computed"], again.attrs["reused"]) == (24, 24)
    assert cache.cached_dataset(study(0.4)).attrs["computed"] == 24
    monkeypatch.setattr("vibroscope.engine.sweeps.study.engine_digest", lambda: "other")
    assert cache.cached_dataset(study()).attrs["computed"] == 24


def test_a_study_grows_in_the_cache_and_is_read_from_it(tmp_path, monkeypatch):
    monkeypatch.setenv("VIBROSCOPE_CACHE_DIR", str(tmp_path))
    options = RunOptions(cells_per_chunk=8)
    known = [int((values["status"] >= 0).sum()) for values in grow_cached(study(), options)]
    assert known == [8, 16, 24]
    (again,) = grow_cached(study(), options)
    np.testing.assert_array_equal(again["xi2"], cache.cached_dataset(study())["xi2"])


def test_a_study_that_grows_waits_for_nobody_who_is_at_work_on_it(tmp_path, monkeypatch):
    monkeypatch.setenv("VIBROSCOPE_CACHE_DIR", str(tmp_path))
    options = RunOptions(cells_per_chunk=8, cancelled=lambda: False)
    first = grow_cached(study(), options)
    next(first)
    with ThreadPoolExecutor(1) as pool:
        *_, second = pool.submit(lambda: list(grow_cached(study(), options))).result(PATIENCE)
    *_, whole = first
    np.testing.assert_array_equal(second["xi2"], whole["xi2"])


@pytest.fixture
def computed(monkeypatch, tmp_path):
    """The batches that studies compute, in an empty cache that keeps every picture."""
    monkeypatch.setenv("VIBROSCOPE_CACHE_DIR", str(tmp_path))
    monkeypatch.setattr(cache, "DEAR", 0.0)
    batches, compute = [], EtaStudy.compute
    monkeypatch.setattr(EtaStudy, "compute", lambda *of, **how: batches.append(1) or compute(*of, **how))
    return batches


@pytest.mark.parametrize("direction", ["rest", "down"])
def test_a_picture_that_is_complete_is_read_by_the_next_process(computed, direction):
    of = replace(study(), direction=direction)
    *_, first = grow_picture(of, RunOptions())
    cost = len(computed)
    (again,) = grow_picture(of, RunOptions())
    assert len(computed) == cost > 0
    assert all(np.array_equal(first[name], again[name], equal_nan=True) for name in of.variables)
    assert cache.cached_dataset(of).attrs["reused"] == 24


def test_a_picture_that_was_cancelled_or_cheap_or_is_damaged_is_computed(computed, tmp_path, monkeypatch):
    kept, cheap = (tmp_path / "studies" / each.key for each in (study(), study(0.4)))
    growing = grow_picture(study(), RunOptions())
    part = next(growing)
    growing.close()
    assert not kept.exists()
    *_, whole = grow_picture(study(), RunOptions(), part)
    (kept / "xi2" / "c" / "0" / "0").unlink()
    before = len(computed)
    *_, mended = grow_picture(study(), RunOptions())
    assert len(computed) > before
    np.testing.assert_array_equal(whole["xi2"], mended["xi2"])
    monkeypatch.setattr(cache, "DEAR", 1e9)
    list(grow_picture(study(0.4), RunOptions()))
    assert not cheap.exists()


def test_an_entry_of_the_cache_whose_manifest_is_lost_is_dropped(tmp_path, monkeypatch):
    monkeypatch.setenv("VIBROSCOPE_CACHE_DIR", str(tmp_path))
    cache.cached_dataset(study())
    (entry,) = (tmp_path / "studies").iterdir()
    shutil.rmtree(entry / FOLDER)
    assert cache.cached_dataset(study()).attrs["computed"] == 24
    assert cache.cached_dataset(study()).attrs["reused"] == 24


def test_a_cache_that_cannot_be_written_costs_only_time(tmp_path, monkeypatch):
    blocked = tmp_path / "file"
    blocked.write_text("not a folder")
    monkeypatch.setenv("VIBROSCOPE_CACHE_DIR", str(blocked))
    *_, values = grow_cached(study(), RunOptions())
    assert (values["status"] == 0).all()


def test_the_cache_drops_what_was_not_used_for_the_longest_time(tmp_path, monkeypatch):
    monkeypatch.setenv("VIBROSCOPE_CACHE_DIR", str(tmp_path))
    root = tmp_path / "studies"
    for used, e in enumerate((0.3, 0.4, 0.5)):
        cache.cached_dataset(study(e))
        os.utime(root / study(e).key, (used, used))
    cache.cached_dataset(study(0.3))
    size = sum(path.stat().st_size for path in root.rglob("*")) // 3
    cache.drop_oldest(root, most=int(2.5 * size))
    assert {path.name for path in root.iterdir()} == {study(0.3).key, study(0.5).key}
    cache.drop_oldest(root, spare=root / study(0.5).key, most=0)
    assert [path.name for path in root.iterdir()] == [study(0.5).key]


SWEEP = """
import numpy as np
from vibroscope.engine import EtaStudy, Reference, System, sweep
study = EtaStudy(System(), Reference(), values=np.linspace(2.6, 3.3, 24), transient=4000, sample=5)
found = sweep(study, keep=True)
print(found.attrs["computed"], float(found["xi2"].sum()))
"""


def test_of_two_processes_that_want_the_same_study_one_computes_it(tmp_path):
    environment = {**os.environ, "VIBROSCOPE_CACHE_DIR": str(tmp_path)}
    name = f"kernels-{source_digest()}"
    (tmp_path / name).symlink_to(cache_root() / name)  # compiled already
    how = {"env": environment, "cwd": Path(__file__).parents[2], "stdout": subprocess.PIPE, "text": True}
    processes = [subprocess.Popen([sys.executable, "-c", SWEEP], **how) for _ in range(2)]
    answers = [process.communicate(timeout=60)[0].split() for process in processes]
    assert sorted(int(computed) for computed, _ in answers) == [0, 24]
    assert answers[0][1] == answers[1][1]
