"""The hard cases solved to 25 digits (assets/truth/hard.json, made by tests/data/make_hard.py; both say how)."""

import json
from pathlib import Path

import numpy as np
from vibroscope.engine import System
from vibroscope.engine.methods import ExactPenalty, Reference

CASES = json.loads((Path(__file__).parents[1] / "assets" / "truth" / "hard.json").read_text())["cases"]
_METHODS = {method.name: method for method in (Reference, ExactPenalty)}


def names(*groups):
    """Cases of the groups named (what stands before the first "|"), in the order of the file; all if none is named."""
    return [name for name in CASES if not groups or name.split("|")[0] in groups]


def arguments(case, **changed):
    """(System, η, method) of a case; ``changed`` replaces attributes of the method, such as threshold=0."""
    entry = CASES[case]
    numbers = {name: value for name, value in (entry["method"] | changed).items() if name != "name"}
    return System(**entry["system"]), entry["eta"], _METHODS[entry["method"]["name"]](**numbers)


def periods(case):
    """Excitation periods of a case."""
    return CASES[case]["periods"]


def initial(case):
    """ξ₁, ξ₁′, ξ₂, ξ₂′ at τ = 0."""
    return tuple(CASES[case]["initial"])


def status(case):
    """The status that the run must end with."""
    return CASES[case]["status"]


def states(case):
    """(periods, 4) ndarray: ξ₁, ξ₁′, ξ₂, ξ₂′ at T, 2T, …"""
    return np.array(CASES[case]["states"], dtype=float)


def events(case):
    """[(τ, kind, gap velocity before)], oldest first, kinds as in truth.json.

    Reference: 0 impact, 1 permanent contact begins, 2 it ends. Exact penalty: 0 contact begins, 1 contact ends. In the
    endless chatters (group "limit") the impacts slower than 1e-6 are left out; CASES[case]["omitted"] counts them.
    """
    return [(float(t), kind, float(v)) for t, kind, v in CASES[case]["events"]]


def energy(case):
    """{"work", "damped", "lost"} of the whole run (what hard.json says of them), or None where it was not computed."""
    budget = CASES[case].get("energy")
    return budget and {name: float(value) for name, value in budget.items() if name != "residual"}
