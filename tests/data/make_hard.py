"""Makes assets/truth/hard.json: hard cases solved by high_precision, whose docstring says how events are certified.

    .venv/bin/python tests/data/make_hard.py                 every case
    .venv/bin/python tests/data/make_hard.py chatter limit   those with either in the name; the others are kept
    .venv/bin/python tests/data/make_hard.py --check         nothing but the comparison with truth.json

Each case is solved twice, with 60 and with 80 digits (COARSE and FINE), thereby with another order of the series and
other bounds. The events must be the same in number and kind; the largest difference, of states and of events, is
written with the case as "spread" and must be below 1e-28. Twenty-five digits of the finer solution are kept.

The energy balance of the coarser solution, by a quadrature that knows nothing of its steps, is written too and must
close to 1e-40 of the energies; it would not, had an impact or a change of contact been put in the wrong place.
"""

import json
import sys
import time
from pathlib import Path

from high_precision import IMPACT, Problem, solve
from mpmath import mp, mpf

TRUTH = Path(__file__).resolve().parents[2] / "assets" / "truth"
COARSE, FINE, DIGITS = 60, 80, 25
AGREEMENT = 1e-28
BALANCE = 1e-40
KEPT_SPEED = 1e-6  # of the endless chatters, impacts slower than this are counted, not listed
REST = (0.0, 0.0, 0.0, 0.0)
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


def reference(joint_damping="table", threshold=0.002):
    """A method of the reference."""
    return {"name": "reference", "joint_damping": joint_damping, "threshold": threshold}


def exact(stiffness, damping):
    """A method of the exact penalty."""
    return {"name": "exact", "stiffness": float(stiffness), "damping": float(damping)}


# ------------------------------------------------------------------------------------------------------ the cases


def from_rest():
    """Long runs from rest, both joint dampings; the four scenes and twelve other η. 1.70 is chaotic."""
    for joint in ("table", "derived"):
        for eta in (1.08, 1.70, 2.76, 3.25):
            yield f"rest|{eta:.2f}|{joint}", Problem(eta, reference(joint), 15 if eta == 1.70 else 30)
        for eta in (0.5, 0.62, 0.77, 0.93, 1.21, 1.38, 1.55, 1.93, 2.2, 2.5, 3.0, 4.0):
            yield f"rest|{eta:.2f}|{joint}", Problem(eta, reference(joint), 10)


# η, ξ₁′, ξ₂ near the graze, ξ₂′, time of the impact before (None: the first flight grazes), time of the dip
GRAZES = {
    "a": (2.76, -2.3, 0.374, -2.7, None, 1.02),
    "b": (1.08, -1.5, 0.339, 0.2, None, 2.67),
    "c": (1.70, -2.5, 0.21, -3.2, None, 0.41),
    "d": (2.76, 0.6, 0.246, 3.6, 0.884, 1.644),
    "e": (1.08, 0.4, 0.281, -3.1, 0.0794, 3.039),
}
DIPS = (0.0, 1e-14, -1e-14, 1e-10, -1e-10, 1e-6, -1e-6)


def dip_of(problem, x2, impact, dip):
    """Residuals whose zero is an impact at ``impact`` (or None) and a turning point of the gap at ``dip``; the gap."""
    flight = mp.matrix(problem.matrix())
    y = mp.matrix(problem.start())
    y[2] = x2 - y[0]
    residuals, begin = [], mpf(0)
    if impact is not None:
        y, begin = mp.expm(flight * impact) * y, impact
        residuals.append(y[2])
        parting = -problem.e * y[3]
        y[1], y[2], y[3] = y[1] + problem.share * (y[3] - parting), mpf(0), parting
    y = mp.expm(flight * (dip - begin)) * y
    return [*residuals, y[3]], y[2]


def grazing():
    """Starts whose gap dips to a chosen value; what it is after the start is rounded to doubles is kept as "dip"."""
    for name, (eta, v1, x2, v2, impact, dip) in GRAZES.items():
        for target in DIPS:
            yield from _graze(f"grazing|{name}|{target:g}", eta, (v1, x2, v2), (impact, dip), target)


