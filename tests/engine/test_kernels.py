"""Kernels also run uncompiled, are cached by their sources, and keep the promises of their module docstrings."""

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
from mpmath import mp
from scipy.linalg import expm
from vibroscope.engine import Reference
from vibroscope.engine.drivers import event_driven as closed
from vibroscope.engine.kernels.compile.options import source_digest
from vibroscope.engine.kernels.equations.motion import joined, pressed, separated
from vibroscope.engine.kernels.linear import tables
from vibroscope.engine.kernels.linear.cos_sin import circle
from vibroscope.engine.kernels.linear.first_root import (
    NEWTON_LIMIT,
    NONE,
    first_root,
    in_interval,
    open_interval,
    to_bernstein,
)
from vibroscope.engine.kernels.linear.tables import POINTS, REACH, bend, full, make_scratch, tabulate
from vibroscope.engine.simulate import simulate

from tests import hard

ROOT = Path(__file__).parents[2]
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
    asked = "from vibroscope.engine.kernels.event_driven.integrate import march\n"
    asked += "print(sum(march.stats.cache_hits.values()))"
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
    run("import vibroscope.engine", VIBROSCOPE_CACHE_DIR=str(blocked))


# --------------------------------------------------------------------------------------------- the tables of a phase

GAP, FORCE = np.eye(6)[2], np.array([2.24, 0.05, 0.0, 0.0, 0.0, 0.0])
SCRATCH = make_scratch()


class Table:
    """A phase, its generator, and what it watches at many instants of a block, by another exponential."""

    SAMPLES = 4096

    def __init__(self, generator, eta, row, fastest):
        self.a, self.row, self.h = full(generator, eta), row, REACH / fastest
        self.phase = tabulate(generator, eta, row, self.h)
        self.length = POINTS * self.h
        step = expm(self.a * (self.length / self.SAMPLES))
        rows = [row]
        for _ in range(self.SAMPLES):
            rows.append(rows[-1] @ step)
        self.rows = np.array(rows)

    def value(self, s, z, derivative=0):
        return self.row @ np.linalg.matrix_power(self.a, derivative) @ expm(self.a * s) @ z

    def samples(self, z):
        return self.rows @ z


TABLES = {
    "flight": Table(separated(1.08, 2.41, 0.0033, 0.012), 1.08, GAP, 2.41),
    "flight, undamped": Table(separated(2.76, 2.41, 0.0, 0.0), 2.76, GAP, 2.76),
    "flight, resonant": Table(separated(1.0, 2.41, 0.0, 0.0), 1.0, GAP, 2.41),
    "flight, heavily damped": Table(separated(1.7, 2.41, 0.9, 0.95), 1.7, GAP, 2.41),
    "joined": Table(joined(1.08, 1.8, 0.033), 1.08, FORCE, 1.8),
    "pressed": Table(pressed(2.76, 2.41, 0.0033, 0.012, 0.8722, 12000.0, 18.0), 2.76, -GAP, 165.0),
    "pressed, critically": Table(pressed(2.76, 2.41, 0.0033, 0.012, 0.8722, 100.0, 6.8255), 2.76, -GAP, 20.0),
}
kinds = st.sampled_from(sorted(TABLES))
coordinates = st.floats(-5.0, 5.0)
angles = st.floats(0.0, 2 * math.pi)
states = st.builds(
    lambda x, v, g, u, turn: (x, v, g, u, math.cos(turn), math.sin(turn)),
    *4 * (coordinates,),
    angles,
)


def size(table, z):
    """The largest that the terms of the watched quantity get in the block."""
    return float((np.abs(table.rows) @ np.abs(z)).max()) + 1e-300


@pytest.mark.parametrize("kind", TABLES)
def test_tables_are_those_of_another_exponential(kind):
    table = TABLES[kind]
    for j in (1, 2, 7, 31, 64):
        exact = expm(table.a * (j * table.h))
        # entries of a stiff contact differ in size by K: each is judged by what its row and column hold
        scale = np.sqrt(np.abs(exact).max(axis=1)[:, None] * np.abs(exact).max(axis=0)[None, :])
        assert (np.abs(table.phase.moves[j - 1] - exact) < 1e-13 * scale + 1e-15).all()
        values = table.phase.rows[:, tables.VALUES + j - 1]
        np.testing.assert_allclose(values, table.row @ exact, atol=1e-13 * np.abs(table.row @ exact).max())
    powers = table.phase.rows[:, tables.POWERS : tables.FIRST]
    for u in (0.25, 0.5, 1.0):
        exact = table.row @ expm(table.a * (u * table.h))
        np.testing.assert_allclose(powers @ u ** np.arange(12), exact, atol=1e-14 * np.abs(exact).max())


