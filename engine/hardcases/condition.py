"""How far a result answers to the last digits of its data: the error that no solver in double precision can undercut.

Every number that goes in carries a relative rounding error ε = 2⁻⁵². A solver is as good as can be if its error is not
much more than what the same run shows when its data change by ε. The change is not measured at ε, where it would hold
the solver's own errors, but at a larger δ, and scaled down: errors of the solver enter it with ε/δ at most. δ is the
largest for which no event comes or goes, and which the result answers to in proportion.

At the edge of two results, as in a grazing impact, there is no such δ. A gap off by δg changes the speed of such an
impact by √(2 g″ δg) at most: half of the digits are all there are.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from ..methods import ExactPenalty, Method, Reference
from ..model import System
from ..simulate import simulate

EPSILON = float(np.finfo(float).eps)
SHARES = tuple(10.0**-k for k in range(6, 13))
PROPORTION = (1.5, 2.7)  # the answer to 2δ in units of that to δ
MARGIN = 64  # what is allowed for: some tens of operations in each piece
PIECE = 1.0  # radians in each of which a motion in closed form may be rounded once


@dataclass(frozen=True)
class Run:
    """What a run is made of; all periods are kept."""

    system: System
    eta: float
    method: Method
    periods: int
    initial: tuple[float, float, float, float] = (0.0, 0.0, 0.0, 0.0)

    def solve(self, **options):
        """The Response."""
        return simulate(
            self.system,
            self.eta,
            self.method,
            periods=self.periods,
            keep=self.periods,
            initial=self.initial,
            **options,
        )


def sensitivity(run: Run) -> float | None:
    """Largest change of any state of the section per relative change of the data, summed over these.

    Returns
    -------
    float or None
        None if an event comes or goes with the smallest change that can be measured: then the result is at the edge of
        two, as in a grazing impact.
    """
    base = run.solve()
    return sum(parts) if None not in (parts := [_answer(base, run, change) for change in _changes(run)]) else None


def attainable(run: Run) -> float | None:
    """The error to be expected of a solver in double precision, MARGIN included; None as for :func:`sensitivity`."""
    measured = sensitivity(run)
    return None if measured is None else MARGIN * EPSILON * (measured + rounding(run))


def at_the_edge(run: Run, clear: Run) -> float:
    """The same for a run with a grazing impact; ``clear`` is the same but for the graze, which it passes by."""
    size = _size(clear.solve())
    bend = max(1.0, run.system.kappa) ** 2 * size + run.eta**2
    speed = np.sqrt(2 * bend * MARGIN * EPSILON * size)
    return float(2 * speed * max(1.0, sensitivity(clear) / size))


def rounding(run: Run) -> float:
    """What rounding the states adds up to, in units of ε: once in PIECE radians, of the contact's vibration too."""
    response = run.solve()
    turned = response.window[1] * max(1.0, run.system.kappa, run.eta)
    stiffness = getattr(run.method, "stiffness", 0.0)
    touching = float((response.contacts[:, 1] - response.contacts[:, 0]).sum())
    turned += touching * np.sqrt(stiffness / run.system.mass_share)
    return _size(response) * (1 + turned / PIECE)


def _size(response) -> float:
    return float(max(np.abs(response.section).max(), response.eta))  # a body at rest in space has ξ′ = η sin ητ


def _answer(base, run, change) -> float | None:
    for share in SHARES:
        once, twice, back = (_state_if_same(base, change(run, factor * share)) for factor in (1, 2, -1))
        if once is None or twice is None or back is None:
            continue
        small = np.abs(once - back).max() / 2
        noise = 1e-13 * np.abs(base.section).max()
        if small <= noise or PROPORTION[0] <= np.abs(twice - base.section).max() / small <= PROPORTION[1]:
            return float(max(small, np.abs(once - base.section).max()) / share)
    return None


def _state_if_same(base, run):
    """The section, if all events are the same in number."""
    try:
        other = run.solve()
    except ValueError:  # the change leads out of what is allowed
        return None
    same = len(other.impacts) == len(base.impacts) and len(other.contacts) == len(base.contacts)
    return other.section if other.status == base.status and same else None


def _changes(run: Run) -> Iterator:
    """One function a number: (run, share) → the run with this number changed by the share of it."""
    yield lambda r, s: replace(r, eta=r.eta * (1 + s))
    # what counts of κ and κ₃ is how far they are from 1 and from each other; as frequencies they are seen by η
    yield lambda r, s: replace(r, system=_stretched(r.system, 1 + s))
    for name in ("d1", "d2", "d3"):
        if getattr(run.system, name) > 0:
            yield lambda r, s, n=name: replace(r, system=replace(r.system, **{n: getattr(r.system, n) * (1 + s)}))
    if isinstance(run.method, Reference) and 0 < run.system.restitution < 1:
        yield lambda r, s: replace(r, system=replace(r.system, restitution=r.system.restitution * (1 + s)))
    if isinstance(run.method, ExactPenalty):
        for name in ("stiffness", "damping"):
            if getattr(run.method, name) > 0:
                yield lambda r, s, n=name: replace(r, method=replace(r.method, **{n: getattr(r.method, n) * (1 + s)}))
    x1, v1, x2, v2 = run.initial
    for k, value in enumerate((x1, v1, x2 - x1, v2 - v1)):
        if value != 0:
            yield lambda r, s, k=k: replace(r, initial=_moved(r.initial, k, s))


def _stretched(system: System, factor: float) -> System:
    return replace(system, kappa=1 + (system.kappa - 1) * factor, kappa3=1 + (system.kappa3 - 1) * factor)


def _moved(initial, k, share):
    """ξ₁, ξ₁′, gap or rate changed; the gap of pendulums that touch stays zero."""
    x1, v1, x2, v2 = initial
    parts = [x1, v1, x2 - x1, v2 - v1]
    parts[k] *= 1 + share
    return parts[0], parts[1], parts[0] + parts[2], parts[1] + parts[3]
