"""The store of a study: killed, damaged, on a full disk, of another engine."""

import errno
import fcntl
import json
import os
import resource
import signal
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import xarray
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from vibroscope.engine import Cancelled, EtaStudy, Newmark, PlaneStudy, Progress, Reference, System, sweep
from vibroscope.engine.sweeps.digest import engine_digest
from vibroscope.engine.sweeps.store import DAMAGE, Store

from tests.engine.store_files import files
from tests.share import every, share
from tests.studies import sweep_of
from tests.waiting import PATIENCE

ETAS = np.linspace(2.6, 3.3, 24)
SHORT = {"transient": 60, "sample": 10}


def swept(out=None, **more):
    return sweep_of(EtaStudy, System(), Reference(), values=ETAS, out=out, **{"cells_per_chunk": 4, **SHORT, **more})


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    folder = tmp_path_factory.mktemp("kept") / "whole.zarr"
    swept(folder)
    return folder


def test_the_result_is_a_labelled_dataset_that_says_where_it_comes_from(whole):
    found = xarray.open_zarr(whole)
    assert found["xi2"].dims == ("eta", "sample")
    assert all("units" in variable.attrs and "long_name" in variable.attrs for variable in found.variables.values())
    attributes = found.attrs
    assert (attributes["complete"], attributes["computed"], attributes["transient"]) == (1, 24, 60)
    assert attributes["engine_digest"] == engine_digest()
    assert {"system", "method", "engine_version", "date", "seconds"} <= set(attributes)


@pytest.mark.parametrize("direction", ["rest", "up", "down"])
def test_the_numbers_depend_neither_on_chunks_nor_on_threads(direction):
    one, other = swept(direction=direction, threads=1), swept(direction=direction, threads=3, cells_per_chunk=7)
    xarray.testing.assert_equal(one, other)


def test_all_that_is_there_is_reused(whole):
    before = files(whole), (whole / "zarr.json").read_bytes()
    again = swept(whole)
    assert (again.attrs["computed"], again.attrs["reused"]) == (0, 24)
    assert (files(whole), (whole / "zarr.json").read_bytes()) == before


@pytest.mark.parametrize("more", every([{}, {"direction": "up"}, {"direction": "down"}, {"refine": 2}]))
def test_a_study_that_was_stopped_goes_on_to_the_very_same_bytes(tmp_path, more):
    swept(tmp_path / "whole.zarr", **more)
    seen = []
    with pytest.raises(Cancelled):
        swept(tmp_path / "stopped.zarr", progress=seen.append, cancelled=lambda: seen and seen[-1].done >= 8, **more)
    partial = xarray.open_zarr(tmp_path / "stopped.zarr") if not more.get("refine") else None
    assert partial is None or partial.attrs["complete"] == 0
    rest = swept(tmp_path / "stopped.zarr", **more)
    assert rest.attrs["reused"] >= 4
    assert rest.attrs["computed"] >= 4
    assert files(tmp_path / "stopped.zarr") == files(tmp_path / "whole.zarr")


KILLED = """
import sys, os, signal
import numpy as np
from vibroscope.engine import EtaStudy, Reference, System, sweep
# a chunk every 10 ms, so that the signal meets the process at any moment
sweep(EtaStudy(System(), Reference(), values=np.linspace(2.6, 3.3, 160), transient=20, sample=10), cells_per_chunk=4,
      out=sys.argv[1],
      progress=lambda now: now.done >= 24 and print("on its way", flush=True))
"""


def test_a_process_that_is_killed_leaves_what_the_next_one_needs(tmp_path):
    etas = np.linspace(2.6, 3.3, 160)
    how = {"transient": 20, "sample": 10, "cells_per_chunk": 4}
    process = subprocess.Popen(
        [sys.executable, "-c", KILLED, str(tmp_path / "killed.zarr")],
        stdout=subprocess.PIPE,
        cwd=Path(__file__).parents[2],
    )
    with process:
        process.stdout.readline()
        process.send_signal(signal.SIGKILL)
        assert process.wait(PATIENCE) == -signal.SIGKILL
    rest = sweep_of(EtaStudy, System(), Reference(), values=etas, out=tmp_path / "killed.zarr", **how)
    assert rest.attrs["reused"] >= 16
    assert rest.attrs["computed"] >= 4
    sweep_of(EtaStudy, System(), Reference(), values=etas, out=tmp_path / "whole.zarr", **how)
    assert files(tmp_path / "killed.zarr") == files(tmp_path / "whole.zarr")


def readable(folder):
    try:
        xarray.open_zarr(folder).load()
    except DAMAGE:
        return False
    return True


