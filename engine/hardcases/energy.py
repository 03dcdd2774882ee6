"""Energy balance of a response: what the excitation puts in, and where it goes.

    gain of mechanical energy = work of the excitation − dampers − contact damper − impacts

in units of m₁ω₁² times the base amplitude squared. The mechanical energy is that of the motion relative to the base,

    E = [ξ₁′² + ξ₁² + μ(ξ₂′² + κ²ξ₂²) + K min(g, 0)²] / 2,

K = 0 for the reference; the powers are η² cos ητ (ξ₁′ + μξ₂′) for the excitation, 2d₁ξ₁′² + 2μd₂κξ₂′² for the dampers
(2d₃κ₃(1 + μ)ξ′² while joined), 2Dg′² for the contact damper; an impact takes μ/(1 + μ) (g′⁻² − g′⁺²)/2.

The balance knows nothing of how the motion was marched. The reference, the exact penalty and the located step are
followed from one row of the section through the events of the response to the next row: between two events z′ = A z
(:mod:`..kernels.phase`), so that every power is a quadratic form zᵀQz with the integral

    ∫₀ˢ zᵀQz dτ = z(0)ᵀ G(s) z(0),    G(2s) = G(s) + E(s)ᵀ G(s) E(s),    E(2s) = E(s)².

An event missed, misplaced or misjudged leaves a residual. For Newmark with a constant step the sums are those of
the discrete solution, which balances exactly within each step: the residual is the energy that the steps make where
contact changes.
"""

from dataclasses import dataclass
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from ..kernels import pendulums
from ..methods import Newmark, Reference
from ..result import Response

FLIGHT, TOUCHING, CHATTERING = range(3)
EPSILON = np.finfo(float).eps
_TERMS = 16  # of a series in A s with |A| s ≤ 1/4
_BATCH = 2048
_STATE = np.eye(6)
_X1, _V1, _GAP, _RATE, _COSINE = _STATE[:5]


@dataclass(frozen=True)
class EnergyBalance:
    """Energy over each kept period, in units of m₁ω₁² times the base amplitude squared; all (n,) ndarrays.

    Attributes
    ----------
    gain : ndarray
        What mechanical energy grows by.
    work : ndarray
        Work of the excitation on both masses, relative to the base.
    dampers : ndarray
        What the dampers of the pendulums take; while they are joined, that of the joint.
    contact : ndarray
        What the contact damper takes (penalty).
    impacts : ndarray
        What impacts take (reference).
    stored : float
        Largest mechanical energy met: at events, and at the quarters of each period.
    """

    gain: np.ndarray
    work: np.ndarray
    dampers: np.ndarray
    contact: np.ndarray
    impacts: np.ndarray
    stored: float

    @property
    def lost(self) -> np.ndarray:
        """What dampers, contact and impacts take."""
        return self.dampers + self.contact + self.impacts

    @property
    def residual(self) -> np.ndarray:
        """Gain + losses − work; 0 but for errors of the solution."""
        return self.gain + self.lost - self.work

    @property
    def size(self) -> float:
        """What a residual compares with: the energy stored, or put in or taken within a period."""
        return float(self.stored + max(np.abs(self.work).max(initial=0.0), self.lost.max(initial=0.0)))


def energy(response: Response, start: tuple[float, float, float, float] | None = None) -> EnergyBalance:
    """Energy balance of the kept periods of a response.

    Parameters
    ----------
    response : Response
        Of Newmark with a constant step: with every step of its sampled periods recorded; these are balanced.
    start : (4,) sequence, optional
        ξ₁, ξ₁′, ξ₂, ξ₂′ at the beginning of the kept periods: what the run was started with, if all periods are kept.
        Without it the balance begins with the second kept period, since a section is read at the end of periods.

    Returns
    -------
    EnergyBalance

    Raises
    ------
    ValueError
        If the run ended early, if too few periods are kept, or if Newmark's steps were not all recorded.
    """
    if not response.ok:
        raise ValueError(f"the run ended as {response.status}: {response.message}")
    if isinstance(response.method, Newmark) and not response.method.located:
        return _of_steps(response)
    rows = response.section if start is None else np.vstack([np.asarray(start, dtype=float), response.section])
    if len(rows) < 2:
        raise ValueError("one kept period has no beginning to balance from: keep two, or give the start")
    return _of_phases(response, rows)


