"""Results as labelled arrays, and how they show themselves."""

import numpy as np
import pytest
from vibroscope.engine import ComparisonQuestion, Newmark, Record, Reference, System, compare, simulate

ETA = 2.76
PENALTY = Newmark(12000, 18, 2000)


@pytest.fixture(scope="module")
def run():
    return simulate(System(), ETA, PENALTY, periods=120, keep=20, record=Record(2, 100))


@pytest.fixture(scope="module")
def found():
    return compare(ComparisonQuestion(System(), ETA, PENALTY, periods=400, keep=20))


def test_a_run_as_dataset_holds_its_arrays(run):
    data = run.to_xarray()
    assert np.array_equal(data["section"], run.section)
    assert data["period"].values.tolist() == list(range(101, 121))
    assert np.array_equal(data["section"].sel(coordinate="xi2"), run.section[:, 2])
    assert np.array_equal(data["displacement"].sel(body=2), run.trajectory.displacement[1])
    assert np.array_equal(data["contact"].sel(edge="end"), run.contacts[:, 1])
    assert data.sizes["impact"] == len(run.impacts)
    assert all(variable.attrs["units"] for variable in data.data_vars.values())
    assert data.attrs["eta"] == ETA


def test_a_run_without_samples_has_none():
    data = simulate(System(), ETA, Reference(), periods=3, keep=3).to_xarray()
    assert "force" not in data
    assert data.sizes["period"] == 3


def test_a_comparison_as_dataset_adds_up(found):
    data = found.to_xarray()
    parts = sum(data[name] for name in found.part_names)
    assert float(abs(parts - data["total"]).max()) < 1e-12
    difference = data["solution"].sel(run="penalty") - data["solution"].sel(run="reference")
    assert np.array_equal(difference, data["total"])
    assert data.attrs["total"] == found.total


def test_a_comparison_without_series_says_so():
    early = compare(ComparisonQuestion(System(), ETA, Newmark(1e12, 0, 4), periods=50, keep=10))
    assert early.parts is None
    with pytest.raises(ValueError, match="ended early"):
        early.to_xarray()
    assert "no pointwise difference" in repr(early)
    assert "Comparison" in early._repr_html_()


def test_results_show_themselves_in_a_line(run, found):
    for result in (run, found):
        assert len(repr(result)) < 160
        assert "newmark" in repr(result)
        assert "<div" in result._repr_html_()