def _graze(name, eta, start, times, target):
    v1, x2, v2 = start
    problem = Problem(eta, reference(), 4, initial=(0.0, v1, x2, v2))
    impact, dip = times

    def tuned(*unknown):
        at = unknown[1] if impact is not None else None
        residuals, gap = dip_of(problem, unknown[0], at, unknown[-1])
        return [*residuals, gap - mpf(target)]

    guess = [x for x in (x2, impact, dip) if x is not None]
    x2 = float(mp.findroot(tuned, guess, tol=mpf(10) ** (-1.6 * mp.dps), maxsteps=60)[0])
    unknown = [x for x in (impact, dip) if x is not None]

    def located(*unknown):
        return dip_of(problem, mpf(x2), unknown[0] if impact is not None else None, unknown[-1])[0]

    found = mp.findroot(located, unknown, tol=mpf(10) ** (-1.6 * mp.dps), maxsteps=60)
    found = list(found) if len(unknown) > 1 else [found[0] if hasattr(found, "rows") else found]
    actual = dip_of(problem, mpf(x2), found[0] if impact is not None else None, found[-1])[1]
    more = {"dip": text(actual), "dip_time": text(found[-1])}
    initial = (0.0, v1, x2, v2)
    yield name, Problem(eta, reference(), 4, initial=initial), more
    if impact is None:  # the same flight, as the penalty law has it
        yield name.replace("grazing", "grazing-exact"), Problem(eta, exact(12000, 18), 3, initial=initial), more


# η, ξ near the graze, ξ′, time of the dip
FORCE_GRAZES = {"a": (2.76, 0.5, -2.5, 0.46), "b": (1.08, 0.12, -0.5, 0.48)}


def grazing_force():
    """Starts in permanent contact whose force λ dips to a chosen value; below zero they part for an instant."""
    for name, (eta, x, v, dip) in FORCE_GRAZES.items():
        for target in DIPS:
            start = Problem(eta, reference(), 3, initial=(0.0, v, 0.0, v))
            matrix = mp.matrix(start.joined_matrix())
            row = mp.matrix([[-start.share * c for c in start.free_acceleration()[:2]] + [0] * 4])

            def force(x, t, start=start, matrix=matrix, row=row):
                y = mp.matrix(start.start())
                y[0] = x
                y = mp.expm(matrix * t) * y
                return [(row * y)[0], (row * matrix * y)[0]]

            def tuned(x, t, force=force, target=target):
                value, slope = force(x, t)
                return [value - mpf(target), slope]

            tolerance = mpf(10) ** (-1.6 * mp.dps)
            rounded = float(mp.findroot(tuned, (x, dip), tol=tolerance, maxsteps=60)[0])
            time_of_dip = mp.findroot(lambda t, x=rounded, force=force: force(x, t)[1], dip)
            more = {"dip": text(force(rounded, time_of_dip)[0]), "dip_time": text(time_of_dip)}
            initial = (rounded, v, rounded, v)
            yield f"grazing-force|{name}|{target:g}", Problem(eta, reference(), 3, initial=initial), more


PRESSED = (100.0, 0.0, 100.0, -1.0)  # so far out, springs press the pendulums together: chatter ends even at e = 0.99


def chatter():
    """Restitution from 0 to 1, thresholds 0.002 and 1e-6: from rest, and pressed so that chatter ends in sticking."""
    for threshold in (0.002, 1e-6):
        method = reference("table", threshold)
        for e in (0.0, 0.1, 0.5, 0.9, 0.99):
            system, periods = {"restitution": e}, 3 if e < 0.9 else 8
            yield f"chatter|{e}|{threshold:g}", Problem(1.08, method, periods, system)
            yield f"chatter-pressed|{e}|{threshold:g}", Problem(2.76, method, 1, system, PRESSED)
    for joint in ("table", "derived"):
        yield f"elastic|2.76|{joint}", Problem(2.76, reference(joint), 5, {"restitution": 1.0})
    yield "elastic-pressed|2.76|table", Problem(2.76, reference(), 1, {"restitution": 1.0}, PRESSED)


def limits():
    """ε → 0 by ε = 1e-8, 1e-16, 1e-24; the last is the limit to far more digits than a double has."""
    for joint in ("table", "derived"):
        for threshold in (1e-8, 1e-16, 1e-24):
            method = reference(joint, threshold)
            for e in (0.5, 0.9):
                system, periods = {"restitution": e}, 3 if e < 0.9 else 8
                yield f"limit|1.08|{e}|{joint}|{threshold:g}", Problem(1.08, method, periods, system)
                yield f"limit-pressed|2.76|{e}|{joint}|{threshold:g}", Problem(2.76, method, 1, system, PRESSED)
    method = reference("table", 1e-24)
    for eta in (0.77, 1.70, 2.20):
        yield f"limit|{eta:.2f}|0.5|table|1e-24", Problem(eta, method, 3)
    for e in (0.1, 0.99):
        yield f"limit-pressed|2.76|{e}|table|1e-24", Problem(2.76, method, 1, {"restitution": e}, PRESSED)