@settings(max_examples=200, deadline=None)
@given(kinds, states, st.floats(0.0, 1.0))
def test_the_bend_bounds_the_curvature_everywhere(kind, z, where):
    table = TABLES[kind]
    curvature = abs(table.value(where * table.length, np.array(z), derivative=2))
    assert curvature * table.h**2 / 8 <= bend(table.phase, z) * (1 + 1e-12) + 1e-300


@given(st.floats(0.0, 1.0, exclude_max=True))
def test_the_circle_is_round(share):
    c, s = circle(share)
    with mp.workdps(30):
        assert abs(c - mp.cospi(2 * mp.mpf(share))) < 2 * 2.0**-52
        assert abs(s - mp.sinpi(2 * mp.mpf(share))) < 2 * 2.0**-52


# ------------------------------------------------------------------------------------------------- the first root


def root_of(table, z, order):
    """Where the first root lies, inf if there is none in the block."""
    i, u, slope, _ = first_root(table.phase, z, order, NEWTON_LIMIT, SCRATCH)
    return (math.inf if i == POINTS else (i + u) * table.phase.spacing), slope


def check(table, z, order, noise=1e-13):
    """No sample before the root is negative, and the root is one."""
    s, slope = root_of(table, z, order)
    scale, samples = size(table, np.array(z)), table.samples(np.array(z))
    before = np.arange(len(samples)) * (table.length / table.SAMPLES) < s
    assert samples[before].min() > -noise * scale
    if math.isfinite(s):
        assert 0 < s <= table.length
        assert abs(table.value(s, np.array(z))) < noise * scale
        assert slope <= 1e-9 * scale / table.h
    return s


@settings(max_examples=1000, deadline=None)
@given(kinds, states)
def test_the_first_root_is_not_passed(kind, z):
    table = TABLES[kind]
    if table.row @ z > 1e-9 * size(table, np.array(z)):
        check(table, z, 0)


def moved_exactly(table, z, s):
    """E(s) z to 30 digits."""
    with mp.workdps(30):
        return mp.expm(mp.matrix(table.a.tolist()) * mp.mpf(s)) * mp.matrix([mp.mpf(x) for x in z])


@settings(max_examples=60, deadline=None)
@given(st.floats(0.05, 3.5), st.sampled_from([1e-14, 1e-12, 1e-9, 1e-6, 1e-3]), st.floats(-3, 3), angles)
def test_a_dip_is_told_by_its_sign(when, depth, speed, turn):
    """The gap turns near ``when``, ± the depth from zero: found below, passed over above."""
    table = TABLES["flight"]
    for sign in (1, -1):
        there = np.array([-1.0, speed, sign * depth, 0.0, math.cos(turn), math.sin(turn)])
        bend2 = table.value(0.0, there, derivative=2)
        z = tuple(float(x) for x in moved_exactly(table, there, -when))
        at = moved_exactly(table, z, when)  # what rounding the start has made of the dip
        dip, late = float(at[2] - at[3] ** 2 / (2 * bend2)), float(at[3]) / bend2
        rounding = 4 * 2.0**-52 * size(table, np.array(z))
        earlier = table.samples(np.array(z))[: int(when / table.length * table.SAMPLES * 0.98)]
        if bend2 < 0.1 or abs(dip) < rounding or len(earlier) == 0 or earlier.min() <= 0:
            return  # no dip, rounding decides, or another root comes first
        s, _ = root_of(table, z, 0)
        if dip < 0:
            fall = math.sqrt(-2 * dip / bend2)
            assert s == pytest.approx(when - late - fall, abs=fall * (rounding / -dip + 5 * fall) + 1e-15)
        else:
            assert s > when


