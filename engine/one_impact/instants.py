"""A quantity over the instant of touch within a step: in pieces, whose ends are found and not sampled.

Along a piece a contact takes the same steps with the same statuses. For a law that is piecewise linear all that it
gives is then linear in the instant; for others it is smooth. A piece is accepted where a parabola through three of its
instants meets the restitution, the depth and the force at two more. Where the number of steps changes, or with it the
status of one, halving goes on until an end is known to the last digits.
"""

from typing import NamedTuple

import numpy as np
from vibroscope.engine.drivers.alone import (
    AT_REST,
    CODE,
    DEPTH,
    GAP,
    NONE,
    PARTED,
    PUSH,
    SPEED,
    STEPS,
    STUCK,
    TWO,
    UNSOLVED,
    Touches,
)

EDGE = 1e-12  # from a step, at which touch and step coincide, and the length of a piece that is none
FIRST = 12  # pieces to begin with
SHARES = np.array([0.0, 0.25, 0.5, 0.75, 1.0])  # of a piece, looked at
AT_QUARTERS = np.array([[3.0, 6.0, -1.0], [-1.0, 6.0, 3.0]]) / 8.0  # of a parabola through the others
WEIGHTS = np.array([1.0, 4.0, 2.0, 4.0, 1.0]) / 12.0  # of Simpson's rule
VERTEX = 1.0 / 64.0  # of its second difference, what a parabola adds between two instants at most: more off, it is none
MANY, SHORT = 200, 1e-6  # pieces sought at once, beyond which those so short are left: rounding decides there
MOST = 1000  # … beyond which all are: contacts so long that each instant has another course
SAME = [STEPS, NONE, TWO, CODE]  # along a piece


class Fineness(NamedTuple):
    """How close an answer is, in units of the contact."""

    watched: tuple[int, ...]  # columns that parabolas are to meet
    fits: float
    edge: float  # length of a piece that is none


FULL = Fineness((SPEED, DEPTH, PUSH), 1e-6, EDGE)
OUTLINE = Fineness((SPEED,), 1e-4, 1e-7)  # for a search, which asks for the restitution alone
ROUGH = Fineness((SPEED,), 1e-4, 1e-3)  # … and where that is far from a bound


def courses_of(same: np.ndarray) -> np.ndarray:
    """The courses of contacts, (…, 4), from what is the same along a piece.

    The steps of a contact that stays are those for which it was followed; whether it had such a step is its course.
    """
    stays = same[..., -1:] == STUCK
    return np.where(stays, (same > 0) * [0, 1, 1, 0] + [0, 0, 0, STUCK], same) if stays.any() else same


class Instants(NamedTuple):
    """Pieces in their order, each looked at at five instants."""

    instant: np.ndarray  # (n, 5), of touch, in steps after a step
    restitution: np.ndarray  # (n, 5); nan of a contact without a result
    depth: np.ndarray  # (n, 5)
    force: np.ndarray  # (n, 5), the largest
    steps: np.ndarray  # (n, 5), in which the force acts
    code: np.ndarray  # (n, 5), PARTED, BLOWN_UP, UNSOLVED or STUCK
    none: np.ndarray  # (n, 5), steps without a solution
    two: np.ndarray  # (n, 5), steps with two

    @property
    def length(self) -> np.ndarray:
        """Of each piece, (n,), as a share of a step."""
        return self.instant[:, -1] - self.instant[:, 0]

    @property
    def courses(self) -> np.ndarray:
        """Steps, of these without a solution and with two, and code, as they follow each other, (n, 4)."""
        every = np.stack([self.steps, self.none, self.two, self.code], axis=-1)
        every = courses_of(every).reshape(-1, len(SAME))
        return every[np.append(True, (every[1:] != every[:-1]).any(axis=1))]

    @property
    def unsolved(self) -> np.ndarray:
        """Whether a contact has a step without a solution, (n, 5)."""
        return (self.code == UNSOLVED) | (self.none > 0)

    @property
    def weight(self) -> np.ndarray:
        """Of each instant in an integral over them, (n, 5), by Simpson's rule in each piece."""
        return self.length[:, None] * WEIGHTS / self.length.sum()

    def share(self, of: np.ndarray) -> float:
        """The share of touches of which this is true, (n, 5)."""
        return float((self.weight * of).sum())

    def share_above(self, values: np.ndarray, level: float) -> float:
        """The share of touches with values, (n, 5), above a level; between two instants looked at along a line."""
        ends = np.stack([values[:, :-1], values[:, 1:]])
        low, high = ends.min(axis=0), ends.max(axis=0)
        flat = np.where(low > level, 1.0, 0.0)
        above = np.divide(high - level, high - low, out=flat, where=high > low)
        return float(self.length @ np.nan_to_num(np.clip(above, 0.0, 1.0)).mean(axis=1) / self.length.sum())

    def mean(self, values: np.ndarray) -> float:
        """The mean of values, (n, 5), of contacts with a result; nan without any."""
        known = np.isfinite(values)
        total = self.weight[known].sum()
        return float(self.weight[known] @ values[known] / total) if total else np.nan

    def ends(self, values: np.ndarray) -> tuple[float, float]:
        """The least and the greatest of values, (n, 5), of the contacts with a result; nan without any."""
        known = np.isfinite(values)
        if not known.any():
            return np.nan, np.nan
        pieces = values[known.all(axis=1) & (self.length > SHORT)]
        first, _, middle, _, last = pieces.T
        slope, bend = last - first, 2.0 * (first + last - 2.0 * middle)
        turn = 0.5 - 0.5 * np.divide(slope, bend, out=np.ones_like(bend), where=bend != 0.0)
        turns = first + slope * turn - bend * turn * (1.0 - turn)
        off = np.abs(pieces[:, 1::2] - pieces[:, ::2] @ AT_QUARTERS.T).max(axis=1, initial=0.0)
        counts = (turn > 0.0) & (turn < 1.0) & (off < VERTEX * np.abs(bend))
        every = np.concatenate([values[known], np.maximum(turns[counts], 0.0)])  # a parabola passes below a kink at 0
        return float(every.min()), float(every.max())


