"""Recommendations for the paper's system and six others, checked by runs that know nothing of the search."""

import pytest
from vibroscope.engine import recommend

from tests.recommended import APART, CLOSE, FORCED, LIVELY, PAPER, SOFTER, WALL, Question, question

CASES = [
    (PAPER, 2.76, 0.05),
    (PAPER, 3.25, 0.05),
    (PAPER, 1.08, 0.1),
    (PAPER, 1.18, 0.05),
    (PAPER, 2.45, 0.05),
    (PAPER, 2.2, 0.05),
    (CLOSE, 3.42, 0.05),
    (APART, 1.52, 0.05),
    (APART, 2.5, 0.05),
    (WALL, 2.71, 0.05),
    (WALL, 1.5, 0.1),
    (FORCED, 1.54, 0.05),
    (FORCED, 2.6, 0.1),
    (LIVELY, 2.0, 0.1),
    (SOFTER, 1.5, 0.05),
    (SOFTER, 2.3, 0.05),
]
FEWER = 0.55  # of the steps: nothing nearby keeps to the tolerances


@pytest.mark.parametrize(("system", "eta", "tolerance"), CASES)
def test_what_is_printed_is_true(system, eta, tolerance, report):
    found = recommend(question(system, eta, tolerance=tolerance))
    if not found.met:
        report(f"eta = {eta}: {found.reason}")
        assert found.reason
        return
    asked = Question(system, eta, tolerance)
    assert asked.complaints(found, 60) == []
    again = recommend(question(system, eta * (1 + 1e-12), tolerance=tolerance))
    assert (again.best.setting, again.ranges) == (found.best.setting, found.ranges)
    assert next(asked.cheaper(found, FEWER), None) is None
    report(f"eta = {eta}: {found.best.setting}, {found.best.error:.2%} and {found.best.robust:.2%}", inputs=1)
