"""Where a branch is back at its first orbit, or ends in a branch of half its period."""

import numpy as np
from vibroscope.engine.continuation.curve import Curve, CurvePoint
from vibroscope.engine.continuation.kinds import DOUBLING, bifurcations_ahead, indicators
from vibroscope.engine.continuation.orbit import Orbit
from vibroscope.engine.continuation.tolerances import CLOSED_BRANCH, SAME_DOUBLING, SAME_ORBIT
from vibroscope.engine.motions.poincare_map import size_of


def share_on_chord(point: np.ndarray, here: np.ndarray, there: np.ndarray, aside: float) -> float | None:
    """The share of the way between two neighbours at which a point lies; None if it lies more than ``aside`` off."""
    along, off = there - here, point - here
    if not along.any():
        return None
    share = float(off @ along / (along @ along))
    return share if np.linalg.norm(off - share * along) < aside * np.linalg.norm(along) else None


def share_of_first(start: CurvePoint, here: CurvePoint, there: CurvePoint) -> float | None:
    """The share of the way between two neighbours at which the first orbit lies, if its events are the same."""
    if start.orbit.kinds != here.orbit.kinds:
        return None
    return share_on_chord(*(point.unknowns / start.scales for point in (start, here, there)), CLOSED_BRANCH)


def is_first(start: CurvePoint, orbit: Orbit) -> bool:
    """Whether an orbit passes through a state of the first one at τ ≡ 0, with as many events."""
    rows = start.evaluation.section
    near = np.abs(rows - orbit.unknowns[:4]).max(axis=1) < SAME_ORBIT * size_of(rows)
    return bool(near.any()) and sorted(orbit.kinds) == sorted(start.orbit.kinds)


def halves_meet(here: CurvePoint, there: CurvePoint) -> bool:
    """Whether both halves of the cycle become the same between two orbits.

    There a branch that began at a period doubling meets the branch of half the period. What follows is the same
    orbits, half a cycle later.
    """
    if here.orbit.period % 2:
        return False
    return difference_of_halves(here) @ difference_of_halves(there) < 0


def value_of_meeting(curve: Curve, here: CurvePoint, there: CurvePoint) -> float:
    """α₁ where the halves meet: the period doubling between two orbits, or next to them.

    The equations are singular there; near it α₁ varies with the square of the difference of the halves. So this leads
    to an orbit of half the period from which the doubling is located.
    """
    one, two = (float(np.square(difference_of_halves(point)).sum()) for point in (here, there))
    share = one / (one - two) if one != two else 0.5
    value = here.value + (there.value - here.value) * min(max(share, -1.0), 2.0)
    located = _doubling_near(curve, here.orbit, value)
    return value if located is None else located


def _doubling_near(curve: Curve, orbit: Orbit, value: float) -> float | None:
    """α₁ of the period doubling of the orbit whose cycle is half of another one; None if it is not found nearby."""
    half, m = orbit.period // 2, len(orbit.kinds) // 2
    if len(orbit.kinds) % 2 or orbit.kinds[:m] != orbit.kinds[m:]:  # an event lies at an end of the cycle
        return None
    instants = 0.5 * (orbit.instants[:m] + orbit.instants[m:] - half)
    guess = Orbit(half, orbit.kinds[:m], orbit.first, np.concatenate([orbit.unknowns[:4], instants]))
    point = curve.solved(guess, value)
    if point is None:
        return None
    for start, step in ((side, SAME_DOUBLING * 4.0**k) for k in range(5) for side in (point, point.turned())):
        ahead = curve.ahead(start, step)
        if ahead is None:
            continue
        for kind, there in bifurcations_ahead(curve, start, step, indicators(start), indicators(ahead)):
            if kind == DOUBLING:
                return there.value
    return None


def difference_of_halves(point: CurvePoint) -> np.ndarray:
    """ξ₁ and g half a cycle later less those at τ = 0, (2,): an impact there leaves them as they are."""
    rows = point.evaluation.section[:, [0, 2]]
    return rows[len(rows) // 2] - rows[0]
