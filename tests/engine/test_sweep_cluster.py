"""The same chunks on a Dask cluster: a scheduler and two workers on this machine, one of which is killed."""

import contextlib
import os
import re
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

import fsspec
import numpy as np
import pytest
import xarray
from vibroscope.engine import BasinStudy, Newmark, NoSolutionStudy, PlaneStudy, Reference, System, TimeStepping, sweep
from vibroscope.engine.sweeps import MISSING, EtaStudy, RunOptions, grow

from tests.engine.store_files import files
from tests.share import every
from tests.studies import sweep_of
from tests.waiting import PATIENCE

distributed = pytest.importorskip("distributed")
ETAS = np.linspace(2.6, 3.3, 64)
ROOT = Path(__file__).parents[2]


def start(module, *arguments, **how):
    command = [sys.executable, "-m", f"distributed.cli.{module}", *arguments]
    environment = {**os.environ, "FSSPEC_LOCAL_AUTO_MKDIR": "yes"}  # a bucket has no folders that must be there first
    return subprocess.Popen(command, cwd=ROOT, env=environment, stdout=subprocess.DEVNULL, **how)


@contextlib.contextmanager
def running():
    """Address of a scheduler, and the processes: its two workers, and itself."""
    where = ("--host", "127.0.0.1", "--port", "0", "--no-dashboard")
    scheduler = start("dask_scheduler", *where, stderr=subprocess.PIPE, text=True)
    processes = [scheduler]
    rest = threading.Thread(target=scheduler.stderr.read)  # else its pipe would fill up
    try:
        address = next(
            found[1] for line in scheduler.stderr if (found := re.search(r"Scheduler at:\s*(tcp://\S+)", line))
        )
        rest.start()
        worker = ("dask_worker", address, "--nthreads", "1", "--no-nanny", "--no-dashboard")
        processes += [start(*worker, stderr=subprocess.DEVNULL), start(*worker, stderr=subprocess.DEVNULL)]
        yield address, [*processes[1:], scheduler]
    finally:
        for process in processes:
            process.kill()
            process.wait(PATIENCE)
        if rest.is_alive():
            rest.join(PATIENCE)
        scheduler.stderr.close()


@pytest.fixture(scope="module")
def cluster():
    with running() as started:
        yield started


def swept(out=None, **more):
    how = {"transient": 400, "sample": 10, "cells_per_chunk": 2}
    return sweep_of(EtaStudy, System(), Reference(), values=ETAS, out=out, **how | more)


def test_basins_are_the_same(cluster):
    """Each worker finds the motions for itself."""
    values = np.linspace(-8, 8, 12)
    study = BasinStudy.over(System(), Reference(), 3.2, {"xi2": values, "v2": values})
    here, there = sweep(study), sweep(study, scheduler=cluster[0], cells_per_chunk=30)
    for name in ("motion", "reached", "periods", "motion_share"):
        np.testing.assert_array_equal(here[name], there[name])


def test_steps_without_a_solution_are_the_same(cluster):
    axes = {"K": np.geomspace(500, 20_000, 5), "steps": [50, 200, 400]}
    method = TimeStepping(1, 18, 100, status="end")
    study = NoSolutionStudy(System(), method, 2.76, **axes, transient=4, sample=4)
    here = sweep(study)
    there = sweep(study, scheduler=cluster[0], cells_per_chunk=4)
    assert here["steps_without_solution"].any()
    assert not here["steps_without_solution"].all()
    xarray.testing.assert_equal(there, here)


@pytest.mark.parametrize("direction", ["rest", "up"])
def test_progress_is_reported_before_and_while_the_workers_compute(cluster, direction, monkeypatch):
    submit = distributed.Client.submit

    def submit_late(self, function, *arguments, **how):
        def late(*given):
            time.sleep(0.7)  # a report comes every 0.2 s
            return function(*given)

        return submit(self, late, *arguments, **how)

    monkeypatch.setattr(distributed.Client, "submit", submit_late)
    seen = []
    swept(scheduler=cluster[0], progress=seen.append, cells_per_chunk=32, direction=direction)
    assert (seen[0].done, seen[0].total) == (0, len(ETAS))
    assert len(seen) > 4  # more than the beginning and one for each chunk
    assert [now.done for now in seen] == sorted(now.done for now in seen)
    assert seen[-1].done == seen[-1].computed == len(ETAS)


