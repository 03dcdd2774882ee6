"""Kernels also run uncompiled, are cached by their sources, and solve their own parts of the problem."""

import math
import os
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from engine.kernels.jit import source_digest
from engine.kernels.modes import Modes, at, bounds, make_ladder
from engine.kernels.root import first_root

ROOT = Path(__file__).parents[2]
PROBE = """
import numpy as np
from engine import *
for method in (Reference(), Newmark(12000, 18, 200)):
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


def test_results_are_the_same_without_the_compiler():
    """Not bit for bit: the compiler's libm may differ from Python's in the last place."""
    compiled, plain = run(PROBE).split(), run(PROBE, NUMBA_DISABLE_JIT="1").split()
    for one, other in zip(compiled, plain, strict=True):
        np.testing.assert_allclose(np.frombuffer(bytes.fromhex(one)), np.frombuffer(bytes.fromhex(other)), atol=1e-9)


def test_an_edit_in_any_kernel_changes_the_cache_folder(tmp_path):
    copy = tmp_path / "kernels"
    shutil.copytree(ROOT / "engine" / "kernels", copy, ignore=shutil.ignore_patterns("__pycache__"))
    before = source_digest(copy)
    assert before == source_digest()
    for path in copy.glob("*.py"):
        text = path.read_text()
        path.write_text(text + "\n# edited\n")
        assert source_digest(copy) != before
        path.write_text(text)


def test_a_read_only_cache_is_copied_not_ignored(tmp_path):
    """Numba passes over a read-only cache and compiles anew without a word. (Root may write anywhere: it is told.)"""
    cache = tmp_path / "cache"
    run(PROBE, VIBROSCOPE_CACHE_DIR=str(cache))
    kept = {path: path.stat().st_mtime_ns for path in cache.rglob("*.nb?")}
    read_only = "import os\nos.access = lambda path, mode: mode != os.W_OK\n"
    asked = "from engine.kernels.reference import march; print(sum(march.stats.cache_hits.values()))"
    asked = f"\n{asked}\nprint(numba.config.CACHE_DIR)"
    told = run(read_only + "import numba\n" + PROBE + asked, VIBROSCOPE_CACHE_DIR=str(cache))
    hits, folder = told.split()[-2:]
    assert int(hits) > 0
    assert not folder.startswith(str(cache))
    assert not Path(folder).exists(), "the copy outlived its process"
    assert kept == {path: path.stat().st_mtime_ns for path in cache.rglob("*.nb?")}


def test_a_cache_folder_that_cannot_be_made_does_not_stop_the_engine(tmp_path):
    blocked = tmp_path / "file"
    blocked.write_text("no folder")
    run("import engine", VIBROSCOPE_CACHE_DIR=str(blocked))


amplitudes = st.complex_numbers(max_magnitude=5.0, allow_nan=False, allow_infinity=False)
poles = st.tuples(st.floats(0.0, 0.5), st.floats(0.1, 4.0)).map(lambda p: complex(-p[0], p[1]))
sums = st.builds(Modes, amplitudes, amplitudes, amplitudes, poles, poles, poles)


@settings(max_examples=300, deadline=None)
@given(sums)
def test_the_first_root_is_not_passed(modes):
    """Against 200,000 samples: none before the root is negative, and the root is one."""
    if at(modes, 0.0)[0] < 1e-6:
        return
    arrival = first_root(modes, make_ladder(modes[3:], modes[3:]), False, 0, 0.0, 20.0)
    s = arrival.s
    assert arrival.evaluations < 2000
    t = np.linspace(0.0, min(s, 20.0), 200_000)
    f = sum((c * np.exp(pole * t)).real for c, pole in zip(modes[:3], modes[3:], strict=True))
    scale = bounds(modes)[0]
    assert f.min() > -1e-12 * scale
    if math.isfinite(s):
        assert abs(at(modes, s)[0]) < 1e-12 * scale


@given(st.floats(-12, -1))
def test_a_double_root_is_told_by_its_sign(exponent):
    """1 − cos s ± δ: a dip to −δ is found, one to +δ is passed over."""
    delta, poles = 10.0**exponent, (1j, complex(-1e-18, 0.0), 1j)
    for sign in (1, -1):
        modes = Modes(complex(-1.0), complex(1.0 + sign * delta), 0j, *poles)
        turned = Modes(complex(-math.cos(3.0), -math.sin(3.0)), *modes[1:])  # the dip at s = 2π − 3
        s = first_root(turned, make_ladder(poles, poles), False, 0, 0.0, 5.0).s
        assert math.isinf(s) == (sign > 0)
        if sign < 0:
            assert s == pytest.approx(2 * math.pi - 3 - math.acos(1 - delta), abs=1e-9)
