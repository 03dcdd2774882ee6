"""Make hard.json, systems.json and stops_and_loads.json in assets/truth, solved with certified events.

    .venv/bin/python tests/data/make_hard.py                    all hard cases
    .venv/bin/python tests/data/make_hard.py chatter limit      those with either in the name; the others are kept
    .venv/bin/python tests/data/make_hard.py --systems          all general systems (some ten minutes)
    .venv/bin/python tests/data/make_hard.py --systems drawn    those with "drawn" in the name; the others are kept
    .venv/bin/python tests/data/make_hard.py --stops            free bodies, two stops, pulses, records (half an hour)
    .venv/bin/python tests/data/make_hard.py --stops pulse      those with "pulse" in the name; the others are kept
    .venv/bin/python tests/data/make_hard.py --check            only compare with truth.json and systems.json

Each case is solved twice, with 60 and with 80 digits (COARSE and FINE), and hence with another order of the series and
other bounds. The events must be the same in number and kind. The largest difference, of states and of events, is
written with the case as "spread" and must be below 1e-28. Twenty-five digits of the finer solution are written, twenty
of a general system.

The energy balance of the coarser solution, by a quadrature that is independent of its steps, is written too and must
close to 1e-40 of the energies. It would not if an impact or a contact change were in the wrong place.

A general system is written with its conditioning (hard_cases/condition.py) in place of the energies, which are balanced
with fewer digits, to 1e-20. A case of stops and loads has its conditioning alone; that its equations and events are
right is seen from the general systems, which ``--check`` solves by them again.
"""

import json
import sys
import time
from pathlib import Path

from hard_cases import GROUPS, STOP_GROUPS, SYSTEM_GROUPS
from hard_cases.condition import DIGITS, condition, condition_of_case
from hard_cases.methods import exact, reference
from high_precision import IMPACT, Problem, format_number, solve, solve_case
from high_precision.bodies import Bodies
from high_precision.model import BASE_ONLY, TABLE, TOUCHING
from mpmath import mp, mpf

TRUTH = Path(__file__).resolve().parents[2] / "assets" / "truth"
COARSE, FINE = 60, 80
AGREEMENT = 1e-28
BALANCE = 1e-40
LISTED_SPEED = 1e-6  # impacts of the endless chatters that are slower than this are counted, not listed
ABOUT = {
    "about": (
        "Written by make_hard.py. states: xi1, xi1', xi2, xi2' at T, 2T, …; system: what differs from Table 1; "
        "all parameters are the exact values of the doubles given. spread: largest difference between the 60-digit and "
        "the 80-digit solution. A run that starts in contact has that as its first event at 0. omitted: impacts of a "
        "closing speed below 1e-6 that are not listed (endless chatter only)."
    ),
    "energy": (
        "From 0 to the end of the run, in units of m1 omega1^2 times the base amplitude squared: work of the "
        "excitation on both masses, what all dampers take, what impacts take; residual = gain + damped + lost - work. "
        "null where that was too long to compute (K = 1e9 undamped)."
    ),
    "events_reference": "[tau, kind, g' before]; kind 0 impact, 1 permanent contact begins, 2 it ends",
    "events_exact": "[tau, kind, g']; kind 0 contact begins, 1 contact ends",
}
ABOUT_SYSTEMS = {
    "about": (
        "Written by make_hard.py --systems. Each case: system and excitation (keys as in a system file; what is not "
        "given has the value of Table 1, no clearance, no wall, no force), eta, method, start (xi1, xi1', xi2, xi2' at "
        "tau = 0; with a wall xi2 = 0), state at each tau and the contact force there; 20 digits. All parameters are "
        "the exact values of the doubles given. A threshold of 1e-24 stands for its limit 0. spread: largest "
        "difference between the 60-digit and the 80-digit solution. condition: change of a state per relative change "
        "of the data, summed over all data; null if an event appears or disappears. A run that starts in contact has "
        "that as its first event at 0."
    ),
    "events_reference": "[tau, kind, g' before]; kind 0 impact, 1 permanent contact begins, 2 it ends",
    "events_exact": "[tau, kind, g']; kind 0 contact begins, 1 contact ends",
}
ABOUT_STOPS = {
    "about": (
        "Written by make_hard.py --stops; tests/data/high_precision/bodies.py says what the numbers mean. t: instants; "
        "state: x1, v1, x2, v2 there; force: of the contact, minus at the second stop; 20 digits. All numbers are the "
        "exact values of the doubles given. A threshold of 1e-24 stands for its limit 0. spread: largest difference "
        "between the 60-digit and the 80-digit solution. condition: change of a state per relative change of the data, "
        "summed over all data; null if an event appears or disappears. A run that starts in contact has that as its "
        "first event at 0. omitted: impacts slower than 1e-6 that are not listed (endless chatter only)."
    ),
    "events_reference": "[t, kind, g' before, stop]; kind 0 impact, 1 permanent contact begins, 2 it ends; stop 1 or 2",
    "events_exact": "[t, kind, g', stop]; kind 0 contact begins, 1 contact ends",
}
SYSTEM_DIGITS = 20
SYSTEM_BALANCE = 1e-20


