"""General systems solved to 20 digits (assets/truth/systems.json, made by tests/data/make_hard.py; both say how)."""

import json
from pathlib import Path

import numpy as np
from vibroscope.engine import ExactPenalty, Excitation, Record, Reference, System, simulate

_FILE = Path(__file__).parents[1] / "assets" / "truth" / "systems.json"
CASES = {entry["name"]: entry for entry in json.loads(_FILE.read_text())["cases"]}
LIMIT = 1e-20  # a smaller threshold stands for its limit 0


def arguments(case):
    """(System, η, method) of a case."""
    entry = CASES[case]
    constants = {"mu" if name == "mass_ratio" else name: value for name, value in entry["system"].items()}
    system = System(**constants, excitation=Excitation(**entry["excitation"]))
    if entry["method"] == ExactPenalty.name:
        return system, entry["eta"], ExactPenalty(entry["K"], entry["D"])
    threshold = 0.0 if entry["threshold"] < LIMIT else entry["threshold"]
    return system, entry["eta"], Reference(entry["joint_damping"], threshold)


def states(case):
    """(n, 4) ndarray: ξ₁, ξ₁′, ξ₂, ξ₂′ at each τ of the case."""
    return np.array(CASES[case]["state"], dtype=float)


def run(case):
    """The response to a case, sampled at its instants."""
    entry, (system, eta, method) = CASES[case], arguments(case)
    periods = entry["periods"]
    options = {"periods": periods, "keep": periods, "record": Record(periods, len(entry["state"]) // periods)}
    return simulate(system, eta, method, initial=tuple(entry["start"]), **options)


def forces(case):
    """(n,) ndarray: the contact force at each τ of the case."""
    return np.array(CASES[case]["force"], dtype=float)


def events(case):
    """[(τ, kind, gap velocity before)], kinds as in hard.json; all impacts of a chatter are listed."""
    return [(float(t), kind, float(v)) for t, kind, v in CASES[case]["events"]]
