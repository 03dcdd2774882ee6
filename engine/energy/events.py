"""The balance of a motion that is in closed form between events, followed from each event to the next."""

from itertools import pairwise
from typing import NamedTuple

import numpy as np

from ..methods import Reference
from ..result import Response
from .balance import EnergyBalance
from .powers import Law, integrals, law_of

FLIGHT, TOUCHING, CHATTERING = range(3)  # the phases, in the order of `Law.generators`
EPSILON = np.finfo(float).eps
_BATCH = 2048


def along_events(response: Response, rows: np.ndarray) -> EnergyBalance:
    """The balance between consecutive rows of the section, (n + 1, 4)."""
    law, pieces = law_of(response), _pieces(response, rows)
    spans = np.array([piece.end - piece.begin for piece in pieces])
    modes = np.array([piece.mode for piece in pieces])
    sums = np.zeros((len(rows) - 1, 4))
    walk = _Walk(response, law, rows, sums)
    for low in range(0, len(pieces), _BATCH):
        part = slice(low, low + _BATCH)
        moves, held = np.zeros((len(spans[part]), 6, 6)), np.zeros((len(spans[part]), 3, 6, 6))
        for mode in np.unique(modes[part]):
            chosen = modes[part] == mode
            moves[chosen], held[chosen] = integrals(law.generators[mode], law.powers[mode], spans[part][chosen])
        # what the events of a coarse located step lead to can be beyond all numbers: told below, no cause for a warning
        with np.errstate(over="ignore", invalid="ignore"):
            for piece, span, move, form in zip(pieces[part], spans[part], moves, held, strict=True):
                walk.along(piece, span, move, form)
    sums[~np.isfinite(sums).all(axis=1)] = np.nan
    ends = np.array([walk.stored(walk.state(row)) for row in rows])
    work, dampers, contact, impacts = sums.T
    return EnergyBalance(np.diff(ends), work, dampers, contact, impacts, max(walk.most, float(ends.max())))


class _Piece(NamedTuple):
    """A stretch of one phase."""

    row: int  # kept period
    mode: int
    begin: float  # τ
    end: float
    impact: int  # index of the impact that it begins with, or −1
    clock: float  # the share of the period at which it ends; 0 if an event ends it


def _pieces(response: Response, rows: np.ndarray) -> list[_Piece]:
    """The phases between consecutive rows of the section, cut at events and at the quarters of each period."""
    period, last = response.period, round(response.window[1] / response.period)
    impacts, contacts = response.impacts.time, response.contacts
    rigid = isinstance(response.method, Reference)
    closed = contacts[contacts[:, 1] < response.window[1], 1]
    times = np.unique(np.concatenate([impacts if rigid else [], contacts[:, 0], closed]))
    bare = np.setdiff1d(contacts[:, 0], impacts)  # contacts that begin without an impact: at the end of a chatter
    pieces, first, chattering = [], last - (len(rows) - 1), False
    for n in range(first, last):
        shares = np.array([0.0, 0.25, 0.5, 0.75, 1.0])  # to see the energy between events too
        clock = (n + shares) * period
        events = times[(times > clock[0] if n > 0 else times >= 0) & (times < clock[-1])]
        cuts = np.union1d(clock, events)
        for begin, end in pairwise(cuts):
            k = np.searchsorted(contacts[:, 0], begin, side="right") - 1
            touching = k >= 0 and begin < contacts[k, 1]
            hit = int(np.searchsorted(impacts, begin, side="right")) - 1 if rigid else -1
            struck = hit >= 0 and impacts[hit] == begin and (begin > clock[0] or n == 0)
            following = times[min(np.searchsorted(times, begin, side="right"), len(times) - 1)] if len(times) else 0.0
            chattering = rigid and not touching and (struck or chattering) and following in bare
            mode = TOUCHING if touching else CHATTERING if chattering else FLIGHT
            by_clock = 0.0 if end in events else float(shares[np.searchsorted(clock, end)])
            pieces.append(_Piece(n - first, mode, begin, end, hit if struck else -1, by_clock))
    return pieces


class _Walk:
    """The way through the events, summing what each piece takes."""

    def __init__(self, response: Response, law: Law, rows: np.ndarray, sums: np.ndarray):
        self.response, self.law, self.rows, self.sums = response, law, rows, sums
        self.row, self.most = -1, 0.0

    @staticmethod
    def state(row: np.ndarray) -> np.ndarray:
        """z at the section."""
        return np.array([row[0], row[1], row[2] - row[0], row[3] - row[1], 1.0, 0.0])

    def stored(self, z: np.ndarray) -> float:
        """E."""
        return z @ self.law.stored @ z + 0.5 * self.law.stiffness * min(z[2], 0.0) ** 2

    def along(self, piece: _Piece, span: float, move: np.ndarray, held: np.ndarray) -> None:
        """Follow one piece."""
        if piece.row != self.row:
            self.row, self.elapsed, self.z = piece.row, 0.0, self.state(self.rows[piece.row])
        if piece.impact >= 0:
            self.strike(piece)
        z, a = self.z, self.law.generators[piece.mode]
        end = z + move @ z
        change = self.correction(piece, span, end, a)
        slope = a @ end
        self.sums[piece.row, :3] += z @ held @ z + change * (end @ self.law.powers[piece.mode] @ end)
        self.z = end + change * slope + 0.5 * change**2 * (a @ slope)
        self.elapsed += span + change
        self.most = max(self.most, float(self.stored(self.z)))
        if piece.clock == 0.0 and self.law.rigid:
            self.z[2] = 0.0

    def correction(self, piece: _Piece, span: float, end: np.ndarray, a: np.ndarray) -> float:
        """What the duration lacks: the times of events are rounded, what vanishes at them need not be."""
        if piece.clock > 0.0:
            return piece.clock * self.response.period - self.elapsed - span
        allowed = 4 * EPSILON * (piece.end + self.response.period)
        if piece.mode == CHATTERING:
            return 0.0
        row = self.law.ends[piece.mode]
        slope = row @ a @ end
        change = -(row @ end) / slope if slope != 0.0 else 0.0
        return change if abs(change) <= allowed else 0.0

    def strike(self, piece: _Piece) -> None:
        """Set out from an impact; the rest of a chatter loses its relative speed."""
        impacts, share = self.response.impacts, self.law.share
        v1, v2 = impacts.velocity_after[piece.impact]
        before = np.diff(impacts.velocity_before[piece.impact])[0]
        rate = v2 - v1
        if piece.mode != FLIGHT:
            v1, rate = v1 + share * rate, 0.0
        self.sums[piece.row, 3] += 0.5 * share * (before - rate) * (before + rate)
        self.z[:4] = impacts.position[piece.impact], v1, 0.0, rate