def largest_difference(one, two):
    """Largest absolute difference of two solutions, which must have the same events."""
    if [event[1] for event in one.events] != [event[1] for event in two.events]:
        raise ArithmeticError("events differ with the number of digits")
    states = [abs(x - y) for a, b in zip(one.states, two.states, strict=True) for x, y in zip(a, b, strict=True)]
    events = [abs(a[i] - b[i]) for a, b in zip(one.events, two.events, strict=True) for i in (0, 2)]
    return max(states + events)


def check_energy(budget, allowed):
    """Raise ArithmeticError if the energy does not balance."""
    size = 1 + abs(budget.work) + budget.damped + budget.lost
    if abs(budget.residual) > allowed * size:
        raise ArithmeticError(f"energy residual {mp.nstr(budget.residual, 3)} of {mp.nstr(size, 3)}")


def energy_entry(budget):
    """The energy budget as it is written, after a check of its residual."""
    check_energy(budget, BALANCE)
    return {
        "work": format_number(budget.work),
        "damped": format_number(budget.damped),
        "lost": format_number(budget.lost),
        "residual": float(mp.nstr(budget.residual, 2)),
    }


def solve_twice(problem, energy):
    """The 60-digit and the 80-digit solution of a problem, and their largest difference, which must be small."""
    with mp.workdps(COARSE):
        coarse = solve(problem.again(), energy)
    with mp.workdps(FINE):
        fine = solve(problem.again())
        spread = largest_difference(coarse, fine)
        if spread > AGREEMENT:
            raise ArithmeticError(f"spread {mp.nstr(spread, 3)}")
    return coarse, fine, float(mp.nstr(spread, 2))


def case_entry(problem, more):
    """Solve one hard case and return its entry."""
    needs_many_steps = problem.method.get("damping") == 0 and problem.method["stiffness"] > 1e8  # 1e5 of them
    coarse, fine, spread = solve_twice(problem, energy=not needs_many_steps)
    with mp.workdps(COARSE):
        energy = energy_entry(coarse.budget) if coarse.budget else None
    with mp.workdps(FINE):
        endless = 0 < problem.method.get("threshold", 1) < LISTED_SPEED
        listed = [event for event in fine.events if not (endless and event[1] == IMPACT and -event[2] < LISTED_SPEED)]
        return {
            "eta": problem.eta,
            "method": problem.method,
            "system": problem.system,
            "initial": list(problem.initial),
            "periods": problem.periods,
            "status": "ok",
            **more,
            "spread": spread,
            "energy": energy,
            "omitted": len(fine.events) - len(listed),
            "states": [[format_number(x) for x in state] for state in fine.states[1:]],
            "events": [[format_number(t), kind, format_number(rate)] for t, kind, rate in listed],
        }


