"""Kernels also run uncompiled, and their machine code is cached by the digest of their sources."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from vibroscope.engine.drivers.code_cache import complete_mark
from vibroscope.engine.kernels.compile.options import source_digest

ROOT = Path(__file__).parents[3]
PROBE = """
import numpy as np
from vibroscope.engine import *
for method in (Reference(), Reference(threshold=0), ExactPenalty(12000, 18), Newmark(12000, 18, 200)):
    for eta in (1.08, 2.76):
        r = simulate(System(), eta, method, periods=4, keep=4, record=Record(2, 50))
        print(r.section.tobytes().hex(), r.impacts.time.tobytes().hex(), r.contacts.tobytes().hex())
"""


def run(code, **environment):
    done = subprocess.run(
        [sys.executable, "-c", code],
        cwd=ROOT,
        env={**os.environ, **environment},
        capture_output=True,
        text=True,
        timeout=300,
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


@pytest.fixture(scope="module")
def compiled():
    """What the probe prints with machine code of the cache of all tests, which has it from then on."""
    return run(PROBE)


def test_results_are_the_same_without_the_compiler(compiled):
    """Not bit for bit: the compiler's libm may differ from Python's in the last place."""
    plain = run(PROBE, NUMBA_DISABLE_JIT="1")
    for one, other in zip(compiled.split(), plain.split(), strict=True):
        np.testing.assert_allclose(np.frombuffer(bytes.fromhex(one)), np.frombuffer(bytes.fromhex(other)), atol=1e-9)


def test_an_edit_in_any_kernel_changes_the_cache_folder(tmp_path):
    copy = tmp_path / "kernels"
    shutil.copytree(ROOT / "engine" / "kernels", copy, ignore=shutil.ignore_patterns("__pycache__"))
    before = source_digest(copy)
    assert before == source_digest()
    for path in copy.rglob("*.py"):
        text = path.read_text()
        path.write_text(text + "\n# edited\n")
        assert source_digest(copy) != before
        path.write_text(text)


@pytest.mark.usefixtures("compiled")
def test_a_read_only_cache_is_copied_not_ignored(tmp_path):
    """Numba ignores a read-only cache and compiles anew. (Root may write anywhere, so os.access is replaced.)"""
    cache = tmp_path / "cache"
    shutil.copytree(complete_mark().parent, cache / complete_mark().parent.name)
    files = {path: path.stat().st_mtime_ns for path in cache.rglob("*.nb?")}
    read_only = "import os\nos.access = lambda path, mode: mode != os.W_OK\n"
    asked = "from vibroscope.engine.kernels.event_driven.integrate import integrate\n"
    asked += "print(sum(integrate.stats.cache_hits.values()))"
    asked = f"\n{asked}\nprint(numba.config.CACHE_DIR)"
    printed = run(read_only + "import numba\n" + PROBE + asked, VIBROSCOPE_CACHE_DIR=str(cache))
    hits, folder = printed.split()[-2:]
    assert int(hits) > 0
    assert not folder.startswith(str(cache))
    assert not Path(folder).exists(), "the copy outlived its process"
    assert files == {path: path.stat().st_mtime_ns for path in cache.rglob("*.nb?")}


def test_a_cache_folder_that_cannot_be_made_does_not_stop_the_engine(tmp_path):
    blocked = tmp_path / "file"
    blocked.write_text("no folder")
    run("import vibroscope.engine", VIBROSCOPE_CACHE_DIR=str(blocked))


CALL = """
import numpy as np
from vibroscope.engine.kernels.linear.matrices import eliminate, solve
{}
for each in (solve, eliminate):
    print(sum(each.stats.cache_hits.values()), sum(each.stats.cache_misses.values()))
"""
SOLVE, ELIMINATE = "solve(np.eye(2), np.ones((2, 1)))", "eliminate(np.eye(2), np.ones((2, 1)))"


def test_machine_code_is_kept_of_what_python_calls_alone(tmp_path):
    environment = {"VIBROSCOPE_CACHE_DIR": str(tmp_path)}
    assert run(CALL.format(SOLVE), **environment) == "0 1\n0 0\n"  # which has the other inside
    assert run(CALL.format(f"{SOLVE}\n{ELIMINATE}"), **environment) == "1 0\n0 1\n"
    assert run(CALL.format(f"{SOLVE}\n{ELIMINATE}"), **environment) == "1 0\n1 0\n"


def test_another_checkout_of_the_same_sources_has_a_mark_of_its_own(tmp_path):
    """Numba does not find the machine code of the other one, so that all has to be compiled."""
    assert complete_mark(tmp_path) != complete_mark()
    assert complete_mark(tmp_path) == complete_mark(tmp_path)
