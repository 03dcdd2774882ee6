"""Section statistics of a response, by the same compiled code as those of the cells of a sweep."""

import numpy as np

from ..kernels import section_statistics as statistics
from ..methods import Newmark
from ..result import Response

UNKNOWN = -1


def section_numbers(response: Response, period: int = UNKNOWN) -> np.ndarray:
    """The numbers of :func:`engine.kernels.section_statistics.describe` for the kept periods, (NUMBERS,).

    Parameters
    ----------
    response : Response
        That reached its end.
    period : int
        Periods after which the motion repeats itself, 0 for never, if that is known.
    """
    rows, method = len(response.section), response.method
    # instants of the discrete solution are steps; those of a located step are not
    steps = method.steps if isinstance(method, Newmark) and not method.located else 0
    out = np.empty(statistics.NUMBERS)
    statistics.describe_run(
        response.section,
        np.ascontiguousarray(response.impacts.time),
        np.ascontiguousarray(response.contacts),
        response.checkpoint.periods,
        response.period,
        float(steps),
        period,
        np.zeros((rows, statistics.COLUMNS)),
        out,
    )
    return out
