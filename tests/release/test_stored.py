"""Damaged stores, full disks, killed processes: a clear error or exactly the same numbers."""

import shutil
import signal
import subprocess
import sys
import time
from contextlib import suppress

import numpy as np
import pytest
import xarray
from vibroscope.engine import EtaStudy, Reference, System, sweep
from vibroscope.engine.sweeps.cache import Diagram, load_diagram, save_diagram

from tests.release.odd import damaged
from tests.release.test_cache import small_disk
from tests.served import ROOT
from tests.studies import sweep_of

ETAS = np.linspace(2.6, 3.3, 24)


def swept(out=None, **more):
    return sweep_of(
        EtaStudy, System(), Reference(), values=ETAS, transient=60, sample=10, out=out, cells_per_chunk=4, **more
    )


def test_damaged_sweeps(tmp_path, chance, inputs, report):
    """A damaged result is repaired or refused with an explanation, and never read as other numbers."""
    good, refused, mended = swept().load(), 0, 0
    swept(tmp_path / "whole.zarr")
    tried = max(10, inputs // 60)
    for number in range(tried):
        copy = tmp_path / f"{number}.zarr"
        shutil.copytree(tmp_path / "whole.zarr", copy)
        for path in chance.sample(sorted(path for path in copy.rglob("*") if path.is_file()), chance.randint(1, 3)):
            path.write_bytes(damaged(chance, path.read_bytes()))
        try:
            found = swept(copy).load()
        except ValueError as error:
            refused += bool(str(error))
        else:
            mended += 1
            xarray.testing.assert_equal(found, good)
        shutil.rmtree(copy)
    report(
        f"{tried} damaged sweeps: {refused} refused with an explanation, {mended} repaired to the same numbers",
        faults=1,
        inputs=tried,
    )


def test_damaged_diagrams(tmp_path, chance, inputs, report):
    path, missing = tmp_path / "a.npz", 0
    good = Diagram(ETAS, np.random.default_rng(0).random((2, 24, 10)).astype(np.float32))
    save_diagram(path, "key", good)
    content, tried = path.read_bytes(), max(100, inputs // 4)
    for _ in range(tried):
        path.write_bytes(damaged(chance, content))
        found = load_diagram(path, "key")
        missing += found is None
        if found is not None:
            np.testing.assert_array_equal(found.eta, good.eta)
            np.testing.assert_array_equal(found.displacement, good.displacement)
    report(f"{tried} damaged diagrams: {missing} count as missing, the others are unchanged", faults=1, inputs=tried)


def test_a_disk_that_fills_up_during_a_sweep(tmp_path, report):
    with small_disk(tmp_path / "disk", 700) as disk:

        def fill(now):
            if now.done >= 16:
                with suppress(OSError):
                    (disk / "filler").write_bytes(b"x" * 700_000)

        with pytest.raises(OSError, match="make room and give the same command again"):
            swept(disk / "a.zarr", progress=fill)
        (disk / "filler").unlink()
        rest = swept(disk / "a.zarr")
        assert rest.attrs["reused"] >= 4
        xarray.testing.assert_equal(rest.load(), swept().load())
        text = f"{rest.attrs['reused']} of 24 cells were stored and the rest followed once there was room"
    report(f"disk full during a sweep: {text}", faults=1)


KILLED = """
import sys
import numpy as np
from vibroscope.engine import EtaStudy, Reference, System, sweep
sweep(EtaStudy(System(), Reference(), values=np.linspace(2.6, 3.3, 400), transient=40, sample=10), cells_per_chunk=4,
      out=sys.argv[1], progress=lambda now: print(now.computed, now.reused, flush=True))
"""


def test_a_sweep_that_is_killed_repeatedly(tmp_path, chance, report):
    """At any moment: of the cells reported as done at most the two chunks in hand are computed again."""
    kills, kept, progress = 0, 0, (0, 0)
    while True:
        process = subprocess.Popen(
            [sys.executable, "-c", KILLED, str(tmp_path / "a.zarr")], stdout=subprocess.PIPE, text=True, cwd=ROOT
        )
        end = time.monotonic() + chance.uniform(0.2, 1.0)
        with process:
            for line in process.stdout:
                progress = tuple(map(int, line.split()))
                if time.monotonic() > end and progress[0] >= 4 and kills < 3:
                    process.send_signal(signal.SIGKILL)
                elif progress[0] == 0:
                    end = time.monotonic() + chance.uniform(0.0, 0.3)
        if process.returncode == 0:
            break
        assert process.returncode == -signal.SIGKILL
        kills += 1
        kept = sum(progress)
    assert kills
    assert progress[1] >= kept - 8
    whole = sweep(
        EtaStudy(System(), Reference(), values=np.linspace(2.6, 3.3, 400), transient=40, sample=10), keep=False
    )
    xarray.testing.assert_equal(xarray.open_zarr(tmp_path / "a.zarr").load(), whole.load())
    report(
        f"a sweep killed {kills} times: the same numbers, {progress[1]} of 400 cells from before the last kill",
        faults=1,
    )
