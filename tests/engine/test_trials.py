"""Trial runs of a search: the same as single runs, each made once, and not more than needed."""

from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
from vibroscope.engine import Newmark, Record, Reference, System, recommend, simulate, steady
from vibroscope.engine.divergence.error import Target
from vibroscope.engine.drivers import newmark
from vibroscope.engine.recommendation.trials import NewmarkSetting, Trials

from tests.recommended import question

ETA = 2.76


@pytest.fixture
def trials():
    """Trials from the reference's motion, with constant steps."""
    with ThreadPoolExecutor(2) as pool:
        yield Trials(steady(System(), ETA, Reference()), Newmark(1, 0, 1000), pool)


@pytest.fixture
def runs(monkeypatch):
    """The settings of all trial runs."""
    made, run = [], Trials.run
    monkeypatch.setattr(Trials, "run", lambda self, *asked, **how: made.append(asked) or run(self, *asked, **how))
    return made


@pytest.mark.parametrize("located", [False, True])
@pytest.mark.parametrize(
    ("system", "eta"),
    [
        (System(), ETA),  # period 1
        (System(), 3.25),  # 2
        (System(wall=True), 2.2),  # 1
        (System(clearance=0.4, clearance2=1.1, stiffness_factor2=2.0, damping_factor2=1.4), 3.25),  # 2
    ],
)
def test_the_error_of_a_trial_is_that_of_a_single_run(system, eta, located):
    found = steady(system, eta, Reference())
    rng = np.random.default_rng(6)
    with ThreadPoolExecutor(1) as pool:
        trials = Trials(found, Newmark(1, 0, 1000, located=located), pool)
        for _ in range(6):
            K, steps = np.exp(rng.uniform(np.log(20), np.log(20_000))), int(rng.integers(16, 300))
            setting = NewmarkSetting(K, 0.15 * np.sqrt(K), steps)
            method, record = Newmark(*setting, located=located), Record(12, 32, steps)
            run = simulate(system, eta, method, periods=62, keep=12, initial=found.state, record=record)
            error, cost = trials.run(setting, tuple(found.state.tolist()), 62, 12, 32)
            assert error == Target(found.response, found.period).error(run)
            assert cost == run.cost.steps / 62


def test_contacts_that_fill_their_buffer_change_no_trial(trials, monkeypatch):
    setting = NewmarkSetting(20_000.0, 20.0, 3000)
    usual = trials.screen(setting)
    monkeypatch.setattr(newmark, "CAPACITY", 3)
    with ThreadPoolExecutor(1) as pool:
        again = Trials(steady(System(), ETA, Reference()), Newmark(1, 0, 1000), pool).screen(setting)
    assert again == usual


def test_a_trial_that_diverges_has_no_error(trials):
    assert trials.screen(NewmarkSetting(1e6, 1e3, 16)).error == np.inf


def test_a_short_run_is_made_once(trials, runs):
    setting = NewmarkSetting(2000.0, 9.0, 128)
    assert trials.screen(setting, 2) == trials.screen(setting, 2)
    assert len(runs) == 4  # itself, with half the step, two neighbours


def test_a_search_makes_few_runs(runs):
    """It confirms a few settings at a time, and none that a cheaper one beats."""
    assert recommend(question(System(), 1.08, tolerance=0.1)).met
    assert len(runs) < 4_300