def over_instants(touches: Touches, fineness: Fineness = FULL) -> Instants:
    """Look at all instants of touch within a step, in units of the contact."""
    edges = np.linspace(EDGE, 1.0 - EDGE, FIRST + 1)
    instants = edges[:-1, None] + np.diff(edges)[:, None] * SHARES
    found, done = follow(touches, instants.ravel()).reshape(*instants.shape, -1), []
    while True:
        values = found[:, :, fineness.watched]
        fit = AT_QUARTERS @ values[:, ::2]
        fits = np.abs(values[:, 1::2] - fit).max(axis=(1, 2)) <= fineness.fits
        course = courses_of(found[:, :, SAME])
        same = (course == course[:, :1]).all(axis=(1, 2))
        short = instants[:, -1] - instants[:, 0] <= (fineness.edge if len(instants) < MANY else SHORT)
        accepted = (len(instants) > MOST) | (same & fits) | short
        done.append((instants[accepted], found[accepted]))
        instants, found = instants[~accepted], found[~accepted]
        if not len(instants):
            break
        between = 0.5 * (instants[:, :-1] + instants[:, 1:])
        looked = follow(touches, between.ravel()).reshape(*between.shape, -1)
        instants, found = _halves(instants, between), _halves(found, looked)
    instant, found = (np.concatenate(part) for part in zip(*done, strict=True))
    order = np.argsort(instant[:, 0], kind="stable")
    instant, found = instant[order], found[order]
    code = found[:, :, CODE]
    restitution = np.where(code == PARTED, found[:, :, SPEED], np.where(code == STUCK, 0.0, np.nan))
    every = Instants(instant, restitution, *(found[:, :, k] for k in (DEPTH, PUSH, STEPS, CODE, NONE, TWO)))
    if every.share(np.isfinite(restitution)) < SHORT:  # a lone instant: rounding decides
        restitution[:] = np.nan
    return every


def _halves(known: np.ndarray, between: np.ndarray) -> np.ndarray:
    """Five of each half, (2n, 5, …), from five of each piece, (n, 5, …), and the four between them, (n, 4, …)."""
    every = np.empty((len(known), 2 * len(SHARES) - 1, *known.shape[2:]))
    every[:, ::2], every[:, 1::2] = known, between
    return np.concatenate([every[:, : len(SHARES)], every[:, len(SHARES) - 1 :]])


def follow(touches: Touches, instants: np.ndarray) -> np.ndarray:
    """What the touches find, with the speed back at touch, from where a contact was seen to be over; 0 of others."""
    found = touches.run(instants)
    speed, code = found[:, SPEED], found[:, CODE]
    back = np.sqrt(np.maximum(0.0, speed**2 - 2.0 * touches.flight * found[:, GAP]))
    found[:, SPEED] = np.where(code == PARTED, back, 0.0)
    found[(code == PARTED) & (back < AT_REST), CODE] = STUCK
    return found
