"""Averages over a motion and how uncertain they are.

Two kinds of averages are used. For *irregular* motion, batch means: the mean over each of several long batches scatters
as independent numbers do, so that their spread gives the standard error of the mean. For *regular* (periodic or
quasi-periodic) motion, an average with smooth weights, which converges faster than any power of 1/n.
"""

from functools import lru_cache

import numpy as np


def batch_means(values: np.ndarray, batches: int) -> np.ndarray:
    """Return the mean of each of ``batches`` consecutive batches of rows, (batches, …)."""
    if len(values) % batches == 0:
        return values.reshape(batches, -1, *values.shape[1:]).mean(axis=1)
    return np.array([batch.mean(axis=0) for batch in np.array_split(values, batches)])


def standard_error(means: np.ndarray) -> np.ndarray:
    """Return the standard error of the overall mean, from the means of independent batches (n, …)."""
    return np.std(means, axis=0, ddof=1) / np.sqrt(len(means))


@lru_cache(maxsize=32)
def smooth_weights(n: int) -> np.ndarray:
    """Return n weights ∝ exp(−1/(s(1 − s))), 0 < s < 1, of sum 1, which vanish with all derivatives at both ends.

    The average of a smooth function along a quasi-periodic motion then converges faster than any power of 1/n. Along a
    chaotic motion it converges as 1/√n, as with equal weights (Das, Saiki, Sander and Yorke, Nonlinearity 30 (2017)
    4111).
    """
    s = np.arange(1, n + 1) / (n + 1)
    weights = np.exp(-1 / (s * (1 - s)))
    weights /= weights.sum()
    weights.flags.writeable = False  # all callers share them
    return weights
