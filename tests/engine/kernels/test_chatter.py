"""The end of a chatter, summed in closed form, against a truth with all its impacts."""

import numpy as np
import pytest
from vibroscope.engine import Reference, simulate
from vibroscope.engine.drivers import event_driven

from tests import hard

CHATTER = "limit-pressed|2.76|0.9|table|1e-24"


def error_of(method):
    system, eta, _ = hard.arguments(CHATTER)
    n = hard.periods(CHATTER)
    section = simulate(system, eta, method, periods=n, keep=n, initial=hard.initial(CHATTER)).section
    return np.abs(section - hard.states(CHATTER)).max()


def slope_of(sizes, errors):
    return np.polyfit(np.log(sizes), np.log(errors), 1)[0]


def test_the_summed_chatter_is_exact_to_third_order(monkeypatch):
    """Error over the size of what is summed; the truth has 80 more impacts."""
    sizes, errors = np.geomspace(0.2, 2e-3, 15), []
    for completion in sizes:
        monkeypatch.setattr(event_driven, "COMPLETION", completion)
        errors.append(error_of(Reference(threshold=0.0)))
    assert slope_of(sizes, errors) == pytest.approx(3, abs=0.3)


def test_the_threshold_enters_in_the_first_power():
    sizes = np.geomspace(3e-2, 1e-6, 25)
    errors = [error_of(Reference(threshold=threshold)) for threshold in sizes]
    assert slope_of(sizes, errors) == pytest.approx(1, abs=0.1)
    assert error_of(Reference(threshold=0.0)) < 1e-2 * min(errors)
