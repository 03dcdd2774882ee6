"""Impacts of the reference matched with contacts of the penalty solution: which, when, and how they end.

An impact and a contact belong together if each is the nearest to the other in time and they are at most an eighth of
an excitation period apart. Impacts without a contact are lost, contacts without an impact are added: a lasting contact
replaces a whole chatter, and a contact with too little damping bounces more often than the impact law.
"""

from dataclasses import dataclass

import numpy as np
from vibroscope.engine.contact import spring_duration
from vibroscope.engine.divergence.grid import rms
from vibroscope.engine.divergence.tolerances import NEAR_ENCOUNTER
from vibroscope.engine.motions.tolerances import SHORT_CONTACT
from vibroscope.engine.result import Response


@dataclass(frozen=True)
class Encounters:
    """How the contacts of a penalty solution match the impacts of the reference.

    Attributes
    ----------
    matched, lost, added : float
        Pairs, impacts without a contact, and contacts without an impact, per excitation period.
    delay : float
        Mean of contact − impact over the pairs, as a fraction of T; nan if there are none.
    phase_error : float
        Root mean square of the same.
    restitution : float
        Restitution delivered: Σ parting speed / Σ closing speed over all contacts of at most SHORT_CONTACT durations
        of a contact alone, matched or not; nan if there are none.
    """

    matched: float
    lost: float
    added: float
    delay: float
    phase_error: float
    restitution: float


def match_encounters(reference: Response, penalty: Response, period: int, shift: int) -> Encounters:
    """Match the kept impacts of two runs of equal length.

    Parameters
    ----------
    reference, penalty : Response
    period : int
        Excitation periods in the cycle of the reference.
    shift : int
        Excitation periods by which the reference was shifted (see :mod:`.parts`).
    """
    keep = penalty.keep
    cycle = _in_periods(reference.impacts.time, reference)
    cycle = np.mod(cycle[cycle < period] - shift, period)
    impacts = np.sort((cycle + period * np.arange(-1, keep // period + 2)[:, None]).ravel())
    kept = _in_periods(penalty.impacts.time, penalty)
    contacts = np.concatenate([kept - keep, kept, kept + keep])  # the first period follows the last one
    delays = _delays(impacts, contacts)
    inside = (impacts >= 0) & (impacts < keep)
    delays = delays[inside & np.isfinite(delays)]
    matched = len(delays)
    return Encounters(
        matched=matched / keep,
        lost=(int(inside.sum()) - matched) / keep,
        added=(len(kept) - matched) / keep,
        delay=float(np.mean(delays)) if matched else np.nan,
        phase_error=rms(delays) if matched else np.nan,
        restitution=delivered_restitution(penalty),
    )


def delivered_restitution(penalty: Response) -> float:
    """Return the restitution that the short contacts of a penalty solution deliver, weighted by closing speed.

    nan if there are none. Where the gap opens but the bodies still approach, the next contact continues this one.
    """
    _, closing, parting = short_contacts(penalty)
    met = closing.sum() - np.minimum(parting, 0.0).sum()
    return float(-np.maximum(parting, 0.0).sum() / met) if met < 0.0 else np.nan


def short_contacts(penalty: Response) -> np.ndarray:
    """Return duration, and relative velocity at both ends, of the contacts that only the bodies' meeting makes, (3, n).

    Those are contacts of at most SHORT_CONTACT durations of a contact alone.
    """
    impacts, contacts = penalty.impacts, penalty.contacts
    begun, whole = np.isin(contacts[:, 0], impacts.time), np.isin(impacts.time, contacts[:, 0])
    ends = contacts[begun], impacts.velocity_before[whole], impacts.velocity_after[whole]
    found = np.stack([np.diff(each, axis=1)[:, 0] for each in ends])
    found = found[:, found[1] < 0.0]
    alone = spring_duration(penalty.system.mass_share, penalty.method, -found[1])
    return found[:, found[0] <= SHORT_CONTACT * alone]


def mean_closing_speed(run: Response) -> float:
    """Return the mean closing speed of the kept impacts of a run, weighted by itself; nan if there are none."""
    closing = -np.diff(run.impacts.velocity_before, axis=1)
    closing = closing[closing > 0.0]
    return float((closing**2).sum() / closing.sum()) if len(closing) else np.nan


def _in_periods(time: np.ndarray, response: Response) -> np.ndarray:
    """Convert instants to excitation periods since the beginning of the kept periods."""
    return (time - response.window[0]) / response.period


def _delays(impacts: np.ndarray, contacts: np.ndarray) -> np.ndarray:
    """Return for each impact how much later its contact is, nan without one; both in ascending order."""
    if len(impacts) == 0 or len(contacts) == 0:
        return np.full(len(impacts), np.nan)
    nearest = _nearest(impacts, contacts)
    delays = contacts[nearest] - impacts
    mutual = _nearest(contacts, impacts)[nearest] == np.arange(len(impacts))
    return np.where(mutual & (np.abs(delays) <= NEAR_ENCOUNTER), delays, np.nan)


def _nearest(values: np.ndarray, candidates: np.ndarray) -> np.ndarray:
    """Return for each value the index of the nearest candidate: of two or more, in ascending order."""
    right = np.clip(np.searchsorted(candidates, values), 1, len(candidates) - 1)
    left = right - 1
    return np.where(values - candidates[left] <= candidates[right] - values, left, right)
