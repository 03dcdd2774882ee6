"""The columns of the figures are small, and keep what matters."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from vibroscope.app.explorer.compute import compute_runs
from vibroscope.app.explorer.present import envelope, present
from vibroscope.app.explorer.presets import scenes
from vibroscope.app.explorer.state import Setting
from vibroscope.app.runtime.cache import Cache
from vibroscope.app.studies.bifurcation import raster

CACHE = Cache(48)


def runs_at(**numbers):
    return compute_runs(Setting(**numbers), cache=CACHE)


def scene_runs(key):
    scene = scenes()[key]
    return runs_at(eta=scene.setting.eta, K=scene.setting.K, D=scene.setting.D, steps=scene.setting.steps)


@pytest.mark.parametrize("key", ["A", "B", "C", "D", "9B", "14A"])
def test_an_update_stays_within_fifty_kilobytes_of_float32(key):
    columns = present(scene_runs(key))
    assert {column.dtype for source in columns.values() for column in source.values()} == {np.dtype(np.float32)}
    assert sum(column.nbytes for source in columns.values() for column in source.values()) <= 50_000
    for source in columns.values():
        assert len({len(column) for column in source.values()}) == 1


@pytest.mark.parametrize("key", ["A", "B", "C", "D", "9B"])
def test_the_force_keeps_the_peak_of_every_contact(key):
    runs = scene_runs(key)
    shown = present(runs)["force_penalty"]
    trace, period = runs.penalty.trace, 2 * np.pi / runs.setting.eta
    start = runs.penalty.response.window[1] - 2 * period
    bin_width, compared = 2 / 400, 0
    for begin, end in (runs.penalty.response.contacts - start) / period:
        inside = (trace.time - start >= begin * period) & (trace.time - start <= end * period)
        if begin < 0 or end > 2 or not inside.any():
            continue
        near = (shown["t"] >= begin - bin_width) & (shown["t"] <= end + bin_width)
        assert shown["force"][near].max() >= np.float32(trace.force[inside].max())
        compared += 1
    assert compared


def test_phase_plots_hold_both_velocities_of_every_impact():
    runs = scene_runs("A")
    shown = present(runs)["phase_reference"]
    impacts = runs.reference.response.impacts
    drawn = {tuple(np.float32(row)) for row in zip(shown["v1"], shown["v2"], strict=True)}
    last_period = impacts.time > runs.reference.orbit.time[0]
    assert last_period.sum() == 10
    for before, after in zip(impacts.velocity_before[last_period], impacts.velocity_after[last_period], strict=True):
        assert tuple(np.float32(before)) in drawn
        assert tuple(np.float32(after)) in drawn


def test_corners_of_the_phase_plots_lie_where_each_body_is():
    """The bodies are apart by the clearance where they touch."""
    columns = present(runs_at(bodies="two", clearance=3.0, eta=1.2, K=2000.0, D=8.0))
    shown, drawn = columns["phase_reference"], columns["displacements"]
    for body in "12":
        far = np.abs(drawn[f"reference{body}"]).max()
        assert np.abs(shown[f"x{body}"]).max() == pytest.approx(far, rel=0.02)


def test_a_contact_that_the_window_cuts_has_no_impulse_in_the_figure():
    """The scene repeats every period: what is left of an impulse would look like another one."""
    shown = present(scene_runs("9B"))["impulse_penalty"]["impulse"]
    assert len(shown) >= 1
    assert shown == pytest.approx(shown[0], rel=0.05)


def test_impulses_and_strips_show_every_impact_of_the_two_periods():
    columns = present(scene_runs("A"))
    assert len(columns["impulse_reference"]["t"]) == 20
    lengths = columns["strip_reference"]["right"] - columns["strip_reference"]["left"]
    assert (lengths == 0).sum() == 20
    assert 2 <= (lengths > 0.1).sum() <= 3
    assert all(c.min() >= 0 and c.max() <= 2 for c in columns["strip_penalty"].values())


def test_absolute_displacement_adds_the_base():
    relative = present(runs_at())["displacements"]
    absolute = present(runs_at(frame="absolute"))["displacements"]
    base = np.cos(2 * np.pi * relative["t"])
    for name in ("reference1", "reference2", "penalty1", "penalty2"):
        np.testing.assert_allclose(absolute[name], relative[name] + base, atol=1e-5)


def test_a_diverged_penalty_run_leaves_its_columns_empty_and_the_reference_whole():
    columns = present(runs_at(eta=2.76, K=1e5, D=100.0, steps=100))
    for name in ("phase_penalty", "section_penalty", "strip_penalty", "force_penalty", "impulse_penalty"):
        assert all(len(column) == 0 for column in columns[name].values()), name
    assert np.isnan(columns["displacements"]["penalty1"]).all()
    assert np.isfinite(columns["displacements"]["reference1"]).all()
    assert len(columns["phase_reference"]["x1"]) > 200


@given(
    st.lists(st.sampled_from([0.0, 0.0, 0.0, 1.0, -2.0, 5.5]), min_size=3, max_size=400),
    st.integers(1, 50),
)
def test_thinning_keeps_the_ends_and_the_extremes_of_every_bin(values, bins):
    y = np.array(values)
    x = np.arange(len(y), dtype=float)
    kept_x, kept_y = envelope(x, y, bins)
    assert (np.diff(kept_x) > 0).all()
    assert np.array_equal(y[kept_x.astype(int)], kept_y)
    assert (kept_x[0], kept_x[-1]) == (0, len(y) - 1)
    # The drawn line reaches the extremes of every bin.
    edges = np.linspace(0, len(y), bins, endpoint=False).astype(int) if len(y) > 2 * bins else [0]
    drawn = np.interp(x, kept_x, kept_y)
    for part, line in zip(np.split(y, edges[1:]), np.split(drawn, edges[1:]), strict=True):
        assert line.min() <= part.min()
        assert line.max() >= part.max()


def test_the_flanks_of_a_short_force_are_upright():
    x = np.arange(1000.0)
    kept, _ = envelope(x, np.where((x > 332) & (x < 337), 1.0, 0.0), 10)
    assert {332, 333, 336, 337} <= set(kept)


def test_the_raster_puts_points_where_they_belong():
    eta = np.linspace(0.5, 4.0, 1401)
    picture = raster(eta, np.zeros((1401, 50)), (0.5, 4.0), (-1.0, 1.0), 480, 250)
    assert picture.shape == (250, 480)
    assert picture.dtype == np.uint8
    assert set(np.flatnonzero(picture.any(axis=1))) == {125, 126}
    assert (picture[125] == 255).all()


def test_the_raster_leaves_no_gaps_when_zoomed_in():
    eta = np.linspace(0.5, 4.0, 1401)
    picture = raster(eta, np.zeros((1401, 50)), (1.0, 1.02), (-1.0, 1.0), 480, 250)
    assert (picture[125] > 0).all()


def test_the_raster_ignores_what_is_not_a_number_or_out_of_view():
    values = np.full((10, 5), np.nan)
    values[3] = 99.0
    assert not raster(np.linspace(0.5, 4, 10), values, (0.5, 4.0), (-1.0, 1.0), 40, 30).any()
