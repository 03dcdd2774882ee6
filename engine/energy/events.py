"""Energy balance of a motion that is known in closed form between its events, followed from event to event.

The way from one row of the section to the next is cut into segments of a single phase: at the events, and at the
quarters of the period, where the stored energy is evaluated as well. On each segment the powers are integrated exactly
(:mod:`.quadratic_forms`). The state starts anew from each row of the section, so that errors do not add up.
"""

from collections.abc import Callable, Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from ..drivers.event_driven import contact_state
from ..result import Cancelled, Response
from .quadratic_forms import EnergyForms, energy_forms, phase_integrals
from .result import EnergyBalance

FLIGHT, CONTACT, CHATTER = range(3)  # phases, in the order of `EnergyForms.generators`
QUARTERS = np.array([0.0, 0.25, 0.5, 0.75, 1.0])
EPSILON = np.finfo(float).eps
_SEGMENTS_AT_ONCE = 1024


def balance_between_events(
    response: Response, rows: np.ndarray, cancelled: Callable[[], bool] | None = None
) -> EnergyBalance:
    """Balance the energy between consecutive rows of the section, (n + 1, 4): n periods."""
    forms, segments = energy_forms(response), _segments(response, len(rows) - 1)
    walk = _Walk(response, forms, rows)
    for first in range(0, len(segments), _SEGMENTS_AT_ONCE):
        if cancelled is not None and cancelled():
            raise Cancelled
        part = segments[first : first + _SEGMENTS_AT_ONCE]
        changes, integrals = _all_integrals(forms, part)
        # events of coarse located steps may lead beyond all numbers: then the sums are nan, see below
        with np.errstate(over="ignore", invalid="ignore"):
            for segment, change, integral in zip(part, changes, integrals, strict=True):
                walk.follow(segment, change, integral)
    sums = walk.sums
    sums[~np.isfinite(sums).all(axis=1)] = np.nan
    stored = np.array([walk.stored(walk.section_state(row)) for row in rows])
    work, dampers, contact, impacts = sums.T
    largest = max(walk.largest_stored, float(stored.max()))
    return EnergyBalance(np.diff(stored), work, dampers, contact, impacts, largest)


class _Segment(NamedTuple):
    """A part of one phase between two events, or between an event and a quarter of the period."""

    row: int  # kept period
    phase: int
    begin: float  # τ
    end: float
    impact: int  # index of the impact that it begins with, or −1
    quarter: float  # fraction of the period at which it ends; 0 if an event ends it


def _segments(response: Response, periods: int) -> list[_Segment]:
    """Cut the last ``periods`` periods at the events and at their quarters."""
    rigid = response.method.rigid
    impacts, contacts = response.impacts.time, response.contacts
    closed = contacts[contacts[:, 1] < response.window[1], 1]
    times = np.unique(np.concatenate([impacts if rigid else [], contacts[:, 0], closed]))
    without_impact = np.setdiff1d(contacts[:, 0], impacts)  # contacts at the end of a chatter
    last = round(response.window[1] / response.period)
    segments, chattering = [], False
    for period in range(last - periods, last):
        quarters = (period + QUARTERS) * response.period
        events = times[(times > quarters[0] if period > 0 else times >= 0) & (times < quarters[-1])]
        for begin, end in pairwise(np.union1d(quarters, events)):
            contact = np.searchsorted(contacts[:, 0], begin, side="right") - 1
            touching = contact >= 0 and begin < contacts[contact, 1]
            impact = int(np.searchsorted(impacts, begin, side="right")) - 1 if rigid else -1
            # the state at a row of the section already includes an impact there
            struck = impact >= 0 and impacts[impact] == begin and (begin > quarters[0] or period == 0)
            following = times[min(np.searchsorted(times, begin, side="right"), len(times) - 1)] if len(times) else 0.0
            chattering = rigid and not touching and (struck or chattering) and following in without_impact
            phase = CONTACT if touching else CHATTER if chattering else FLIGHT
            quarter = 0.0 if end in events else float(QUARTERS[np.searchsorted(quarters, end)])
            row = period - (last - periods)
            segments.append(_Segment(row, phase, begin, end, impact if struck else -1, quarter))
    return segments


