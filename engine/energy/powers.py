"""Powers as quadratic forms of the state z = (ξ₁, ξ₁′, g, g′, cos ητ, sin ητ), and their integrals over a phase."""

from typing import NamedTuple

import numpy as np

from ..drivers.parameters import parameters_of
from ..kernels.equations.motion import joined_generator, pressed_generator, separated_generator
from ..methods import Reference
from ..result import Response

_TERMS = 16  # of a series in A s with |A| s ≤ 1/4
_STATE = np.eye(6)
_X1, _V1, _GAP, _RATE, _COSINE = _STATE[:5]


class Law(NamedTuple):
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


def law_of(response: Response) -> Law:
    """The law of a response in closed form, or with located steps."""
    c, eta, method = response.system, response.eta, response.method
    mu, x2, v2 = c.mass_ratio, _X1 + _GAP, _V1 + _RATE
    work = eta**2 * _square(_COSINE, _V1 + mu * v2)
    own = 2 * c.d1 * _square(_V1) + 2 * mu * c.d2 * c.kappa * _square(v2)
    none = np.zeros((6, 6))
    p = parameters_of(c, eta, method)
    flight = separated_generator(p)
    chatter = joined_generator(eta, c.kappa3, c.derived_joint_damping)
    rigid = isinstance(method, Reference)
    if rigid:
        d3 = c.joint_damping(method.joint_damping)
        touching = joined_generator(eta, c.kappa3, d3)
        taken = np.array([2 * (1 + mu) * d3 * c.kappa3 * _square(_V1), none])
        ends = _GAP, flight[3]  # the contact force is proportional to the free gap's acceleration
    else:
        touching = pressed_generator(p)
        taken = np.array([own, 2 * method.damping * _square(_RATE)])
        ends = _GAP, _GAP
    return Law(
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


def integrals(generator: np.ndarray, powers: np.ndarray, spans: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
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
