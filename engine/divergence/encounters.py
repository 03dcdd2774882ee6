"""Impacts of the reference beside contacts of the penalty solution: which is which, when, and how they end.

An impact and a contact belong together if each is the nearest to the other in time and they are not farther apart than
an eighth of an excitation period. Impacts without a contact are lost, contacts without an impact are added: one lasting
contact takes up a whole chatter, and one that is damped too little bounces more often than the impact law.
"""

from dataclasses import dataclass

import numpy as np

from ..result import Response

NEAR = 0.125  # excitation periods
SHORT = 2.0  # half oscillations of the contact; longer ones are pressed by more than their own spring


@dataclass(frozen=True)
class Encounters:
    """How the contacts of a penalty solution match the impacts of the reference.

    Attributes
    ----------
    matched, lost, added : float
        Pairs, impacts without a contact, and contacts without an impact, in each excitation period.
    delay : float
        Mean of contact − impact over the pairs, as a share of T; nan if there is none.
    phase_error : float
        Root mean square of the same.
    restitution : float
        Restitution delivered: Σ parting / Σ closing speed over contacts of at most SHORT half oscillations, whatever
        they are matched with; nan if there is none.
    """

    matched: float
    lost: float
    added: float
    delay: float
    phase_error: float
    restitution: float


def encounters(reference: Response, penalty: Response, period: int, shift: int = 0) -> Encounters:
    """Match the kept impacts of two runs of equal length.

    Parameters
    ----------
    reference, penalty : Response
    period : int
        Excitation periods in the cycle of the reference.
    shift : int
        Excitation periods by which the reference was moved (see :mod:`.parts`).
    """
    keep = penalty.keep
    cycle = _periods(reference.impacts.time, reference)
    cycle = np.mod(cycle[cycle < period] - shift, period)
    one = np.sort((cycle + period * np.arange(-1, keep // period + 2)[:, None]).ravel())
    kept = _periods(penalty.impacts.time, penalty)
    other = np.concatenate([kept - keep, kept, kept + keep])  # the last period runs on into the first
    offset = _offsets(one, other)
    inside = (one >= 0) & (one < keep)
    apart = offset[inside & np.isfinite(offset)]
    matched = len(apart)
    return Encounters(
        matched=matched / keep,
        lost=(int(inside.sum()) - matched) / keep,
        added=(len(kept) - matched) / keep,
        delay=float(np.mean(apart)) if matched else np.nan,
        phase_error=float(np.sqrt(np.mean(apart**2))) if matched else np.nan,
        restitution=delivered_restitution(penalty),
    )


def delivered_restitution(penalty: Response) -> float:
    """Restitution that the short contacts of a penalty solution deliver, weighted by closing speed; nan without any."""
    hits = penalty.impacts
    begun = np.isin(penalty.contacts[:, 0], hits.time)
    lengths = np.diff(penalty.contacts[begun], axis=1)[:, 0]
    whole = np.isin(hits.time, penalty.contacts[:, 0])
    frequency = np.sqrt(penalty.method.stiffness / penalty.system.mass_share)  # ω_c² = K (1 + 1/μ)
    short = lengths <= SHORT * np.pi / frequency
    before, after = (np.diff(v[whole][short], axis=1).sum() for v in (hits.velocity_before, hits.velocity_after))
    return float(-after / before) if before < 0 else np.nan


def _periods(time: np.ndarray, response: Response) -> np.ndarray:
    """Instants in excitation periods since the beginning of the kept ones."""
    return (time - response.window[0]) / response.period


def _offsets(one: np.ndarray, other: np.ndarray) -> np.ndarray:
    """For each of ``one``: how much later its partner in ``other`` is, nan without a partner; both ascend."""
    if len(one) == 0 or len(other) == 0:
        return np.full(len(one), np.nan)
    nearest = _nearest(one, other)
    apart = other[nearest] - one
    mutual = _nearest(other, one)[nearest] == np.arange(len(one))
    return np.where(mutual & (np.abs(apart) <= NEAR), apart, np.nan)


def _nearest(of: np.ndarray, among: np.ndarray) -> np.ndarray:
    """Index of the nearest of ``among``, which ascends, to each of ``of``."""
    right = np.clip(np.searchsorted(among, of), 1, len(among) - 1) if len(among) > 1 else np.zeros(len(of), int)
    left = np.maximum(right - 1, 0)
    return np.where(of - among[left] <= among[right] - of, left, right)
