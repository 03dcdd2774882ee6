"""The conditioning of a problem, by solving it again with each number of the data changed by a tiny fraction."""

from high_precision import solve
from high_precision.model import BASE_ONLY, TABLE, TOUCHING
from mpmath import mp, mpf

DIGITS = 34
CHANGE = 2.0**-53  # a power of two, so that a gap of zero stays zero


def condition(problem):
    """Largest change of a sample per relative change of a number of the data, summed over all of them.

    A gap at the start changes by a fraction of the largest number that it is a difference of; one that is zero, because
    the bodies touch, stays zero. None if an event appears or disappears with the change, as in a graze.
    """
    with mp.workdps(DIGITS):
        change = mpf(CHANGE)
        states, kinds = _solved(problem.again())
        total = mpf(0)
        for changed in _changed(problem, change):
            other, others_kinds = _solved(changed)
            if others_kinds != kinds:
                return None
            moved = max(abs(x - y) for a, b in zip(states, other, strict=True) for x, y in zip(a, b, strict=True))
            total += moved / change
        return float(total)


def _solved(problem):
    solution = solve(problem)
    return solution.states[1:], [kind for _, kind, _ in solution.events]


def _changed(problem, r):
    """Yield the problem with one number after the other changed by the fraction r."""
    system = {**TABLE, **TOUCHING, **problem.system}
    excitation = BASE_ONLY | problem.excitation
    yield problem.again(eta=mpf(problem.eta) * (1 + r))
    unused = {"kappa", "d2", "kappa3", "d3"} if problem.wall else set()
    if problem.method.get("joint_damping") != "table":
        unused.add("d3")
    if "mass_ratio" in system:
        unused.add("kappa3")
    if "stiffness" in problem.method or system["restitution"] == 1:
        unused.add("restitution")
    for name, value in system.items():
        if value and name not in (*unused, "wall", "clearance"):
            yield problem.again(system=system | {name: mpf(value) * (1 + r)})
    if system["clearance"]:
        wider = mpf(system["clearance"]) * r
        x1, v1, x2, v2 = map(mpf, problem.initial)  # the gap at the start is kept, and body 1 beside another
        start = (x1 + wider, v1, x2, v2) if problem.wall else (x1, v1, x2 - wider, v2)
        yield problem.again(system=system | {"clearance": system["clearance"] + wider}, initial=start)
    for name, value in excitation.items():
        if value and not (problem.wall and "2" in name):
            yield problem.again(excitation=excitation | {name: mpf(value) * (1 + r)})
    for name in ("stiffness", "damping"):
        if problem.method.get(name):
            yield problem.again(method=problem.method | {name: mpf(problem.method[name]) * (1 + r)})
    yield from _changed_starts(problem, r)


def _changed_starts(problem, r):
    x1, v1, x2, v2 = map(mpf, problem.initial)
    gap = problem.start()[2]
    size = max(abs(problem.clearance), abs(x1), abs(x2))
    moved = mpf(0) if problem.wall else x1 * r
    for start in (
        (x1 + moved, v1, x2 + moved, v2),
        (x1, v1 * (1 + r), x2, v2),
        (x1, v1, x2, v2 * (1 + r)),
        (x1 - size * r, v1, x2, v2) if gap else problem.initial,
    ):
        if start != problem.initial:
            yield problem.again(initial=start)
