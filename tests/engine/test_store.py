"""The bifurcation diagram, its key, and the files that hold it."""

import numpy as np
import pytest

from engine import Reference, System, bifurcation, store


@pytest.mark.parametrize("kind", ["table", "derived"])
def test_the_shipped_diagram_is_up_to_date_and_right(kind):
    """`make diagram` renews it. A part is computed anew: equal where periodic, equal in extent where chaotic."""
    method = Reference(kind)
    shipped = store.load_diagram(store.shipped_path(method), store.diagram_key(System(), method))
    assert shipped is not None, "assets/diagrams is of another engine: run `make diagram`"
    assert len(shipped.eta) >= 1000
    rows = np.arange(0, len(shipped.eta), 40)
    again = bifurcation(System(), shipped.eta[rows], method).displacement
    for row, now in zip(rows, np.moveaxis(again, 1, 0), strict=True):
        then = shipped.displacement[:, row]
        if np.ptp(np.sort(now[1])[::25]) == 0 or np.allclose(now[:, :-8], now[:, 8:], atol=1e-4):
            np.testing.assert_allclose(then, now, atol=1e-4)
        else:
            # equal on one machine; on another, rounding makes it another sample of the same distribution
            apart = np.abs(np.sort(then, axis=1) - np.sort(now, axis=1)).mean(axis=1)
            assert (apart < 0.25 * np.ptp(now, axis=1) + 1e-4).all()


def test_key_changes_with_every_number_and_with_the_sources(monkeypatch):
    keys = {
        store.diagram_key(System(), Reference()),
        store.diagram_key(System(restitution=0.6), Reference()),
        store.diagram_key(System(), Reference("derived")),
        store.diagram_key(System(), Reference(threshold=0.001)),
        store.diagram_key(System(), Reference(), periods=100),
        store.diagram_key(System(), Reference(), eta=store.GRID[:-1]),
    }
    monkeypatch.setattr(store, "source_digest", lambda folder: "another engine")
    assert len(keys | {store.diagram_key(System(), Reference())}) == 7


def test_a_diagram_is_computed_once_and_kept(tmp_path, monkeypatch):
    monkeypatch.setenv("VIBROSCOPE_CACHE_DIR", str(tmp_path))
    monkeypatch.setattr(store, "GRID", np.array([2.76, 3.25]))
    system, calls = System(restitution=0.45), []
    first = store.diagram(system, Reference(), progress=calls.append)
    again = store.diagram(system, Reference(), progress=calls.append)
    assert calls == [1, 2]
    np.testing.assert_array_equal(first.displacement, again.displacement)
    assert first.displacement.shape == (2, 2, 50)


@pytest.mark.parametrize(
    "damage", [lambda data: data[: len(data) // 2], lambda data: b"", lambda data: data[:-30] + bytes(30)]
)
def test_a_damaged_file_is_found_and_computed_anew(tmp_path, monkeypatch, damage):
    monkeypatch.setenv("VIBROSCOPE_CACHE_DIR", str(tmp_path))
    monkeypatch.setattr(store, "GRID", np.array([2.76, 3.25]))
    system = System(restitution=0.45)
    good = store.diagram(system, Reference())
    (path,) = tmp_path.glob("diagrams/*.npz")
    path.write_bytes(damage(path.read_bytes()))
    np.testing.assert_array_equal(store.diagram(system, Reference()).displacement, good.displacement)
    assert store.load_diagram(path, path.stem) is not None


def test_a_cache_that_cannot_be_written_costs_only_time(tmp_path, monkeypatch):
    blocked = tmp_path / "file"
    blocked.write_text("not a folder")
    monkeypatch.setenv("VIBROSCOPE_CACHE_DIR", str(blocked))
    monkeypatch.setattr(store, "GRID", np.array([2.76]))
    assert store.diagram(System(restitution=0.45), Reference()).displacement.shape == (2, 1, 50)
