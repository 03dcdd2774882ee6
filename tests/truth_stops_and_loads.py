"""Free bodies, two stops, pulses and records to 20 digits (assets/truth/stops_and_loads.json, tests/data/make_hard.py).

What the numbers of a case mean is said in tests/data/high_precision/bodies.py.
"""

import json
import math
from dataclasses import replace
from pathlib import Path

import numpy as np
from vibroscope.engine import ExactPenalty, Excitation, Load, Record, Reference, System, simulate
from vibroscope.engine.simulate import simulate_load, under_load
from vibroscope.engine.transients.run import Instants

from tests.truth_systems import LIMIT

_FILE = Path(__file__).parents[1] / "assets" / "truth" / "stops_and_loads.json"
CASES = {entry["name"]: entry for entry in json.loads(_FILE.read_text())["cases"]}


def arguments(case):
    """(System, η, method) of a case without pulses and records."""
    return system_of(case), CASES[case]["frequency"], method_of(case)


def system_of(case):
    """The system of a case, without pulses and records."""
    entry = CASES[case]
    more = {key: value for key, value in method_numbers(case).items() if key == "restitution"}
    return System(**constants(entry), **more, excitation=excitation(entry))


def constants(entry):
    """The constants of the system, with ω₁ = 1, that are not those of its stops."""
    wall, spring, damper = len(entry["mass"]) == 1, entry["spring"], entry["damper"]
    found = {"clearance": entry["clearance"], "d1": damper[0] / 2, "spring1": spring[0]} | second_stop(entry)
    if wall:
        return found | {"wall": True}
    mu = entry["mass"][1]
    kappa = math.sqrt(spring[1] / mu)
    return found | {"mu": mu, "d3": None, "kappa": kappa, "d2": damper[1] / (2 * mu * (kappa or 1.0))}


def second_stop(entry):
    """The constants of the second stop, where there is one."""
    if "play" not in entry:
        return {}
    (first, second), clearance2 = entry["stops"], {"clearance2": entry["play"] - entry["clearance"]}
    if "restitution" in second:
        return clearance2 | {"restitution2": second["restitution"]}
    factors = {"stiffness_factor2": "stiffness", "damping_factor2": "damper"}
    return clearance2 | {name: second[key] / first[key] for name, key in factors.items()}


def excitation(entry):
    """Harmonic and constant loads."""
    names = {"base": "base", "body 1": "force1", "body 2": "force2"}
    found = {"base": 0.0} | {f"constant{i}": force for i, force in enumerate(entry["constant"], 1)}
    for each in entry["loads"]:
        if each["form"] == "harmonic":
            found |= {names[each["on"]]: each["amplitude"], f"{names[each['on']]}_phase": each["phase"]}
    return Excitation(**found)


def method_numbers(case, stop=1):
    """Of a stop: e, or K and the constant of the damper."""
    return CASES[case]["stops"][stop - 1]


def method_of(case):
    """Of the first stop."""
    entry, stop = CASES[case], method_numbers(case)
    if "stiffness" in stop:
        return ExactPenalty(stop["stiffness"], stop["damper"] / 2)
    return Reference("derived", 0.0 if entry["threshold"] < LIMIT else entry["threshold"])


def run(case, **law):
    """The response to a case, sampled at its instants; one period of it under a pulse or a record.

    ``law``: of a penalty solution under such a load, another law than spring and damper, with its numbers.
    """
    entry = CASES[case]
    start, count = tuple(entry["start"]), entry["samples"]
    if "periods" in entry:
        system, eta, method = arguments(case)
        periods = entry["periods"]
        options = {"periods": periods, "keep": periods, "record": Record(periods, count // periods)}
        return simulate(system, eta, method, initial=start, **options)
    system, method = system_of(case), replace(method_of(case), **law)
    of_case = load(entry["loads"][0])
    system, method = under_load(system, of_case, method, entry["end"] - of_case.end)
    return simulate_load(system, method, record=Instants.of(np.arange(count) / count), initial=start)


def load(entry):
    """A pulse or a record."""
    on = {"base": "base", "body 1": "force1", "body 2": "force2"}[entry["on"]]
    if entry["form"] == "record":
        return Load.record(entry["time"], entry["value"], on)
    if entry["form"] == "trapezoid":
        times = np.cumsum([0.0, entry["rise"], entry["hold"], entry["fall"]])
        return Load.record(times, [0.0, entry["peak"], entry["peak"], 0.0], on)
    return {"half-sine": Load.half_sine, "sawtooth": Load.sawtooth}[entry["form"]](entry["peak"], entry["duration"], on)


def states(case):
    """(n, 4) ndarray: x₁, v₁, x₂, v₂ at each instant of the case."""
    return np.array(CASES[case]["state"], dtype=float)


def forces(case):
    """(n,) ndarray: the contact force at each instant, minus at the second stop."""
    return np.array(CASES[case]["force"], dtype=float)


def events(case):
    """[(t, kind, rate before of the gap that closes)]; of an endless chatter without the impacts slower than 1e-6."""
    return [(float(t), kind, float(v) if stop == 1 else -float(v)) for t, kind, v, stop in CASES[case]["events"]]
