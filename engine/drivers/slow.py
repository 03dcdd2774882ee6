"""Parting the fast motion of a stiff or strongly damped contact from the slow one.

Pressed together, the pendulums have modes of very different speed: on the contact spring and damper, and with their own
springs. The fast ones die away, and then need not be followed at their pace: what is left of the state lies in the
invariant subspace of the slow eigenvalues and obeys z′ = A P z, P the projector on it,

    P = 1/(2πi) ∮ (ζ − A)⁻¹ dζ

around a circle between the two groups. The trapezoidal rule on it converges as the q-th power of the ratio of a radius
and an eigenvalue, q the number of its nodes, whether or not eigenvalues within a group coincide.
"""

import numpy as np

NODES = 96
APART = 30.0  # least ratio of the two groups: less is not worth a table of its own


def split(generator: np.ndarray) -> tuple[np.ndarray, float] | None:
    """The part of the state that is fast, and how fast the rest is; None if the eigenvalues do not fall into groups.

    Parameters
    ----------
    generator : (6, 6) ndarray
        A.

    Returns
    -------
    (6, 6) ndarray
        1 − P: the fastest of the groups that stand apart.
    float
        Largest |eigenvalue| of the slow group.
    """
    sizes = np.sort(np.abs(np.linalg.eigvals(generator)))
    gaps = np.flatnonzero(sizes[1:] > APART * sizes[:-1])
    if len(gaps) == 0:
        return None
    last = gaps[-1]
    radius = np.sqrt(sizes[last] * sizes[last + 1])
    nodes = radius * np.exp(2j * np.pi * (np.arange(NODES) + 0.5) / NODES)
    resolvents = np.linalg.inv(nodes[:, None, None] * np.eye(6) - generator)
    slow = (nodes[:, None, None] * resolvents).mean(axis=0).real
    return np.eye(6) - slow, float(sizes[last])
