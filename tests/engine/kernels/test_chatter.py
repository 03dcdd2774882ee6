"""The end of a chatter, summed in closed form, against a truth with all its impacts."""

import numpy as np
import pytest
from vibroscope.engine import Excitation, Reference, System, simulate
from vibroscope.engine.drivers import event_driven
from vibroscope.engine.drivers.event_driven import COMPLETION
from vibroscope.engine.drivers.parameters import parameters_of
from vibroscope.engine.kernels.event_driven.events import can_sum, sum_up
from vibroscope.engine.kernels.event_driven.setup import set_up_events
from vibroscope.engine.kernels.event_driven.state import SYSTEM
from vibroscope.engine.kernels.parameters import no_keys

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


def test_a_motion_that_has_died_away_has_the_same_sum():
    """Without excitation a motion of any size takes the same time; 2⁻⁷⁰⁰ squared is zero by rounding."""
    system, method = System(excitation=Excitation(base=0.0)), Reference(threshold=0.0)
    packed = SYSTEM.zeros()
    set_up_events(packed, no_keys(), np.array(parameters_of(system, 1.0, method)), True, np.zeros(2), COMPLETION)
    p = SYSTEM.read(packed)
    scale, start = 2.0**-700, np.array([1.0, 0.5, 0.0, 1e-8, 0.0, 0.0])
    (s, x, v), (s_small, x_small, v_small) = (
        sum_up(p.flight, tuple(z.tolist()), 0.5, p.mass_share, p.scratch) for z in (start, scale * start)
    )
    assert (s_small, x_small, v_small) == (s, scale * x, scale * v)
    assert can_sum(p.flight, tuple((scale * start).tolist()), 0.5, COMPLETION, p.scratch)


def test_a_free_vibration_ends_however_far_it_dies_away():
    """Beyond 1e-308, where the sum of a chatter was not a number, and the run did not end."""
    free = System(excitation=Excitation(base=0.0))
    found = simulate(free, 0.6, Reference(threshold=0.0), periods=450, keep=1, initial=(1.0, 0.0, 1.0, 0.5))
    assert found.ok
    assert np.abs(found.section).max() < 1e-300
