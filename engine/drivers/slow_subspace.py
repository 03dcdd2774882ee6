"""Which contacts have modes of very different speed, so that the slow ones can be followed at their own pace."""

import numpy as np

from ..kernels.event_driven import setup
from ..kernels.linear.slow_subspace import APART


def circles(numbers: np.ndarray) -> np.ndarray:
    """For each cell in penalty contact a circle between its slow and its fast eigenvalues.

    Parameters
    ----------
    numbers : (n, len(Cell)) ndarray
        Rows of :class:`engine.kernels.event_driven.setup.Cell`.

    Returns
    -------
    (n, 2) ndarray
        Radius of the circle (see :mod:`..kernels.linear.slow_subspace`) and largest |eigenvalue| within; zeros where
        the eigenvalues do not fall into groups.
    """
    found = np.zeros((len(numbers), 2))
    stiff = np.flatnonzero(setup.are_stiff(numbers))
    if len(stiff) == 0:
        return found
    sizes = np.sort(np.abs(np.linalg.eigvals(setup.pressed_generators(numbers[stiff]))), axis=1)
    wide = sizes[:, 1:] > APART * sizes[:, :-1]
    last = wide.shape[1] - 1 - np.argmax(wide[:, ::-1], axis=1)  # the fastest of the groups that stand apart
    inner, outer = (np.take_along_axis(sizes, k[:, None], axis=1)[:, 0] for k in (last, last + 1))
    found[stiff] = np.where(wide.any(axis=1)[:, None], np.column_stack([np.sqrt(inner * outer), inner]), 0.0)
    return found