def test_continuation_goes_chunk_by_chunk(cluster):
    address, _ = cluster
    how = {"direction": "down", "cells_per_chunk": 24, "transient": 20}
    xarray.testing.assert_equal(swept(scheduler=address, **how), swept(**how))


def test_a_study_grows_on_a_cluster_as_it_does_here(cluster, tmp_path):
    address, _ = cluster
    study = EtaStudy(System(), Reference(), None, transient=400, sample=10, values=ETAS)
    known = []
    for partial in grow(study, RunOptions(tmp_path / "a.zarr", address, cells_per_chunk=16)):
        known.append(int((partial.values()["status"] != MISSING).sum()))
    assert known == sorted(known)
    assert len(known) >= 2
    assert known[-1] == len(ETAS)
    xarray.testing.assert_equal(partial.dataset(), swept())


def test_to_an_object_store_the_workers_write_themselves(cluster, tmp_path, monkeypatch):
    """``local://`` stands for a bucket: a URL that workers reach as well as we do."""
    monkeypatch.setitem(fsspec.config.conf, "local", {"auto_mkdir": True})
    address, _ = cluster
    url = f"local://{tmp_path}/a.zarr"
    K, D = np.geomspace(100, 1e4, 4), np.geomspace(5, 50, 4)
    study = PlaneStudy(System(), Newmark(1, 1, 500), 2.76, K=K, D=D, transient=50, sample=10)
    there = {"out": url, "scheduler": address, "cells_per_chunk": 4}
    first = sweep(study, **there)
    xarray.testing.assert_equal(first, sweep(study, cells_per_chunk=4))
    again = sweep(study, **there)
    assert (first.attrs["computed"], again.attrs["reused"]) == (16, 16)


def test_another_engine_on_a_worker_is_refused(cluster, monkeypatch):
    address, _ = cluster
    monkeypatch.setattr("vibroscope.engine.sweeps.cluster.engine_digest", lambda: "other")
    with pytest.raises(ValueError, match="another engine"):
        swept(scheduler=address)


def test_a_worker_that_is_killed_changes_nothing(cluster, tmp_path):
    address, workers = cluster
    victim = workers[0]

    def kill(now):
        if now.done >= 8 and victim.poll() is None:
            os.kill(victim.pid, signal.SIGKILL)
            victim.wait(PATIENCE)

    found = swept(tmp_path / "cluster.zarr", scheduler=address, progress=kill)
    assert victim.poll() == -signal.SIGKILL
    assert found.attrs["computed"] == 64
    swept(tmp_path / "here.zarr")
    assert files(tmp_path / "cluster.zarr") == files(tmp_path / "here.zarr")
    assert swept(tmp_path / "here.zarr", scheduler=address).attrs["reused"] == 64


def test_an_address_without_a_scheduler_is_refused(monkeypatch):
    monkeypatch.setattr("vibroscope.engine.sweeps.cluster.ANSWER_SECONDS", 0.5)
    with pytest.raises(OSError, match="no Dask scheduler answers"):
        swept(scheduler="tcp://127.0.0.1:9")


@pytest.mark.parametrize("found", every(["by waiting", "by fetching"]))
def test_a_scheduler_that_is_lost_is_one_error_and_what_is_stored_is_kept(tmp_path, caplog, found):
    def kill(now):
        if now.done >= 8:
            processes[-1].kill()
            if found == "by fetching":  # a result that was announced cannot be connected to
                while distributed.get_client().status == "running":
                    time.sleep(0.01)
                raise OSError("Timed out trying to connect")

    with running() as (address, processes), pytest.raises(OSError, match="was lost: run the same again"):
        swept(tmp_path / "a.zarr", scheduler=address, progress=kill)
    assert not caplog.records
    assert swept(tmp_path / "a.zarr").attrs["reused"] >= 8
