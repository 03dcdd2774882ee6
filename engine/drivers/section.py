"""Section statistics by the compiled code that also describes the cells of a sweep."""

import numpy as np
from vibroscope.engine.kernels import section_statistics as statistics
from vibroscope.engine.kernels.section_statistics import LONGEST_NEAR_PERIOD as LONGEST_NEAR_PERIOD
from vibroscope.engine.kernels.section_statistics import NEAR_TOLERANCE as NEAR_TOLERANCE
from vibroscope.engine.kernels.section_statistics import TOLERANCE
from vibroscope.engine.result import Response

UNKNOWN = -1


def period_of(section: np.ndarray, tolerance: float = TOLERANCE) -> int:
    """Smallest p, at most half the rows, with section[i + p] = section[i] throughout; 0 if there is none.

    Parameters
    ----------
    section : (n, 4) ndarray
    tolerance : float
        Relative to the size of the section (:func:`sizes_of`).
    """
    return statistics.period_of(np.ascontiguousarray(section), len(section), tolerance)


def periods_of(sections: np.ndarray, tolerance: float = TOLERANCE, dying: float = 0.0) -> np.ndarray:
    """Smallest p of many sections, (n, rows, 4), as of :func:`period_of`: (n,) of int.

    ``dying``: where the difference between points p periods apart falls below this share from the first half of a
    section to the second, it is the rest of a transient, and p counts.
    """
    out = np.zeros(len(sections), dtype=np.int64)
    statistics.write_settled_periods(np.ascontiguousarray(sections), tolerance, dying, out)
    return out


def sizes_of(sections: np.ndarray) -> np.ndarray:
    """Sizes of many sections, (n, rows, 4), beside which differences between their points are small or not: (n,).

    The largest coordinate; or, beside a displacement that a constant force keeps, the largest deviation from the mean.
    """
    out = np.empty(len(sections))
    statistics.write_sizes(np.ascontiguousarray(sections), out)
    return out


def name_numbers(numbers: np.ndarray) -> dict[str, np.ndarray]:
    """The numbers of a description by their names; the last axis is theirs."""
    return {
        "period": numbers[..., statistics.PERIOD],
        "near_period": numbers[..., statistics.NEAR_PERIOD],
        "impacts_per_period": numbers[..., statistics.IMPACTS_PER_PERIOD],
        "contacts_per_period": numbers[..., statistics.CONTACTS_PER_PERIOD],
        "contact_share": numbers[..., statistics.SHARE_IN_CONTACT],
        "spread": numbers[..., statistics.SPREAD],
        "scatter": numbers[..., statistics.SCATTER],
        "longest_contact": numbers[..., statistics.LONGEST],  # in periods
        "impact_phase": numbers[..., statistics.IMPACT_PHASE],
    }


def describe_section(response: Response, period: int | None = None) -> np.ndarray:
    """The numbers that :func:`name_numbers` names, for the kept periods of a response that reached its end.

    Parameters
    ----------
    response : Response
    period : int, optional
        Periods after which the motion repeats itself, 0 for never, if that is known.
    """
    rows = len(response.section)
    out = np.empty(statistics.NUMBERS)
    statistics.describe_run(
        np.ascontiguousarray(response.section),
        np.ascontiguousarray(response.impacts.time),
        np.ascontiguousarray(response.contacts),
        (response.checkpoint.periods, response.period, float(response.method.grid_steps)),
        UNKNOWN if period is None else period,
        response.system.observed_body,
        np.zeros((rows, statistics.COLUMNS)),
        out,
    )
    return out
