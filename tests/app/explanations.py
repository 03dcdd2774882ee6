"""Runs and explanations of settings, for tests of the page: each is made once in a process."""

from functools import cache

from vibroscope.app.explorer.compute import compute_runs
from vibroscope.app.explorer.explanation import explain


@cache
def runs_of(setting):
    return compute_runs(setting)


@cache
def explained(setting):
    return explain(runs_of(setting))