# ------------------------------------------------------------------------------------------------ powers and phases


class _Law(NamedTuple):
    """What the balance takes from the system: generators of the phases and their powers as quadratic forms of z."""

    generators: tuple[np.ndarray, ...]  # (6, 6) in flight, in contact, in the rest of a chatter
    powers: tuple[np.ndarray, ...]  # (3, 6, 6): work, dampers, contact damper
    stored: np.ndarray  # (6, 6) E but for the contact spring
    stiffness: float
    share: float
    ends: tuple[np.ndarray, ...]  # rows on z that are zero where flight and contact end
    rigid: bool


def _square(row: np.ndarray, other: np.ndarray | None = None) -> np.ndarray:
    other = row if other is None else other
    return 0.5 * (np.outer(row, other) + np.outer(other, row))


def _law(response: Response) -> _Law:
    c, eta, method = response.system, response.eta, response.method
    mu, x2, v2 = c.mass_ratio, _X1 + _GAP, _V1 + _RATE
    work = eta**2 * _square(_COSINE, _V1 + mu * v2)
    own = 2 * c.d1 * _square(_V1) + 2 * mu * c.d2 * c.kappa * _square(v2)
    none = np.zeros((6, 6))
    flight = pendulums.separated(eta, c.kappa, c.d1, c.d2)
    chatter = pendulums.joined(eta, c.kappa3, c.derived_joint_damping)
    rigid = isinstance(method, Reference)
    if rigid:
        d3 = c.joint_damping(method.joint_damping)
        touching = pendulums.joined(eta, c.kappa3, d3)
        taken = np.array([2 * (1 + mu) * d3 * c.kappa3 * _square(_V1), none])
        ends = _GAP, flight[3]  # the contact force is proportional to the free gap's acceleration
    else:
        touching = pendulums.pressed(eta, c.kappa, c.d1, c.d2, mu, method.stiffness, method.damping)
        taken = np.array([own, 2 * method.damping * _square(_RATE)])
        ends = _GAP, _GAP
    return _Law(
        generators=tuple(_full(upper, eta) for upper in (flight, touching, chatter)),
        powers=(np.array([work, own, none]), np.array([work, *taken]), np.array([work, own, none])),
        stored=0.5 * (_square(_V1) + _square(_X1) + mu * (_square(v2) + c.kappa**2 * _square(x2))),
        stiffness=0.0 if rigid else method.stiffness,
        share=c.mass_share,
        ends=ends,
        rigid=rigid,
    )


def _full(upper: np.ndarray, eta: float) -> np.ndarray:
    a = np.zeros((6, 6))
    a[:4] = upper
    a[4, 5], a[5, 4] = -eta, eta
    return a


