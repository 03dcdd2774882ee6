"""Grazing: initial states whose gap, or contact force, has a minimum of a prescribed value near zero.

The initial state that gives the prescribed minimum is found by Newton's method and rounded to doubles. What the minimum
is after that rounding is written as "dip", with its instant "dip_time".
"""

from high_precision import Problem, format_number
from mpmath import mp, mpf

from hard_cases.methods import exact, reference

# η, ξ₁′, ξ₂ near the graze, ξ₂′, time of the impact before (None: the first flight grazes), time of the minimum
GRAZES = {
    "a": (2.76, -2.3, 0.374, -2.7, None, 1.02),
    "b": (1.08, -1.5, 0.339, 0.2, None, 2.67),
    "c": (1.70, -2.5, 0.21, -3.2, None, 0.41),
    "d": (2.76, 0.6, 0.246, 3.6, 0.884, 1.644),
    "e": (1.08, 0.4, 0.281, -3.1, 0.0794, 3.039),
}
FORCE_GRAZES = {"a": (2.76, 0.5, -2.5, 0.46), "b": (1.08, 0.12, -0.5, 0.48)}  # η, ξ near the graze, ξ′, time
DIPS = (0.0, 1e-14, -1e-14, 1e-10, -1e-10, 1e-6, -1e-6)


def tolerance():
    return mpf(10) ** (-1.6 * mp.dps)


def grazing():
    """The gap of a flight has the minimum; before that flight there may be an impact."""
    for name, (eta, v1, x2, v2, impact, dip) in GRAZES.items():
        for target in DIPS:
            yield from _grazing_gap(f"grazing|{name}|{target:g}", eta, (v1, x2, v2), (impact, dip), target)


def _grazing_gap(name, eta, start, times, target):
    v1, x2, v2 = start
    problem = Problem(eta, reference(), 4, initial=(0.0, v1, x2, v2))
    impact, dip = times

    def prescribed_minimum(*unknown):
        residuals, gap = _minimum_of_gap(problem, unknown[0], None if impact is None else unknown[1], unknown[-1])
        return [*residuals, gap - mpf(target)]

    guess = [x for x in (x2, impact, dip) if x is not None]
    x2 = float(mp.findroot(prescribed_minimum, guess, tol=tolerance(), maxsteps=60)[0])

    def minimum_after_rounding(*unknown):
        return _minimum_of_gap(problem, mpf(x2), None if impact is None else unknown[0], unknown[-1])[0]

    guess = [x for x in (impact, dip) if x is not None]
    found = mp.findroot(minimum_after_rounding, guess, tol=tolerance(), maxsteps=60)
    found = list(found) if len(guess) > 1 else [found[0] if hasattr(found, "rows") else found]
    minimum = _minimum_of_gap(problem, mpf(x2), None if impact is None else found[0], found[-1])[1]
    more = {"dip": format_number(minimum), "dip_time": format_number(found[-1])}
    initial = (0.0, v1, x2, v2)
    yield name, Problem(eta, reference(), 4, initial=initial), more
    if impact is None:  # the same flight grazes a penalty contact as well
        yield name.replace("grazing", "grazing-exact"), Problem(eta, exact(12000, 18), 3, initial=initial), more


def _minimum_of_gap(problem, x2, impact, dip):
    """Return residuals that vanish if the gap is zero at ``impact`` and minimal at ``dip``, and the gap at ``dip``."""
    flight = mp.matrix(problem.matrix())
    y = mp.matrix(problem.start())
    y[2] = x2 - y[0]
    residuals, begin = [], mpf(0)
    if impact is not None:
        y, begin = mp.expm(flight * impact) * y, impact
        residuals.append(y[2])
        parting = -problem.restitution * y[3]
        y[1], y[2], y[3] = y[1] + problem.mass_share * (y[3] - parting), mpf(0), parting
    y = mp.expm(flight * (dip - begin)) * y
    return [*residuals, y[3]], y[2]


def grazing_force():
    """The contact force of pendulums that start in permanent contact has the minimum; below zero they part."""
    for name, (eta, x, v, dip) in FORCE_GRAZES.items():
        problem = Problem(eta, reference(), 3, initial=(0.0, v, 0.0, v))
        for target in DIPS:

            def prescribed_minimum(x, t, problem=problem, target=target):
                value, slope = _force(problem, x, t)
                return [value - mpf(target), slope]

            rounded = float(mp.findroot(prescribed_minimum, (x, dip), tol=tolerance(), maxsteps=60)[0])
            instant = mp.findroot(lambda t, x=rounded, problem=problem: _force(problem, x, t)[1], dip)
            minimum = _force(problem, rounded, instant)[0]
            more = {"dip": format_number(minimum), "dip_time": format_number(instant)}
            initial = (rounded, v, rounded, v)
            yield f"grazing-force|{name}|{target:g}", Problem(eta, reference(), 3, initial=initial), more


def _force(problem, x, t):
    """Return λ and its slope in permanent contact at time t after a start with the displacement x."""
    matrix = mp.matrix(problem.joined_matrix())
    row = mp.matrix([problem.force_row()])
    y = mp.matrix(problem.start())
    y[0] = x
    y = mp.expm(matrix * t) * y
    return (row * y)[0], (row * matrix * y)[0]
