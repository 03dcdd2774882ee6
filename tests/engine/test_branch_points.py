"""What a branch says of itself by its points: where it is stable, and which multiplier is critical."""

import numpy as np
import pytest
from vibroscope.engine import POINT_KINDS, Branch, Point, branches_dataset

FAR = 0.1


def point(kind, value, index, *multipliers):
    values = np.array([*multipliers, *[FAR] * (4 - len(multipliers))], complex)
    return Point(kind, value, 1, values, np.zeros(4), ("impact",), np.array([0.5]), index)


def branch(largest, points=()):
    """Orbits at 0, 1, 2, … with these largest multipliers."""
    multipliers = np.full((len(largest), 4), FAR, complex)
    multipliers[:, 0] = largest
    values = np.arange(len(largest), dtype=float)
    sections = np.zeros((len(largest), 1, 4))
    return Branch("eta", 1, values, sections, multipliers, ((0, "impact"),), tuple(points), ("range", "range"))


def test_a_stable_range_ends_at_the_point_where_stability_is_lost():
    """It once ended with the last stable orbit, at 2.78775, beside a doubling at 2.78896."""
    doubling, fold = point("period doubling", 1.7, 1, -1.0), point("fold", 3.2, 3, 1.0)
    grazing = point("contact opens", 1.2, 1, 0.5)
    found = branch([0.5, 0.9, -1.1, -1.05, 0.9, 0.8], [grazing, doubling, fold])
    assert found.stable_ranges == ((0.0, 1.7), (3.2, 5.0))
    assert branch([0.5, 0.9, -1.1]).stable_ranges == ((0.0, 1.0),)  # no point is known between them


def test_on_the_unit_circle_no_orbit_counts_as_stable():
    """Where a branch bifurcates, rounding decides on which side a multiplier lies."""
    assert branch([0.5, 1 - 1e-10, 1.0, 1 + 1e-10, np.inf, np.nan]).stable.tolist() == [True] + 5 * [False]


def test_a_bifurcation_has_what_locates_and_what_confirms_it():
    for kind in POINT_KINDS.values():
        assert (kind.test is None) == (kind.confirmed is None)
        assert kind.test is not None or kind.multiplier is None
        assert kind.words() == kind.one != ""
        assert kind.words(2) == kind.several != ""


@pytest.mark.parametrize(
    ("found", "critical"),
    [
        (point("fold", 1.0, 0, -2.078, 1.0), 1.0),
        (point("fold", 1.0, 0, 8.45, 0.9999), 0.9999),
        (point("period doubling", 1.0, 0, 3.0, -1.0), -1.0),
        (point("Neimark-Sacker", 1.0, 0, 1.5, 0.6 + 0.8j, 0.6 - 0.8j), 0.6 + 0.8j),
        (point("grazing", 1.0, 0, np.inf, 1.0), np.inf),
    ],
)
def test_the_critical_multiplier_is_the_one_on_the_unit_circle(found, critical):
    """At a fold −2.078 was shown, which has nothing to do with it."""
    assert found.critical_multiplier == critical


def test_no_branches_are_a_dataset_too():
    empty = branches_dataset([], "eta")
    assert empty.sizes["orbit"] == empty.sizes["point"] == 0
    assert set(branches_dataset([branch([0.5, 0.6])]).variables) == set(empty.variables)
