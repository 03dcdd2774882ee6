"""A branch of periodic motions and the points on it: what traces of a curve make, also as labelled arrays (xarray).

A search also asks whether an orbit lies on one of the branches that it has followed (`KnownBranches`).
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np
from vibroscope.engine.continuation.curve import Curve, CurvePoint
from vibroscope.engine.continuation.family import Family
from vibroscope.engine.continuation.kinds import BIFURCATIONS, POINT_KINDS, STICKING_BEGINS, STICKING_ENDS
from vibroscope.engine.continuation.orbit import Orbit
from vibroscope.engine.continuation.tolerances import MARGIN_ROUNDING, SAME_ORBIT
from vibroscope.engine.continuation.tracer import Trace
from vibroscope.engine.drivers.event_driven import displaced_state
from vibroscope.engine.drivers.orbit import multipliers_of
from vibroscope.engine.model import COORDINATES
from vibroscope.engine.motions.poincare_map import is_stable, size_of
from vibroscope.engine.result import LENGTH, SPEED, labelled
from vibroscope.engine.wording import html_table

if TYPE_CHECKING:
    import xarray as xr


MOST_WALK = 8  # steps from an orbit to one between it and its neighbour on the branch


class KnownBranches:
    """The orbits that were followed, piece by piece: the motion jumps where an impact begins or ceases to stick."""

    def __init__(self, curve: Curve) -> None:
        self.curve, self.traces = curve, 0
        self._pieces: list[tuple[Sequence[CurvePoint], np.ndarray]] = []

    def add(self, trace: Trace) -> None:
        """Add the orbits of a trace, in their order along it; between both ends of a jump there are none."""
        self.traces += 1
        jumps = {point.index + 1 for point, _ in trace.marks if point.kind in (STICKING_BEGINS, STICKING_ENDS)}
        for first, last in pairwise((0, *sorted(jumps), len(trace.points))):
            points = trace.points[first:last]
            self._pieces.append((points, np.array([point.value for point in points])))

    @property
    def orbits(self) -> int:
        """How many orbits there are on all of them."""
        return sum(len(points) for points, _ in self._pieces)

    def have(self, point: CurvePoint) -> bool:
        """Whether an orbit lies on one of them."""
        orbit, value, rows = point.orbit, point.value, point.evaluation.section
        size = size_of(rows)
        for points, values in self._pieces:
            for k in np.flatnonzero((values[:-1] - value) * (values[1:] - value) <= 0):
                a, b = points[k], points[k + 1]
                if a.orbit.period == orbit.period and self._is_between(a, b, rows, value, SAME_ORBIT * size):
                    return True
        return False

    def _is_between(self, a: CurvePoint, b: CurvePoint, rows: np.ndarray, value: float, same: float) -> bool:
        """Whether an orbit with this section is one of those between two neighbours on a branch, to a distance."""
        share = (value - a.value) / (b.value - a.value) if b.value != a.value else 0.5
        guesses = [(a.orbit, a.value, MOST_WALK), (b.orbit, b.value, MOST_WALK)]
        if a.orbit.kinds == b.orbit.kinds:
            chord = b.orbit.unknowns - a.orbit.unknowns
            between = replace(a.orbit, unknowns=a.orbit.unknowns + share * chord)
            off = np.linalg.norm(rows - between.unknowns[:4], axis=1).min()
            if off > np.linalg.norm(chord[:4]) + same:  # neighbours are close enough for the curve to turn little
                return False
            guesses.insert(0, (between, value, 1))
        for known, begin, steps in guesses:
            for there in np.linspace(begin, value, steps + 1)[1:]:
                known = known and self.curve.corrected(known, float(there))
            if known is not None and self._is_orbit_through(known, value, rows, same):
                return True
        return False

    def _is_orbit_through(self, known: Orbit, value: float, rows: np.ndarray, same: float) -> bool:
        """Whether a solution on the curve of a branch is an orbit with this section; next to a grazing it may be none.

        On the way to it events may have passed the ends of the cycle.
        """
        there = CurvePoint(self.curve, known, value).within_cycle()
        near = (np.abs(rows - there.orbit.unknowns[:4]).max(axis=1) < same).any()
        return bool(near) and there.least_margin > -MARGIN_ROUNDING


STOPS = {"long_name": "stop at which events change, 1 of a bifurcation"}


@dataclass(frozen=True)
class Point:
    """A bifurcation, or a change of the sequence of events.

    Attributes
    ----------
    kind : str
        One of POINT_KINDS. A point has the same kind from both sides: where a contact opens there
        is a flight more on one of them. Where an impact begins or ceases to stick the motion jumps, and both ends of
        the jump are points.
    value : float
        The number over which the branch is followed, to 1e-10 of its range.
    period : int
        p of the orbit, in excitation periods.
    multipliers : (4,) complex ndarray
        Floquet multipliers, largest first; infinite at a grazing impact.
    state : (4,) ndarray
        ξ₁, ξ₁′, ξ₂, ξ₂′ at τ ≡ 0 mod pT.
    events : tuple of str
        What happens in the cycle, in its order: "impact", "stick", "chatter" and "release", or "touch" and "part".
    instants : (m,) ndarray
        When, in excitation periods.
    index : int
        Of the branch's value after which it lies.
    stop : int
        At which events change, 1 or 2; 1 of a bifurcation.
    """

    kind: str
    value: float
    period: int
    multipliers: np.ndarray
    state: np.ndarray
    events: tuple[str, ...]
    instants: np.ndarray
    index: int
    stop: int = 1

    @property
    def words(self) -> str:
        """The kind in words, with the stop if it is the second one."""
        return POINT_KINDS[self.kind].one + (" at the second stop" if self.stop == 2 else "")

    @property
    def is_crossing(self) -> bool:
        """Whether a multiplier passes the unit circle here."""
        return self.kind in BIFURCATIONS

    @property
    def critical_multiplier(self) -> complex:
        """The multiplier that passes the unit circle here, whatever others are larger; else the largest."""
        return POINT_KINDS[self.kind].critical(self.multipliers)


@dataclass(frozen=True)
class Branch:
    """Periodic motions along a branch, in the order in which they were followed.

    Attributes
    ----------
    over : str
        The number that varies.
    period : int
        p, excitation periods of the cycle.
    values : (n,) ndarray
        The number at each orbit.
    sections : (n, p, 4) ndarray
        ξ₁, ξ₁′, ξ₂, ξ₂′ at τ = 0, T, … (p − 1)T.
    multipliers : (n, 4) complex ndarray
        Largest first.
    sequences : tuple of (int, str)
        From which orbit on which events follow each other in the cycle.
    points : tuple of Point
    ends : (str, str)
        Why the branch ends where it begins, and where it ends.
    """

    over: str
    period: int
    values: np.ndarray
    sections: np.ndarray
    multipliers: np.ndarray
    sequences: tuple[tuple[int, str], ...]
    points: tuple[Point, ...]
    ends: tuple[str, str]

    @property
    def stable(self) -> np.ndarray:
        """Whether small disturbances die away, (n,) of bool."""
        return is_stable(self.multipliers)

    @property
    def stable_ranges(self) -> tuple[tuple[float, float], ...]:
        """The parts of the range over which orbits are stable, in the order in which they were followed.

        A part ends at the point at which the orbits become unstable, or else with the last stable orbit.
        """
        edges = np.flatnonzero(np.diff(np.concatenate([[0], self.stable.astype(int), [0]])))
        parts = (
            (self._edge(first - 1, first), self._edge(last - 1, last - 1), *self.values[first:last].tolist())
            for first, last in edges.reshape(-1, 2)
        )
        return tuple((min(part), max(part)) for part in parts)

    def _edge(self, index: int, stable: int) -> float:
        """The value at which stability changes between orbit ``index`` and the next; else that of a stable orbit."""
        between = [point for point in self.points if point.index == index]
        crossing = [point for point in between if point.is_crossing] or between
        return float(crossing[0].value if crossing else self.values[stable])

    def __repr__(self) -> str:
        low, high = self.values.min(), self.values.max()
        return (
            f"Branch(period {self.period} over {self.over} from {low:g} to {high:g}: {len(self.values)} orbits, "
            f"{np.mean(self.stable):.0%} stable, {len(self.points)} points)"
        )

    def _repr_html_(self) -> str:
        return html_table(repr(self), {f"{point.kind}, {self.over}": point.value for point in self.points})


def point_on_branch(curve: Curve, kind: str, point: CurvePoint, index: int, stop: int) -> Point:
    """The point of a branch at an orbit of its curve, where events change at a stop."""
    system, _, _ = curve.family.at(point.value)
    return Point(
        kind=kind,
        value=point.value,
        period=point.orbit.period,
        multipliers=point.multipliers,
        state=displaced_state(system, point.evaluation.section[0]),
        events=point.orbit.events,
        instants=point.orbit.instants,
        index=index,
        stop=stop,
    )


def branch_of_traces(family: Family, forwards: Trace, backwards: Trace | None, begins: str) -> Branch:
    """The branch, from the end of the second trace to that of the first.

    Parameters
    ----------
    family : Family
    forwards, backwards : Trace
        The second is None if the branch closes in itself, or begins at another one.
    begins : str
        The kind of the point of another branch at which this one begins; empty if it begins at none.
    """
    points, marks = list(forwards.points), [mark for mark, _ in forwards.marks]
    if backwards is not None:
        shift = len(backwards.points) - 1
        marks = [replace(mark, index=mark.index + shift) for mark in marks]
        before = [replace(mark, index=shift - 1 - mark.index) for mark, _ in backwards.marks]
        marks = before[::-1] + marks
        points = backwards.points[:0:-1] + points
    orbits = [point.orbit for point in points]
    changes = (k for k in range(1, len(orbits)) if not orbits[k].has_sequence_of(orbits[k - 1]))
    sequences = tuple((k, orbits[k].sequence) for k in (0, *changes))
    first = backwards.reason if backwards is not None else (f"begins at a {begins}" if begins else forwards.reason)
    return Branch(
        over=family.over,
        period=points[0].orbit.period,
        values=np.array([point.value for point in points]),
        sections=_sections(family, points),
        multipliers=multipliers_of([point.evaluation for point in points]),
        sequences=sequences,
        points=tuple(marks),
        ends=(first, forwards.reason),
    )


def _sections(family: Family, points: Sequence[CurvePoint]) -> np.ndarray:
    """ξ₁, ξ₁′, ξ₂, ξ₂′ of orbits at τ ≡ 0 mod T, (n, p, 4)."""
    sections = np.array([point.evaluation.section for point in points])
    if family.changes_system:
        systems = (family.at(point.value)[0] for point in points)
        return np.array([displaced_state(*each) for each in zip(systems, sections, strict=True)])
    return displaced_state(family.system, sections)


def branches_dataset(branches: Sequence[Branch], over: str | None = None) -> "xr.Dataset":
    """Branches of periodic motions, one after the other.

    Parameters
    ----------
    branches : sequence of Branch
        Over one number.
    over : str, optional
        That number; needed where there is no branch.

    Returns
    -------
    xarray.Dataset
        Of each ``orbit``: the number that varies, ``branch``, ``period``, ``stable``, ``section`` (cycle, coordinate;
        nan beyond the period), ``multiplier_real`` and ``multiplier_imag`` (multiplier). Of each ``point``: its kind,
        value, stop, branch and state.
    """
    import xarray as xr

    over = over or branches[0].over
    longest = max((branch.period for branch in branches), default=1)
    numbers = np.repeat(np.arange(len(branches)), np.array([len(branch.values) for branch in branches], dtype=int))
    periods = np.array([branch.period for branch in branches], dtype=int)[numbers]
    section = np.full((len(numbers), longest, 4), np.nan)
    for k, branch in enumerate(branches):
        section[numbers == k, : branch.period] = branch.sections
    multipliers = np.concatenate([np.empty((0, 4), complex), *(branch.multipliers for branch in branches)])
    values = np.concatenate([np.empty(0), *(branch.values for branch in branches)])
    stable = np.concatenate([np.empty(0, bool), *(branch.stable for branch in branches)])
    points = [(k, point) for k, branch in enumerate(branches) for point in branch.points]
    names = list(POINT_KINDS)
    kinds = np.array([names.index(point.kind) for _, point in points], dtype="i1")
    states = np.array([point.state for _, point in points]).reshape(-1, 4)
    flags = {"long_name": "kind of the point", "flag_values": list(range(len(names)))}
    flags["flag_meanings"] = " ".join(name.replace(" ", "_") for name in names)
    per_cycle, rows = "per cycle", ("orbit", "multiplier")
    return xr.Dataset(
        {
            over: labelled("orbit", values, "number that varies", "1"),
            "branch": labelled("orbit", numbers, "branch of the orbit", "1"),
            "period": labelled("orbit", periods, "excitation periods of the cycle", "1"),
            "stable": labelled("orbit", stable, "stable", "1"),
            "section": labelled(("orbit", "cycle", "coordinate"), section, "Poincaré section", f"{LENGTH}, {SPEED}"),
            "multiplier_real": labelled(rows, multipliers.real, "Floquet multipliers", per_cycle),
            "multiplier_imag": labelled(rows, multipliers.imag, "Floquet multipliers", per_cycle),
            "point_kind": ("point", kinds, flags),
            "point_value": labelled("point", [point.value for _, point in points], "number that varies", "1"),
            "point_stop": ("point", np.array([point.stop for _, point in points], dtype="i1"), STOPS),
            "point_branch": labelled("point", [k for k, _ in points], "branch of the point", "1"),
            "point_state": labelled(("point", "coordinate"), states, "state at tau = 0 mod T", f"{LENGTH}, {SPEED}"),
        },
        attrs={"over": over, "coordinates_of_states": " ".join(COORDINATES)},
    )