def _integrals(generator: np.ndarray, powers: np.ndarray, spans: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """E(s) − 1, (n, 6, 6), and G(s) of each power, (n, 3, 6, 6), for n durations s, by doubling.

    Doubled is E − 1, so that a slow motion keeps its digits beside a stiff contact.
    """
    # measured in units of its own frequency a stiff gap has a speed of its own size
    unit = np.sqrt(max(1.0, np.abs(generator[3, 2])))
    scale = np.array([1.0, 1.0, 1.0 / unit, 1.0, 1.0, 1.0])
    a = generator * (scale[None, :] / scale[:, None])
    forms = powers * (scale[:, None] * scale[None, :])
    longest = np.abs(a).sum(axis=1).max() * spans.max(initial=0.0)
    doublings = max(0, int(np.ceil(np.log2(max(longest, 1e-300) * 4))))
    h = (spans / 2.0**doublings)[:, None, None]
    move, power = np.zeros((len(spans), 6, 6)), np.eye(6)
    held, form = np.zeros((len(spans), 3, 6, 6)), forms.copy()
    for k in range(1, _TERMS):
        held += form * h[:, None] ** k
        form = (a.T @ form + form @ a) / (k + 1)
        power = power @ a / k
        move += power * h**k
    for _ in range(doublings):
        after = move[:, None] + np.eye(6)
        held += np.swapaxes(after, 2, 3) @ held @ after
        move = 2 * move + move @ move
    return move * (scale[:, None] / scale[None, :]), held / (scale[:, None] * scale[None, :])


# ------------------------------------------------------------------------------------------------ from event to event


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


def _of_phases(response: Response, rows: np.ndarray) -> EnergyBalance:
    law, pieces = _law(response), _pieces(response, rows)
    spans = np.array([piece.end - piece.begin for piece in pieces])
    modes = np.array([piece.mode for piece in pieces])
    sums = np.zeros((len(rows) - 1, 4))
    walk = _Walk(response, law, rows, sums)
    for low in range(0, len(pieces), _BATCH):
        part = slice(low, low + _BATCH)
        moves, held = np.zeros((len(spans[part]), 6, 6)), np.zeros((len(spans[part]), 3, 6, 6))
        for mode in np.unique(modes[part]):
            chosen = modes[part] == mode
            moves[chosen], held[chosen] = _integrals(law.generators[mode], law.powers[mode], spans[part][chosen])
        for piece, span, move, form in zip(pieces[part], spans[part], moves, held, strict=True):
            walk.along(piece, span, move, form)
    ends = np.array([walk.stored(walk.state(row)) for row in rows])
    work, dampers, contact, impacts = sums.T
    return EnergyBalance(np.diff(ends), work, dampers, contact, impacts, max(walk.most, float(ends.max())))


class _Walk:
    """The way through the events, summing what each piece takes."""

    def __init__(self, response: Response, law: _Law, rows: np.ndarray, sums: np.ndarray):
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
        """Set out from an impact; the rest of a chatter loses its relative speed (:mod:`..kernels.chatter`)."""
        impacts, share = self.response.impacts, self.law.share
        v1, v2 = impacts.velocity_after[piece.impact]
        before = np.diff(impacts.velocity_before[piece.impact])[0]
        rate = v2 - v1
        if piece.mode != FLIGHT:
            v1, rate = v1 + share * rate, 0.0
        self.sums[piece.row, 3] += 0.5 * share * (before - rate) * (before + rate)
        self.z[:4] = impacts.position[piece.impact], v1, 0.0, rate


# ------------------------------------------------------------------------------------------------ from step to step


def _of_steps(response: Response) -> EnergyBalance:
    """The balance of the discrete solution: Δξ = Δτ·mean ξ′ and Δξ′ = Δτ·mean ξ″ in each step."""
    sampled, c, method = response.trajectory, response.system, response.method
    if sampled is None or not np.isclose(sampled.time[1] - sampled.time[0], response.period / method.steps, rtol=1e-3):
        raise ValueError("Newmark's energy is balanced step by step: record every step of the sampled periods")
    periods = (len(sampled.time) - 1) // method.steps
    mu, h = c.mass_ratio, response.period / method.steps
    x, v, force = sampled.displacement, sampled.velocity, sampled.force
    mean = 0.5 * (v[:, 1:] + v[:, :-1])
    phase = np.arange(len(sampled.time)) % method.steps * (2 * np.pi / method.steps)
    load = response.eta**2 * np.cos(phase)
    gap, rate = x[1] - x[0], mean[1] - mean[0]
    # what the force λ takes from the pendulums, less what its spring stores, is the contact damper's
    spring = 0.5 * method.stiffness * np.minimum(gap, 0.0) ** 2
    contact = -h * 0.5 * (force[1:] + force[:-1]) * rate - np.diff(spring)
    stored = 0.5 * (v[0] ** 2 + x[0] ** 2 + mu * (v[1] ** 2 + (c.kappa * x[1]) ** 2)) + spring
    ends = stored[:: method.steps]

    def per_period(each):
        return each.reshape(periods, method.steps).sum(axis=1)

    return EnergyBalance(
        gain=np.diff(ends),
        work=per_period(h * 0.5 * (load[1:] + load[:-1]) * (mean[0] + mu * mean[1])),
        dampers=per_period(2 * h * (c.d1 * mean[0] ** 2 + mu * c.d2 * c.kappa * mean[1] ** 2)),
        contact=per_period(contact),
        impacts=np.zeros(periods),
        stored=float(stored.max()),
    )