@settings(max_examples=300, deadline=None)
@given(st.lists(st.floats(0.01, 0.99), min_size=1, max_size=6), st.floats(-12, -2), st.booleans())
def test_the_first_of_many_roots_in_one_interval_is_found(roots, exponent, paired):
    """More than one change of sign: the interval is halved until one is left, down to roots 1e-12 apart."""
    roots = sorted({round(r, 2) for r in roots})
    if paired:
        roots = sorted([*roots, roots[0] + 10.0**exponent])
    terms = np.zeros(12)
    coefficients = np.array([1.0])
    for r in roots:
        coefficients = np.convolve(coefficients, [r, -1.0])  # (r − u), in powers of u
    terms[: len(coefficients)] = coefficients
    b = np.zeros(12)
    to_bernstein(terms, b)
    u, _ = open_interval(terms, b, SCRATCH)
    rounding = 64 * 2.0**-52 * np.polyval(np.abs(coefficients[::-1]), roots[0])
    slope = abs(np.prod([r - roots[0] for r in roots[1:]]))
    if slope > 10 * math.sqrt(rounding):
        assert abs(u - roots[0]) < 2 * rounding / slope
    else:  # a pair so close is known to the square root of rounding, or not told from a touch
        later = [r for r in roots if r > roots[0] + 0.005]
        near = 10 * math.sqrt(rounding / abs(np.prod([r - roots[0] for r in later])))
        assert abs(u - roots[0]) < near or (later and abs(u - later[0]) < 1e-5) or (u == NONE and not later)


@given(st.floats(0.05, 0.95), st.floats(-12, -1))
def test_a_touch_without_a_root_is_passed_over(where, exponent):
    terms, b = np.zeros(12), np.zeros(12)
    terms[:3] = where**2 + 10.0**exponent, -2 * where, 1.0
    to_bernstein(terms, b)
    assert open_interval(terms, b, SCRATCH)[0] == NONE


STARTS = {
    1: ("flight", (-0.5, 0.3, 0.0, 1.0, 1.0, 0.0)),
    2: ("flight", (-0.7, 0.3, 0.0, 0.0, 0.0, 1.0)),
    3: ("flight", (-2 * (2.41 * 0.012 - 0.0033) * -1.0 / (2.41**2 - 1), -1.0, 0.0, 0.0, 0.0, 1.0)),
    4: ("flight, undamped", (0.0, 0.0, 0.0, 0.0, -1.0, 0.0)),
}


@pytest.mark.parametrize("order", STARTS)
def test_a_start_on_the_surface_is_not_its_own_root(order):
    """f = 0 at the start with ``order`` − 1 derivatives: the root found is the next one."""
    kind, z = STARTS[order]
    table = TABLES[kind]
    for lower in range(1, order):
        assert abs(table.value(0.0, np.array(z), derivative=lower)) < 1e-14
    assert table.value(0.0, np.array(z), derivative=order) > 0.1
    s = check(table, z, order)
    assert math.isinf(s) or s > 0.1


@pytest.mark.parametrize("exponent", range(-300, 0, 23))
def test_a_flight_of_any_shortness_keeps_its_digits(exponent):
    """g = rs − as²/2 + …: lands at 2r/a."""
    table, rate = TABLES["flight"], 10.0**exponent
    z = 1.0, 0.0, 0.0, rate, 1.0, 0.0
    a = -table.value(0.0, np.array([*z[:3], 0.0, *z[4:]]), derivative=2)
    u, slope = in_interval(table.phase, z, 1, NEWTON_LIMIT, SCRATCH)
    if exponent < -8:
        assert u * table.h == pytest.approx(2 * rate / a, rel=100 * rate + 1e-14)
        assert slope == pytest.approx(-rate, rel=100 * rate + 1e-14)


# --------------------------------------------------------------------------------------------- the rest of a chatter

CHATTER = "limit-pressed|2.76|0.9|table|1e-24"


def error_of(method):
    system, eta, _ = hard.arguments(CHATTER)
    n = hard.periods(CHATTER)
    section = simulate(system, eta, method, periods=n, keep=n, initial=hard.initial(CHATTER)).section
    return np.abs(section - hard.states(CHATTER)).max()


def slope_of(sizes, errors):
    return np.polyfit(np.log(sizes), np.log(errors), 1)[0]


def test_the_completed_chatter_is_exact_to_third_order(monkeypatch):
    """Error against how far from its end a chatter is completed; the truth went through 80 more impacts."""
    sizes, errors = np.geomspace(0.2, 2e-3, 15), []
    for completion in sizes:
        monkeypatch.setattr(closed, "COMPLETION", completion)
        errors.append(error_of(Reference(threshold=0.0)))
    assert slope_of(sizes, errors) == pytest.approx(3, abs=0.3)


def test_the_threshold_enters_in_the_first_power():
    sizes = np.geomspace(3e-2, 1e-6, 25)
    errors = [error_of(Reference(threshold=threshold)) for threshold in sizes]
    assert slope_of(sizes, errors) == pytest.approx(1, abs=0.1)
    assert error_of(Reference(threshold=0.0)) < 1e-2 * min(errors)
