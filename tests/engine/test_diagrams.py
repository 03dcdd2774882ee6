"""The bifurcation diagrams that the explorer opens with, and the files that hold them."""

import numpy as np
import pytest
from vibroscope.engine import EtaStudy, Reference, System, sweep
from vibroscope.engine.sweeps import cache


@pytest.mark.parametrize("kind", ["table", "derived"])
def test_the_shipped_diagram_is_up_to_date_and_right(kind):
    """`make diagram` renews it. A part is computed anew: equal where periodic, equal in extent where chaotic."""
    method = Reference(kind)
    shipped = cache.load_diagram(cache.shipped_path(method), cache.diagram_study(System(), method).key)
    assert shipped is not None, "assets/diagrams is of another engine: run `make diagram`"
    assert len(shipped.eta) >= 1000
    rows = np.arange(0, len(shipped.eta), 40)
    again = sweep(EtaStudy(System(), method, values=shipped.eta[rows]))
    for row, one, two in zip(rows, again["xi1"].values, again["xi2"].values, strict=True):
        then, now = shipped.displacement[:, row], np.stack([one, two])
        if np.ptp(np.sort(now[1])[::25]) == 0 or np.allclose(now[:, :-8], now[:, 8:], atol=1e-4):
            np.testing.assert_allclose(then, now, atol=1e-4)
        else:
            # equal on one machine; on another, rounding makes it another sample of the same distribution
            apart = np.abs(np.sort(then, axis=1) - np.sort(now, axis=1)).mean(axis=1)
            assert (apart < 0.25 * np.ptp(now, axis=1) + 1e-4).all()


@pytest.fixture
def short(tmp_path, monkeypatch):
    monkeypatch.setenv("VIBROSCOPE_CACHE_DIR", str(tmp_path))
    monkeypatch.setattr(cache, "GRID", np.array([2.76, 3.25]))
    return System(restitution=0.45)


def test_a_diagram_is_computed_once_and_kept(short):
    seen = []
    first = cache.diagram(short, Reference(), progress=seen.append)
    again = cache.diagram(short, Reference(), progress=seen.append)
    assert (seen[-1].computed, seen[-1].reused) == (0, 2)
    assert any(progress.computed == 2 for progress in seen)
    np.testing.assert_array_equal(first.displacement, again.displacement)
    assert first.displacement.shape == (2, 2, 50)


def test_a_shipped_diagram_is_read_only_while_it_is_of_this_engine(short, tmp_path, monkeypatch):
    study = cache.diagram_study(short, Reference())
    path = tmp_path / "table.npz"
    shown = cache.Diagram(np.array([1.0]), np.ones((2, 1, 50), np.float32))
    monkeypatch.setattr(cache, "shipped_path", lambda method: path)
    cache.save_diagram(path, study.key, shown)
    assert cache.diagram(short, Reference()).eta == [1.0]
    cache.save_diagram(path, "of another engine", shown)
    assert len(cache.diagram(short, Reference()).eta) == 2


@pytest.mark.parametrize(
    "damage", [lambda data: data[: len(data) // 2], lambda data: b"", lambda data: data[:-30] + bytes(30)]
)
def test_a_damaged_file_is_not_shown(tmp_path, damage):
    path = tmp_path / "diagram.npz"
    cache.save_diagram(path, "key", cache.Diagram(np.array([1.0]), np.ones((2, 1, 50), np.float32)))
    assert cache.load_diagram(path, "key") is not None
    path.write_bytes(damage(path.read_bytes()))
    assert cache.load_diagram(path, "key") is None


def test_a_cache_that_cannot_be_written_costs_only_time(short, tmp_path, monkeypatch):
    blocked = tmp_path / "file"
    blocked.write_text("not a folder")
    monkeypatch.setenv("VIBROSCOPE_CACHE_DIR", str(blocked))
    assert cache.diagram(short, Reference()).displacement.shape == (2, 2, 50)
