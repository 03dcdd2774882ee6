"""What kind of motion a response shows, read from its Poincaré section and its events."""

from dataclasses import dataclass

import numpy as np

from .result import Response

TOLERANCE = 1e-5  # of the section's size: points that differ by less count as the same
# A constant step mislocates every contact change, so a penalty section is rarely a point: what recurs within this
# share of its size (root mean square) nearly repeats. Only short cycles are worth the name.
SCATTER = 0.03
MOST_NEARLY = 4


@dataclass(frozen=True)
class Motion:
    """Steady motion over the kept periods.

    Attributes
    ----------
    period : int
        Excitation periods until the motion repeats itself; 0 if it does not within half of the kept periods.
    near_period : int
        The same, but scatter within SCATTER of the section's size is forgiven.
    impacts_per_period : float
    contacts_per_period : float
        Contacts that begin in a period (reference: permanent contacts).
    contact_share : float
        Share of the time in contact.
    spread : float
        Standard deviation of ξ₂ over the section (the paper's Figure 14 in one number).
    scatter : float
        The same about the points of the near period: what is left if a motion of several periods has several points.
    """

    period: int
    near_period: int
    impacts_per_period: float
    contacts_per_period: float
    contact_share: float
    spread: float
    scatter: float


def motion(response: Response) -> Motion:
    """Describe the kept periods of a response that reached its end; rates are those of whole cycles.

    Raises
    ------
    ValueError
        If the run ended early.
    """
    if not response.ok:
        raise ValueError(f"the run ended as {response.status}: {response.message}")
    section = response.section
    period = repeats_after(section)
    near = period or nearly_repeats_after(section)
    cycles = len(section) // near * near if near else len(section)
    end = response.window[1]
    begin = end - cycles * response.period
    spans = np.clip(response.contacts, begin, end)
    xi2 = section[len(section) - cycles :, 2].reshape(-1, near or 1)
    return Motion(
        period=period,
        near_period=near,
        impacts_per_period=int(np.sum(response.impacts.time > begin)) / cycles,
        contacts_per_period=int(np.sum(response.contacts[:, 0] > begin)) / cycles,
        contact_share=float(np.sum(spans[:, 1] - spans[:, 0]) / (end - begin)),
        spread=float(np.std(section[:, 2])),
        scatter=float(np.sqrt(np.mean(np.var(xi2, axis=0)))),
    )


def repeats_after(section: np.ndarray, tolerance: float = TOLERANCE) -> int:
    """Smallest p, at most half the rows, with section[i + p] = section[i] throughout; 0 if there is none.

    Parameters
    ----------
    section : (n, 4) ndarray
    tolerance : float
        Relative to the largest coordinate of the section.
    """
    allowed = tolerance * max(np.abs(section).max(initial=0.0), 1e-12)
    for p in range(1, len(section) // 2 + 1):
        if np.abs(section[p:] - section[:-p]).max() <= allowed:
            return p
    return 0


def nearly_repeats_after(section: np.ndarray) -> int:
    """Smallest p ≤ MOST_NEARLY after which the section recurs but for scatter; 0 if there is none."""
    allowed = SCATTER * np.abs(section).max(initial=0.0)
    for p in range(1, min(MOST_NEARLY, len(section) // 2) + 1):
        if np.sqrt(np.mean((section[p:] - section[:-p]) ** 2)) <= allowed:
            return p
    return 0
