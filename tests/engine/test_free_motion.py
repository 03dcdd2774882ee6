"""Free vibrations: their own period, and what is counted of a run from its first instant on."""

import numpy as np
import pytest
from vibroscope.engine import (
    BranchQuestion,
    ComparisonQuestion,
    ExactPenalty,
    Newmark,
    Record,
    Reference,
    System,
    attractors,
    compare,
    find_branches,
    motion,
    repetition,
    simulate,
)
from vibroscope.engine.excitation import Excitation
from vibroscope.engine.motions.poincare_map import fate_of_disturbances

# A mass of natural frequency 1 beside a stop at its rest, which gives back all of its speed: flights of half a turn.
BOUNCING = System(wall=True, d1=0.0, clearance=0.0, restitution=1.0, excitation=Excitation(base=0.0))
THROWN = (0.0, 1.0, 0.0, 0.0)


@pytest.mark.parametrize(
    ("method", "period"),
    [
        (Reference(), np.pi),
        (ExactPenalty(10_000, 0.0), np.pi + np.pi / np.sqrt(10_001)),
        (Newmark(10_000, 0.0, 4000, located=True), np.pi + np.pi / np.sqrt(10_001)),
    ],
)
@pytest.mark.parametrize("eta", [1.0, 0.7377])
def test_an_elastic_free_vibration_repeats_with_a_period_of_its_own(method, period, eta):
    """It was called quasi-periodic, by the frequency eta, which drives nothing."""
    found = motion(BOUNCING, eta, method, initial=THROWN)
    assert found.type == "periodic"
    assert found.own_period == pytest.approx(period, rel=1e-3)
    assert repetition(found) == "repeats with a period of its own"
    assert "die away" not in found.reason
    assert found.energy_lost == pytest.approx(0.0, abs=1e-3)
    assert found.impulse > 0


def test_free_vibrations_from_several_starts_are_searched():
    """Whether a start leads to one that was known divided by its period, which is none of the excitation's."""
    found = attractors(BOUNCING, 0.7377, Reference(), starts=4)
    assert sum(each.share for each in found) == pytest.approx(1.0)
    assert any(np.isfinite(each.motion.own_period) for each in found)


@pytest.mark.parametrize(
    ("largest", "words"), [(1.0 - 1e-12, "neither grow nor die away"), (0.99, "die away"), (1.2, "grow")]
)
def test_disturbances_die_away_only_where_multipliers_are_below_one(largest, words):
    assert fate_of_disturbances(largest) == words


def test_what_happens_at_the_first_instant_is_counted():
    """Text and figures once counted 300 N s and 2 contacts where the run has 400 and 3."""
    options = {"periods": 2, "keep": 2, "initial": THROWN, "record": Record(2, 1000)}
    hard = motion(simulate(BOUNCING, 1.0, Reference(), **options))
    assert hard.impacts_per_period == 2
    assert hard.impulse == pytest.approx(4.0, rel=1e-4)
    soft = motion(simulate(BOUNCING, 1.0, ExactPenalty(10_000, 0.0), **options))
    assert soft.impacts_per_period == soft.contacts_per_period == soft.permanent_per_period + 2 == 2
    assert soft.impulse == pytest.approx(4.0, rel=1e-3)


PRESSED = {"d1": 0.0, "clearance": 0.0, "restitution": 0.5, "excitation": Excitation(constant1=49_050.0)}


def test_where_rounding_hides_orbits_an_error_says_so():
    bodies = System(**PRESSED)
    with pytest.raises(ValueError, match=r"overlap at rest by 49050 units of length, .*: give stiffer springs"):
        find_branches(BranchQuestion(bodies, 266.6, Reference(), over="base", low=0.9, high=1.15))
    found = motion(bodies, 266.6, Reference())
    assert (found.type, found.period) == ("undecided", 0)
    assert "rounding hides periodic motions" in found.reason


def test_a_ball_on_a_shaken_table_by_a_spring_of_next_to_nothing_repeats_every_period():
    """A branch of it came in 47 pieces, and its period doubled: rounding of a rest that lies far away."""
    found = motion(System(wall=True, **PRESSED), 266.6, Reference())
    assert (found.type, found.period) == ("periodic", 1)


@pytest.mark.parametrize("periods", [1, 2, 5])
def test_a_drop_that_comes_to_rest_is_compared_from_its_beginning(periods):
    """At rest the section repeats itself, and not what led there: the parts are those of the first period."""
    drop = System(wall=True, d1=0.05, restitution=0.5, excitation=Excitation(base=0.0, constant1=1.0))
    found = compare(
        ComparisonQuestion(
            drop, 0.2, Newmark(1000.0, 7.0, 20_000), periods=periods, keep=periods, initial=(-1.0, 0, 0, 0)
        )
    )
    assert found.difference.total < 0.1
    assert found.difference.parts["time_step"] < 0.005
    assert set(found.parts.shifts) == {0}
    split, of_step = found.split(), found.split_time_step()  # by further runs, which come to rest, too
    assert found.parts.relative(split.contact_time) < 0.1
    assert found.parts.relative(of_step.status) < 0.005
    assert split.in_step
    assert of_step.in_step


def test_a_repetition_that_rounding_decides_is_no_period():
    """A ball that sticks to its table once in some hundred periods: the run repeats itself after 187 of them.

    Between them a disturbance grows by e to the power of 0.77 a period.
    """
    table = Excitation(base=1.0, constant1=0.4905, held="acceleration")
    ball = System(wall=True, spring1=0.0, d1=0.0, clearance=0.0, restitution=0.7, excitation=table)
    found = motion(ball, 1.0, Reference())
    assert found.type == "undecided"
    assert "rounding decides after which period the motion repeats itself" in str(found.reason)
    assert found.lyapunov == -np.inf