def system_entry(name, problem):
    """Solve one general system and return its entry."""
    _, fine, spread = solve_twice(problem, energy=False)
    with mp.workdps(DIGITS):
        check_energy(solve(problem.again(), energy=True).budget, SYSTEM_BALANCE)
    with mp.workdps(FINE):
        method, count = problem.method, problem.periods * problem.samples
        measured = condition(problem)
        numbers = {"K": method.get("stiffness"), "D": method.get("damping")}
        numbers |= {key: method.get(key) for key in ("joint_damping", "threshold")}
        return {
            "name": name,
            "method": method["name"],
            "system": problem.system,
            "excitation": problem.excitation,
            "eta": problem.eta,
            **{key: value for key, value in numbers.items() if value is not None},
            "start": list(problem.initial),
            "periods": problem.periods,
            "spread": spread,
            "condition": measured and float(f"{measured:.3g}"),
            "tau": [written(n * problem.again().period / problem.samples) for n in range(1, count + 1)],
            "state": [[written(x) for x in state] for state in fine.states[1:]],
            "force": [written(x) for x in fine.forces[1:]],
            "events": [[written(t), kind, written(rate)] for t, kind, rate in fine.events],
        }


def stops_entry(name, case):
    """Solve one case of free bodies, two stops, a pulse or a record and return its entry."""
    with mp.workdps(COARSE):
        coarse = solve_case(case)
    with mp.workdps(FINE):
        fine = solve_case(case)
        spread = largest_difference(coarse, fine)
        if spread > AGREEMENT:
            raise ArithmeticError(f"spread {mp.nstr(spread, 3)}")
        measured, end = condition_of_case(case), Bodies(case).end
        endless = case.get("threshold", 1) < LISTED_SPEED
        listed = [
            event for event in fine.events if not (endless and event[1] == IMPACT and abs(event[2]) < LISTED_SPEED)
        ]
        return {
            "name": name,
            **case,
            "spread": float(mp.nstr(spread, 2)),
            "condition": measured and float(f"{measured:.3g}"),
            "t": [written(n * end / case["samples"]) for n in range(1, case["samples"] + 1)],
            "state": [[written(x) for x in state] for state in fine.states[1:]],
            "force": [written(x) for x in fine.forces[1:]],
            "omitted": len(fine.events) - len(listed),
            "events": [[written(t), kind, written(rate), stop] for t, kind, rate, stop in listed],
        }


def written(x):
    return format_number(x, SYSTEM_DIGITS)


def write(path, about, cases):
    """Write a file with one case per line, so that differences are readable; a list if a case holds its name."""
    head = json.dumps(about, ensure_ascii=False, indent=1)[:-2]
    compact = [(json.dumps(name), json.dumps(entry, separators=(",", ":"))) for name, entry in cases.items()]
    if all("name" in entry for entry in cases.values()):
        lines, (begin, end) = [entry for _, entry in compact], "[]"
    else:
        lines, (begin, end) = [f"{name}: {entry}" for name, entry in compact], "{}"
    path.write_text(f'{head},\n "cases": {begin}\n' + ",\n".join(lines) + f"\n{end}}}\n")


def check():
    """Print the largest differences from truth.json, which another program made, and whether the events agree."""
    for name, expected in json.loads((TRUTH / "truth.json").read_text())["cases"].items():
        law, eta, method = name.split("|")
        joint_damping = {"published": "table"}.get(method, method)
        method = reference(joint_damping) if law == "ref" else exact(*map(float, method.split(",")))
        found = solve(Problem(float(eta), method, 20))
        states = max(
            abs(mpf(x) - y)
            for n, state in expected["states"].items()
            if int(n) <= 20
            for x, y in zip(state, found.states[int(n)], strict=True)
        )
        pairs = list(zip(expected["events"], found.events, strict=False))
        times = max(abs(mpf(one[0]) - two[0]) for one, two in pairs)
        same = all(one[1] == two[1] for one, two in pairs) and len(pairs) == len(expected["events"])
        print(f"{name}: states {mp.nstr(states, 2)}, times {mp.nstr(times, 2)}, kinds {'same' if same else 'DIFFER'}")
    check_systems()


def check_systems():
    """Print the largest difference of the general systems from those that are solved as cases of stops and loads."""
    for entry in json.loads((TRUTH / "systems.json").read_text())["cases"]:
        if entry.get("joint_damping") == "table" and not entry["system"].get("wall"):
            continue  # more than the dampers give
        found = solve_case(case_of_system(entry))
        states = max(
            abs(mpf(x) - y)
            for state, other in zip(entry["state"], found.states[1:], strict=True)
            for x, y in zip(state, other, strict=True)
        )
        same = [event[1] for event in entry["events"]] == [event[1] for event in found.events]
        print(f"{entry['name']}: states {mp.nstr(states, 2)}, kinds {'same' if same else 'DIFFER'}")