@settings(max_examples=share(8), suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(data=st.data())
def test_a_damaged_file_is_found_and_computed_anew(whole, data):
    """Cut, changed, emptied or deleted: whatever is wrong with a chunk, it is not shown and the next run mends it."""
    good = files(whole)
    name = data.draw(st.sampled_from([name for name in good if "/c" in name]))
    content, path = good[name], whole / name
    damage = data.draw(st.sampled_from(["cut", "change", "empty", "delete"]))
    at = data.draw(st.integers(0, len(content) - 1))
    if damage == "delete":
        path.unlink()
    elif damage == "change":
        path.write_bytes(content[:at] + bytes([content[at] ^ (1 << data.draw(st.integers(0, 7)))]) + content[at + 1 :])
    else:
        path.write_bytes(content[: at if damage == "cut" else 0])
    if damage != "delete":
        assert not readable(whole)
    mended = swept(whole)
    assert mended.attrs["computed"] in ((4,) if len(good[name]) and name.split("/")[0] not in mended.coords else (0,))
    assert files(whole) == good


def test_another_study_another_engine_and_other_peoples_files_are_left_alone(tmp_path, whole, monkeypatch):
    with pytest.raises(ValueError, match="another study"):
        swept(whole, transient=61)
    monkeypatch.setattr("vibroscope.engine.sweeps.study.engine_digest", lambda: "other")
    with pytest.raises(ValueError, match="by another engine"):
        swept(whole)
    (tmp_path / "letter.partial").write_text("dear")
    with pytest.raises(ValueError, match="no result of a sweep"):
        swept(tmp_path)
    assert (tmp_path / "letter.partial").read_text() == "dear"
    with pytest.raises(OSError, match="can be written"):
        swept(tmp_path / "letter.partial")


def test_two_processes_do_not_work_on_one_result(whole):
    handle = os.open(whole, os.O_RDONLY)
    try:
        fcntl.flock(handle, fcntl.LOCK_EX)
        with pytest.raises(BlockingIOError, match="another process"):
            swept(whole)
    finally:
        os.close(handle)


def test_too_small_a_disk_is_refused_before_work_starts(tmp_path, monkeypatch):
    class Usage:
        free = 1000

    monkeypatch.setattr("shutil.disk_usage", lambda path: Usage)
    with pytest.raises(OSError, match="are free") as refused:
        swept(tmp_path / "a.zarr")
    assert refused.value.errno == errno.ENOSPC
    assert not (tmp_path / "a.zarr").exists()


def test_a_disk_that_fills_up_stops_it_cleanly_and_the_rest_follows_later(tmp_path, whole):
    """The system itself refuses: no file may grow beyond some bytes, as on a full disk."""
    write, calls = Store.write_now, []

    def full(store, chunk, values):
        calls.append(chunk)
        if len(calls) < 3:
            return write(store, chunk, values)
        soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
        resource.setrlimit(resource.RLIMIT_FSIZE, (10, hard))
        try:
            return write(store, chunk, values)
        finally:
            resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(Store, "write_now", full)
        with pytest.raises(OSError, match="make room"):
            swept(tmp_path / "a.zarr")
    rest = swept(tmp_path / "a.zarr")
    assert rest.attrs["reused"] == 8
    assert files(tmp_path / "a.zarr") == files(whole)


def test_a_url_is_as_good_as_a_folder(whole):
    found = swept("memory://sweeps/a")
    assert swept("memory://sweeps/a").attrs["reused"] == 24
    xarray.testing.assert_equal(xarray.open_zarr("memory://sweeps/a"), xarray.open_zarr(whole))
    assert found.attrs["computed"] == 24
    with pytest.raises(ValueError, match="cannot be opened"):
        swept("nowhere://a")


def test_progress_counts_up_to_the_end():
    seen = []
    swept(progress=seen.append)
    done = [now.done for now in seen]
    assert done == sorted(done)
    assert (seen[-1].done, seen[-1].total, seen[-1].computed, seen[-1].failed) == (24, 24, 24, 0)
    assert seen[-1].rate > 0
    assert seen[-1].seconds_left == 0
    assert Progress(done=0, total=24, computed=0, reused=0, failed=0, seconds=0.0).seconds_left == np.inf


def test_a_plane_comes_back_from_its_store_as_it_was(tmp_path):
    K, D = np.geomspace(100, 1e4, 5), np.geomspace(1, 50, 3)
    study = PlaneStudy(System(), Newmark(1, 1, 500), 2.76, K=K, D=D, transient=50, sample=10)
    xarray.testing.assert_equal(sweep(study), sweep(study, out=tmp_path / "p.zarr", cells_per_chunk=4))


def test_a_chunk_in_which_nothing_reached_its_end_is_complete_too(tmp_path):
    """All nan is a result; a chunk that is not there is none."""
    study = PlaneStudy(System(), Newmark(1, 1, 100), 2.76, K=[500, 60_000], D=[1.0], transient=200, sample=10)
    how = {"out": tmp_path / "p.zarr", "cells_per_chunk": 1}
    assert sweep(study, **how).attrs["failed"] == 1
    assert sweep(study, **how).attrs["reused"] == 2


def test_what_is_swept_is_no_attribute(whole):
    found = xarray.open_zarr(whole).attrs
    assert "eta" not in found
    plane = sweep(PlaneStudy(System(), Newmark(1, 1, 100), 2.76, K=[100.0], D=[5.0], transient=5, sample=5), keep=False)
    method = json.loads(plane.attrs["method"])
    assert not {"stiffness", "damping"} & method.keys()
    assert (method["name"], method["steps"], method["integrator"]["name"]) == ("newmark", 100, "newmark")
