"""Whatever can be cancelled asks in each of its runs: a long period or many contacts make no run deaf."""

import pytest
from vibroscope.engine import (
    Cancelled,
    Cells,
    ComparisonQuestion,
    Newmark,
    Reference,
    System,
    attractors,
    compare,
    lyapunov,
    motion,
    recommend,
    run_cells,
    steady,
    verdict,
)
from vibroscope.engine.drivers.base import Driver
from vibroscope.engine.energy import events

from tests.recommended import question
from tests.share import every


def never():
    return False


def judged(eta, penalty, **how):
    """A comparison with all that the verdict on it runs."""
    comparison = compare(ComparisonQuestion(System(), eta, penalty, periods=60, keep=10, **how), cancelled=never)
    verdict(comparison, cancelled=never)
    if comparison.complete:
        comparison.split(never)
    comparison.with_evidence(never)


CASES = {
    "displacements": lambda: judged(2.76, Newmark(12_000, 18, 500)),
    "sections": lambda: judged(1.7, Newmark(1000, 18, 300)),
    "blown up": lambda: judged(2.76, Newmark(60_000, 1, 100)),
    "another motion": lambda: judged(3.14, Newmark(4000, 18, 2000)),
    "located": lambda: judged(0.01, Newmark(500, 18, 300, located=True)),
    "motion": lambda: motion(System(), 1.7, Newmark(1000, 18, 300), cancelled=never),
    "attractors": lambda: attractors(System(), 2.76, Reference(), starts=3, cancelled=never),
    "exponent": lambda: lyapunov(System(), 1.7, Reference(), periods=256, cancelled=never),
    "search": lambda: recommend(question(System(), 1.08, tolerance=0.3, steps_max=50), threads=1, cancelled=never),
}


@pytest.mark.parametrize("name", every(CASES))
def test_every_run_asks_whether_it_is_cancelled(name, monkeypatch):
    deaf, runs = [], []
    advance, balance = Driver.advance, events.balance_between_events

    def noted(driver, stop, cancelled, *, record):
        runs.append(driver)
        if cancelled is None:
            deaf.append(driver.problem)
        return advance(driver, stop, cancelled, record=record)

    def noted_balance(response, rows, cancelled=None):
        if cancelled is None:
            deaf.append("energy balance")
        return balance(response, rows, cancelled)

    monkeypatch.setattr(Driver, "advance", noted)
    monkeypatch.setattr("vibroscope.engine.energy.balance.balance_between_events", noted_balance)
    CASES[name]()
    assert len(runs) > 1 or name == "exponent"
    assert not deaf


COMPARED = ComparisonQuestion(System(), 2.76, Newmark(100, 50, 2000))
STOPPED = {
    "motion": lambda stop: motion(System(), 1.7, Newmark(12_000, 18, 2000), cancelled=stop),
    "steady": lambda stop: steady(System(), 2.76, Reference(), cancelled=stop),
    "cells": lambda stop: run_cells(Cells(System(), [1.7], Reference()), transient=1, sample=1, cancelled=stop),
    "range": lambda stop: recommend(question(System(), [2.7, 2.76]), cancelled=stop),
    "verdict": lambda stop: verdict(compare(COMPARED), cancelled=stop),
}


@pytest.mark.parametrize("name", STOPPED)
def test_what_is_cancelled_before_it_begins_raises(name):
    with pytest.raises(Cancelled):
        STOPPED[name](lambda: True)