def case_of_system(entry):
    """A general system as a case of stops and loads."""
    numbers, drive = TABLE | TOUCHING | entry["system"], BASE_ONLY | entry["excitation"]
    k, e = ({name: mpf(value) for name, value in each.items()} for each in (numbers, drive))
    mass, spring, damper, constant = [mpf(1)], [mpf(1)], [2 * k["d1"]], [e["constant1"]]
    if not numbers["wall"]:
        mu = k.get("mass_ratio") or (k["kappa3"] ** 2 - 1) / (k["kappa"] ** 2 - k["kappa3"] ** 2)
        mass, spring, damper = [*mass, mu], [*spring, mu * k["kappa"] ** 2], [*damper, 2 * mu * k["d2"] * k["kappa"]]
        constant = [*constant, e["constant2"]]
    loads = [
        {
            "on": on,
            "form": "harmonic",
            "amplitude": e[name],
            "frequency": mpf(entry["eta"]),
            "phase": e[f"{name}_phase"],
        }
        for on, name in (("base", "base"), ("body 1", "force1"), ("body 2", "force2"))
    ]
    stop = {"restitution": k["restitution"]}
    if entry["method"] == "exact":
        stop = {"stiffness": mpf(entry["K"]), "damper": 2 * mpf(entry["D"])}
    return {
        **{"mass": mass, "spring": spring, "damper": damper, "constant": constant, "clearance": k["clearance"]},
        **{"stops": [stop], "threshold": entry.get("threshold"), "loads": loads, "start": entry["start"]},
        **{"periods": entry["periods"], "frequency": mpf(entry["eta"]), "samples": len(entry["tau"])},
    }


def make_hard(parts):
    """Make hard.json."""
    path = TRUTH / "hard.json"
    entries = json.loads(path.read_text())["cases"] if path.exists() else {}
    cases = [(name, problem, more[0] if more else {}) for group in GROUPS for name, problem, *more in group()]
    make(path, ABOUT, entries, {name: lambda p=p, more=more: case_entry(p, more) for name, p, more in cases}, parts)


def make_systems(parts):
    """Make systems.json."""
    path = TRUTH / "systems.json"
    entries = {entry["name"]: entry for entry in json.loads(path.read_text())["cases"]} if path.exists() else {}
    cases = [case for group in SYSTEM_GROUPS for case in group()]
    make(path, ABOUT_SYSTEMS, entries, {name: lambda n=name, p=p: system_entry(n, p) for name, p in cases}, parts)


def make_stops(parts):
    """Make stops_and_loads.json."""
    path = TRUTH / "stops_and_loads.json"
    entries = {entry["name"]: entry for entry in json.loads(path.read_text())["cases"]} if path.exists() else {}
    cases = [case for group in STOP_GROUPS for case in group()]
    make(path, ABOUT_STOPS, entries, {name: lambda n=name, c=case: stops_entry(n, c) for name, case in cases}, parts)


def make(path, about, entries, cases, parts):
    """Make the cases whose names contain one of ``parts`` and keep the other entries; drop those that are no case."""
    for name, solved in cases.items():
        if not any(part in name for part in parts):
            continue
        begin = time.perf_counter()
        try:
            entry = entries[name] = solved()
        except (ArithmeticError, ValueError) as reason:
            print(f"{name}: FAILED, {type(reason).__name__}: {reason}", flush=True)
            entries.pop(name, None)
            continue
        seconds = time.perf_counter() - begin
        print(f"{name}: {len(entry['events'])} events, spread {entry['spread']:.0e}, {seconds:.1f} s", flush=True)
        write(path, about, {case: entries[case] for case in cases if case in entries})


if __name__ == "__main__":
    mp.dps = FINE
    if sys.argv[1:] == ["--check"]:
        check()
    elif sys.argv[1:2] == ["--stops"]:
        make_stops(sys.argv[2:] or [""])
    elif sys.argv[1:2] == ["--systems"]:
        make_systems(sys.argv[2:] or [""])
    else:
        make_hard(sys.argv[1:] or [""])
