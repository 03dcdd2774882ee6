"""Studies whose own options stand beside those of their run."""

from collections.abc import Callable
from dataclasses import fields

from vibroscope.engine import sweep
from vibroscope.engine.sweeps import RunOptions, Study

HOW = {"keep", *(each.name for each in fields(RunOptions))}


def sweep_of(make: Callable[..., Study], *problem, **options):
    """The result of the study that ``make`` gives, run as the options say that belong to no study."""
    how = {name: options.pop(name) for name in HOW & options.keys()}
    return sweep(make(*problem, **options), **how)
