"""Contacts with slow and fast modes, whose slow modes can be followed at their own pace."""

import numpy as np
from vibroscope.engine.kernels.event_driven import setup
from vibroscope.engine.kernels.linear.slow_subspace import SEPARATION


def separating_circles(rows: np.ndarray) -> np.ndarray:
    """A circle between the slow and the fast eigenvalues of each penalty contact.

    Parameters
    ----------
    rows : (n, len(Parameters)) ndarray
        Rows of :class:`engine.kernels.parameters.Parameters`.

    Returns
    -------
    (n, 2) ndarray
        Radius of the circle (see :mod:`engine.kernels.linear.slow_subspace`) and largest |eigenvalue| inside; zeros
        where the eigenvalues do not fall into groups.
    """
    circles = np.zeros((len(rows), 2))
    stiff = np.flatnonzero(setup.are_stiff(rows))
    if len(stiff) == 0:
        return circles
    sizes = np.sort(np.abs(np.linalg.eigvals(setup.full_pressed_generators(rows[stiff]))), axis=1)
    wide = sizes[:, 1:] > SEPARATION * sizes[:, :-1]
    last = wide.shape[1] - 1 - np.argmax(wide[:, ::-1], axis=1)  # between the fastest of the separate groups
    inner, outer = (np.take_along_axis(sizes, k[:, None], axis=1)[:, 0] for k in (last, last + 1))
    circles[stiff] = np.where(wide.any(axis=1)[:, None], np.column_stack([np.sqrt(inner * outer), inner]), 0.0)
    return circles
