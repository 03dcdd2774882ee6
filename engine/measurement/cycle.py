"""One cycle of a periodic motion as a function of time, exact at its corners.

Between the samples of a run a cubic through displacements and velocities errs by h⁴; at an impact the velocity jumps,
and a cubic across it would err by h Δv. So each impact of the reference becomes a knot with one velocity before and
one after it, an instant apart.

(NumPy has no Hermite cubics, and SciPy, which has, is asked for only where constants are fitted.)
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ..methods import Newmark, Reference
from ..model import System
from ..motions.section import MOST_NEARLY, nearly_repeats_after
from ..motions.steady import steady
from ..result import Record, Response
from ..simulate import simulate

INSTANT = 1e-9  # of a cycle, between the knots before and after an impact
SAMPLES = 2000  # per period
NEWMARK_KEEP = 50


@dataclass(frozen=True)
class Cycle:
    """A motion that repeats.

    Attributes
    ----------
    eta : float
    periods : int
        Excitation periods in the cycle.
    closings : (m,) ndarray
        τ since the beginning of the cycle (τ ≡ 0 mod T) at which the pendulums meet.
    response : Response
        The run that the cycle is the end of.
    knots : (m,) ndarray
        τ since the beginning of the cycle, at which ``values`` (2, m), ξ₁ and ξ₂, and ``slopes`` (2, m), ξ₁′ and ξ₂′,
        are known.
    """

    eta: float
    periods: int
    closings: np.ndarray
    response: Response
    knots: np.ndarray
    values: np.ndarray
    slopes: np.ndarray

    @property
    def length(self) -> float:
        """τ until it repeats."""
        return 2 * np.pi / self.eta * self.periods

    def displacement(self, time: np.ndarray, frame: str = "relative") -> np.ndarray:
        """ξ₁, ξ₂ at the instants τ, (2, n), relative to the base or ``"absolute"``."""
        u, h, (left, right), (before, after) = self._between(time)
        found = left + u * u * (3 - 2 * u) * (right - left) + h * u * (1 - u) * ((1 - u) * before - u * after)
        return found + np.cos(self.eta * time) if frame == "absolute" else found

    def velocity(self, time: np.ndarray, frame: str = "relative") -> np.ndarray:
        """ξ₁′, ξ₂′ likewise."""
        u, h, (left, right), (before, after) = self._between(time)
        found = 6 * u * (1 - u) / h * (right - left) + (1 - u) * (1 - 3 * u) * before + u * (3 * u - 2) * after
        return found - self.eta * np.sin(self.eta * time) if frame == "absolute" else found

    def _between(self, time):
        """Share of the interval between two knots that has passed, its length, values and slopes at its ends."""
        within = np.mod(time, self.length)
        i = np.clip(np.searchsorted(self.knots, within, side="right") - 1, 0, len(self.knots) - 2)
        h = self.knots[i + 1] - self.knots[i]
        ends = [(array[:, i], array[:, i + 1]) for array in (self.values, self.slopes)]
        return (within - self.knots[i]) / h, h, *ends

    def touching(self, time: np.ndarray, step: float) -> np.ndarray:
        """Whether the pendulums touch at the instants τ or met within ``step`` before them, (n,)."""
        within = np.mod(time, self.length)
        begin = self.response.window[1] - self.length
        spans = self.response.contacts - begin
        closed = np.zeros(len(within), bool)
        for start, end in spans:  # a contact may have begun in the cycle before
            closed |= (within >= start) & (within <= end)
        for closing in self.closings:
            closed |= np.mod(within - closing, self.length) < step
        return closed


class Found(NamedTuple):
    """A run and the cycle that it settles to; None if it blew up or does not repeat."""

    response: Response
    cycle: Cycle | None


def reference_cycle(
    system: System,
    eta: float,
    method: Reference,
    *,
    initial: Sequence[float] = (0.0, 0.0, 0.0, 0.0),
    cancelled: Callable[[], bool] | None = None,
) -> Found:
    """The steady motion of the reference; arguments and errors are those of :func:`..motions.steady`."""
    found = steady(system, eta, method, initial=initial, record=Record(8, SAMPLES), cancelled=cancelled)
    return Found(found.response, _cycle(found.response, found.period) if found.periodic else None)


def penalty_cycle(
    system: System, eta: float, method: Newmark, *, periods: int = 2050, cancelled: Callable[[], bool] | None = None
) -> Found:
    """The last cycle of Newmark's run, its scatter forgiven; raises as :func:`engine.simulate`."""
    keep = min(NEWMARK_KEEP, periods)
    record = Record(min(MOST_NEARLY, keep), SAMPLES)
    response = simulate(system, eta, method, periods=periods, keep=keep, record=record, cancelled=cancelled)
    # not Motion.near_period: the steps' own artefact may repeat exactly after many periods
    repeats = nearly_repeats_after(response.section) if response.ok else 0
    return Found(response, _cycle(response, repeats) if repeats else None)


def _cycle(response: Response, periods: int) -> Cycle:
    length = periods * response.period
    begin = response.window[1] - length
    sampled, impacts = response.trajectory, response.impacts
    inside = (impacts.time > begin) & (impacts.time <= begin + length)
    time = sampled.time - begin
    values, slopes = sampled.displacement, sampled.velocity
    struck = impacts.time[inside] - begin
    if isinstance(response.method, Reference):
        there = np.repeat(impacts.position[inside][None], 2, axis=0)
        time = np.concatenate([time, struck - INSTANT * length, struck + INSTANT * length])
        values = np.concatenate([values, there, there], axis=1)
        slopes = np.concatenate([slopes, impacts.velocity_before[inside].T, impacts.velocity_after[inside].T], axis=1)
    order = np.argsort(time, kind="stable")
    order = order[time[order] > -INSTANT * length]  # Newmark was sampled for longer
    order = order[np.diff(time[order], prepend=-np.inf) >= INSTANT * length]
    return Cycle(response.eta, periods, struck, response, time[order], values[:, order], slopes[:, order])