def close_frequencies():
    """κ hardly above 1: the gap is driven by the difference of the dampers alone."""
    for excess in (1e-4, 1e-7):
        system = {"kappa": 1 + excess, "kappa3": 1 + excess / 2}
        for eta in (1.0, 2.0):
            for joint in ("table", "derived"):
                yield f"kappa|1+{excess:g}|{eta}|{joint}", Problem(eta, reference(joint), 5, system)
            yield f"kappa|1+{excess:g}|{eta}|12000,18", Problem(eta, exact(12000, 18), 4, system)


def resonance():
    """Excitation at 1, κ, κ₃: damped, hardly damped, undamped (secular growth)."""
    for eta in (1.0, 2.41, 1.8):
        for name, d in (("damped", None), ("1e-9", 1e-9), ("undamped", 0.0)):
            system = {} if d is None else {"d1": d, "d2": d, "d3": d}
            yield f"resonance|{eta}|{name}|table", Problem(eta, reference(), 5, system)
            if d is None:
                yield f"resonance|{eta}|{name}|derived", Problem(eta, reference("derived"), 5, system)
            yield f"resonance|{eta}|{name}|12000,18", Problem(eta, exact(12000, 18), 4, system)


def undamped():
    """No damper anywhere."""
    system = {"d1": 0.0, "d2": 0.0, "d3": 0.0}
    yield "undamped|2.76|e=0.5", Problem(2.76, reference(), 5, system)
    yield "undamped|2.76|e=1", Problem(2.76, reference(), 5, system | {"restitution": 1.0})
    for k in (100, 12000):
        yield f"undamped|2.76|{k},0", Problem(2.76, exact(k, 0), 5, system)


def stiffness():
    """The exact penalty over K and D: under-, critically and overdamped, and D without measure."""
    for eta, k, d in ((2.76, 12000, 18), (1.08, 2500, 8), (1.08, 100, 50), (3.25, 12000, 18), (1.70, 12000, 18)):
        yield f"exact|{eta:.2f}|{k},{d}", Problem(eta, exact(k, d), 10)
    share = Problem(2.76, exact(1, 0), 1).share
    ratios = {"0": 0, "0.2": mpf("0.2"), "1": 1, "1-1e-9": 1 - mpf("1e-9"), "1+1e-9": 1 + mpf("1e-9"), "5": 5}
    for k in (1, 100, 10**4, 10**6, 10**9):
        for name, ratio in ratios.items():
            method = exact(k, ratio * mp.sqrt(k * share))
            soft = (k, name) != (10**9, "0")
            yield f"stiffness|2.76|K={k:.0e}|zeta={name}", Problem(2.76, method, 4 if soft else 2)
            if soft and name in ("0", "0.2", "1", "5"):
                yield f"stiffness|1.08|K={k:.0e}|zeta={name}", Problem(1.08, method, 2)
    for eta, periods in ((2.76, 4), (1.08, 2)):
        for k in (1, 10**9):
            yield f"stiffness|{eta}|K={k:.0e}|D=1e6", Problem(eta, exact(k, 1e6), periods)


def starts():
    """Every admissible start, and runs without any change of contact."""
    both = {"reference": reference(), "exact": exact(12000, 18)}
    where = {
        "separated": (2.76, (-0.5, 1.0, 0.75, -2.0), 5),
        "approaching": (2.76, (0.25, 1.0, 0.25, -2.0), 5),
        "leaving": (2.76, (0.25, -1.0, 0.25, 2.0), 5),
        "compressed": (1.08, (1.5, 0.25, 1.5, 0.25), 3),  # g = g′ = 0 and λ > 0
        "pulled": (1.08, (-1.5, 0.25, -1.5, 0.25), 3),  # g = g′ = 0 and g″ > 0: they part at once
        "at-rest": (2.2, REST, 5),
        "barely-approaching": (2.76, (0.25, 1.0, 0.25, 1.0 - 1e-12), 3),
        "barely-leaving": (2.76, (0.25, 1.0, 0.25, 1.0 + 1e-12), 3),
        "contact-never-ends": (500.0, (20.0, 0.0, 20.0, 0.0), 5),
        "contact-never-comes": (80.0, (-3.0, 0.0, 4.0, 0.0), 5),
        "far-away": (2.76, (-1e4, 0.0, 1e4, 0.0), 3),
        "slow": (0.02, REST, 1),
        "fast": (200.0, REST, 20),
    }
    for name, (eta, initial, periods) in where.items():
        for law, method in both.items():
            yield f"start|{name}|{law}", Problem(eta, method, periods, initial=initial)
    yield "start|penetrating|exact", Problem(2.76, both["exact"], 5, initial=(0.5, 0.0, 0.25, 1.0))
    yield "start|never-ends|D=1e6", Problem(2.76, exact(1, 1e6), 5, initial=(1.0, 0.0, 0.5, 0.0))


