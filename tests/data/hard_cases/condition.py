"""The conditioning of a problem, by solving it again with each number of the data changed by a tiny fraction."""

from high_precision import solve, solve_case
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
        return _total(solve, problem.again(), _changed(problem, mpf(CHANGE)))


def condition_of_case(case):
    """The same of a case of high_precision/bodies.py; a load's samples are changed together."""
    with mp.workdps(DIGITS):
        return _total(solve_case, case, _changed_cases(case, 1 + mpf(CHANGE)))


def _total(solver, problem, others):
    states, kinds = _solved(solver, problem)
    total = mpf(0)
    for changed in others:
        other, others_kinds = _solved(solver, changed)
        if others_kinds != kinds:
            return None
        total += max(abs(x - y) for a, b in zip(states, other, strict=True) for x, y in zip(a, b, strict=True))
    return float(total / mpf(CHANGE))


def _solved(solver, problem):
    solution = solver(problem)
    return solution.states[1:], [event[1] for event in solution.events]


def _changed_cases(case, factor):
    """Yield the case with one number after the other times the factor; bodies that touch a stop stay there."""
    x1, _, x2, _ = case["start"]
    touching = case["clearance"] + x2 - x1 in (0, case.get("play"))
    for name, value in case.items():
        if name in ("samples", "periods", "threshold") or (touching and name in ("clearance", "play")):
            continue
        if isinstance(value, float) and value:
            yield case | {name: value * factor}
        if not isinstance(value, list):
            continue
        for k, each in enumerate(value):
            places = [None] if isinstance(each, float) else each
            for key in places:
                new = times(each, factor) if key is None else each | {key: times(each[key], factor)}
                if new != (each if key is None else {**each}) and not (touching and name == "start" and k in (0, 2)):
                    yield case | {name: [*value[:k], new, *value[k + 1 :]]}


def times(value, factor):
    """A number, or each of a list of them, times a factor; a word stays."""
    if isinstance(value, list):
        return [x * factor for x in value]
    return value if isinstance(value, str) else value * factor


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