def _all_integrals(forms: EnergyForms, segments: list[_Segment]) -> tuple[np.ndarray, np.ndarray]:
    """E − 1, (n, 6, 6), and the integrals of the powers, (n, 3, 6, 6), of n segments."""
    durations = np.array([segment.end - segment.begin for segment in segments])
    phases = np.array([segment.phase for segment in segments])
    changes, integrals = np.zeros((len(segments), 6, 6)), np.zeros((len(segments), 3, 6, 6))
    for phase in np.unique(phases):
        chosen = phases == phase
        changes[chosen], integrals[chosen] = phase_integrals(
            forms.generators[phase], forms.powers[phase], durations[chosen]
        )
    return changes, integrals


class _Walk:
    """Follows the state through all segments and sums what each of them dissipates."""

    def __init__(self, response: Response, forms: EnergyForms, rows: np.ndarray):
        self.response, self.forms, self.rows = response, forms, rows
        self.sums = np.zeros((len(rows) - 1, 4))  # of each period: work, dampers, contact damper, impacts
        self.largest_stored = 0.0
        self.row, self.elapsed, self.z = -1, 0.0, np.zeros(6)

    def section_state(self, row: np.ndarray) -> np.ndarray:
        """Return z, relative to the equilibrium of the flight, for a row ξ₁, ξ₁′, ξ₂, ξ₂′ of the section."""
        return np.array([*self.relative(row), 1.0, 0.0])

    def relative(self, state: Sequence[float]) -> np.ndarray:
        """Return the first four numbers of z, relative to the equilibrium of the flight."""
        y = contact_state(self.response.system, state)
        return y - np.array([self.forms.free_position, 0.0, self.forms.free_gap, 0.0])

    def stored(self, z: np.ndarray) -> float:
        """Return the mechanical energy E."""
        gap = z[2] + self.forms.free_gap
        return z @ self.forms.stored @ z + 0.5 * self.forms.stiffness * min(gap, 0.0) ** 2

    def follow(self, segment: _Segment, change: np.ndarray, integral: np.ndarray) -> None:
        """Move the state to the end of a segment and add the energies of the segment to the sums.

        Parameters
        ----------
        change : (6, 6) ndarray
            E − 1 over the duration of the segment.
        integral : (3, 6, 6) ndarray
            G of each power.
        """
        if segment.row != self.row:
            self.row, self.elapsed, self.z = segment.row, 0.0, self.section_state(self.rows[segment.row])
        if segment.impact >= 0:
            self._apply_impact(segment)
        generator, duration = self.forms.generators[segment.phase], segment.end - segment.begin
        equilibrium = self.forms.equilibria[segment.phase]
        z = self.z - equilibrium
        end = z + change @ z
        correction = self._duration_correction(segment, duration, end, generator)
        slope = generator @ end
        power = end @ self.forms.powers[segment.phase] @ end
        self.sums[segment.row, :3] += z @ integral @ z + correction * power
        self.z = end + correction * slope + 0.5 * correction**2 * (generator @ slope) + equilibrium
        self.elapsed += duration + correction
        self.largest_stored = max(self.largest_stored, float(self.stored(self.z)))
        if segment.quarter == 0.0 and self.forms.rigid:
            self.z[2] = -self.forms.free_gap

    def _duration_correction(self, segment: _Segment, duration: float, end: np.ndarray, generator: np.ndarray) -> float:
        """Return the rounding error of the duration: the quantity that ends a phase vanishes at its exact end."""
        if segment.quarter > 0.0:
            return segment.quarter * self.response.period - self.elapsed - duration
        if segment.phase == CHATTER:
            return 0.0
        row = self.forms.ends[segment.phase]
        slope = row @ generator @ end
        value = row @ (end + self.forms.equilibria[segment.phase]) + self.forms.levels[segment.phase]
        correction = -value / slope if slope != 0.0 else 0.0
        allowed = 4 * EPSILON * (segment.end + self.response.period)
        return correction if abs(correction) <= allowed else 0.0

    def _apply_impact(self, segment: _Segment) -> None:
        """Set the state after an impact. If the rest of a chatter follows, it dissipates all relative motion."""
        impacts, share = self.response.impacts, self.forms.mass_share
        v1, v2 = impacts.velocity_after[segment.impact]
        x1, x2 = impacts.position[segment.impact], impacts.position2(self.response.system)[segment.impact]
        before = np.diff(impacts.velocity_before[segment.impact])[0]
        after = v2 - v1
        if segment.phase != FLIGHT:
            v1 = 0.0 if self.response.system.wall else v1 + share * after
            after, v2 = 0.0, v1
        self.sums[segment.row, 3] += 0.5 * share * (before - after) * (before + after)
        self.z[:4] = self.relative((x1, v1, x2, v2))
        self.z[2], self.z[3] = -self.forms.free_gap, after