GROUPS = (from_rest, chatter, resonance, stiffness, grazing, grazing_force, limits, close_frequencies, undamped, starts)


# ------------------------------------------------------------------------------------------------------ writing


def text(x):
    """A number to DIGITS digits."""
    return mp.nstr(mpf(x), DIGITS, min_fixed=-4, max_fixed=DIGITS)


def difference(one, two):
    """Largest difference of two solutions with the same events, an absolute one."""
    if [kind for _, kind, _ in one.events] != [kind for _, kind, _ in two.events]:
        raise ArithmeticError("events differ with the number of digits")
    states = [abs(x - y) for a, b in zip(one.states, two.states, strict=True) for x, y in zip(a, b, strict=True)]
    events = [abs(a[i] - b[i]) for a, b in zip(one.events, two.events, strict=True) for i in (0, 2)]
    return max(states + events)


def accounts(budget):
    """The energy budget as it is written; its residual must vanish beside the energies."""
    size = 1 + abs(budget.work) + budget.damped + budget.lost
    if abs(budget.residual) > BALANCE * size:
        raise ArithmeticError(f"energy residual {mp.nstr(budget.residual, 3)} of {mp.nstr(size, 3)}")
    return {
        "work": text(budget.work),
        "damped": text(budget.damped),
        "lost": text(budget.lost),
        "residual": float(mp.nstr(budget.residual, 2)),
    }


def case(problem, more):
    """The entry of one case."""
    with mp.workdps(COARSE):
        again = Problem(problem.eta, problem.method, problem.periods, problem.system, problem.initial)
        undying = problem.method.get("damping") == 0 and problem.method["stiffness"] > 1e8
        coarse = solve(again, energy=not undying)  # 1e5 steps there
        energy = accounts(coarse.budget) if coarse.budget else None
    with mp.workdps(FINE):
        fine = solve(Problem(problem.eta, problem.method, problem.periods, problem.system, problem.initial))
        spread = difference(coarse, fine)
        if spread > AGREEMENT:
            raise ArithmeticError(f"spread {mp.nstr(spread, 3)}")
        endless = 0 < problem.method.get("threshold", 1) < KEPT_SPEED
        listed = [e for e in fine.events if not (endless and e[1] == IMPACT and -e[2] < KEPT_SPEED)]
        return {
            "eta": problem.eta,
            "method": problem.method,
            "system": problem.system,
            "initial": list(problem.initial),
            "periods": problem.periods,
            "status": "ok",
            **more,
            "spread": float(mp.nstr(spread, 2)),
            "energy": energy,
            "omitted": len(fine.events) - len(listed),
            "states": [[text(x) for x in state] for state in fine.states[1:]],
            "events": [[text(t), kind, text(rate)] for t, kind, rate in listed],
        }


def write(cases):
    """One case a line, so that a difference can be read."""
    lines = [f"{json.dumps(name)}: {json.dumps(entry, separators=(',', ':'))}" for name, entry in cases.items()]
    head = json.dumps(ABOUT, ensure_ascii=False, indent=1)[:-2]
    (TRUTH / "hard.json").write_text(head + ',\n "cases": {\n' + ",\n".join(lines) + "\n}}\n")


def check():
    """Largest differences from truth.json, which another program made, and every event's kind."""
    for name, expected in json.loads((TRUTH / "truth.json").read_text())["cases"].items():
        law, eta, method = name.split("|")
        joint = {"published": "table"}.get(method, method)
        method = reference(joint) if law == "ref" else exact(*map(float, method.split(",")))
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


def main(parts):
    """Make the cases whose names contain one of ``parts``, keep the others; cases that are no more are dropped."""
    path = TRUTH / "hard.json"
    known = json.loads(path.read_text())["cases"] if path.exists() else {}
    asked = [(name, problem, more[0] if more else {}) for group in GROUPS for name, problem, *more in group()]
    for name, problem, more in asked:
        if not any(part in name for part in parts):
            continue
        begin = time.perf_counter()
        try:
            known[name] = case(problem, more)
        except (ArithmeticError, ValueError) as reason:
            print(f"{name}: FAILED, {type(reason).__name__}: {reason}", flush=True)
            known.pop(name, None)
            continue
        entry, seconds = known[name], time.perf_counter() - begin
        print(f"{name}: {len(entry['events'])} events, spread {entry['spread']:.0e}, {seconds:.1f} s", flush=True)
        write({n: known[n] for n, _, _ in asked if n in known})


if __name__ == "__main__":
    mp.dps = FINE
    if sys.argv[1:] == ["--check"]:
        check()
    else:
        main(sys.argv[1:] or [""])
