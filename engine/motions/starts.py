"""Random starts of searches for motions that coexist: a box of states, with the bodies apart."""

import numpy as np
from vibroscope.engine.model import System


def reach_of(rows: np.ndarray) -> np.ndarray:
    """The largest displacement and the largest velocity of either body in states, (n, 4); at least 1 each."""
    return np.abs(rows).max(axis=0, initial=1.0).reshape(2, 2).max(axis=0)


def random_states(random: np.random.Generator, count: int, reach: np.ndarray) -> np.ndarray:
    """States ξ₁, ξ₁′, ξ₂, ξ₂′, (count, 4), up to a displacement and a velocity."""
    return random.uniform(-1, 1, (count, 4)) * reach[[0, 1, 0, 1]]


def apart(system: System, states: np.ndarray) -> np.ndarray:
    """States, (…, 4), with bodies that overlap in exchanged places; at a wall, reflected from it.

    Between two stops the gap is reflected from both until it lies within the play.
    """
    x1, v1, x2, v2 = np.moveaxis(states, -1, 0)
    if system.two_stops:
        x2 = np.zeros_like(x2) if system.wall else x2
        gap = system.play - np.abs(np.mod(system.gap(x1, x2), 2 * system.play) - system.play)
        return np.stack([system.clearance + x2 - gap, v1, x2, np.zeros_like(v2) if system.wall else v2], axis=-1)
    if system.wall:
        none = np.zeros_like(x1)
        return np.stack([np.minimum(x1, 2 * system.clearance - x1), v1, none, none], axis=-1)
    return np.stack([np.minimum(x1, x2 + system.clearance), v1, np.maximum(x2, x1 - system.clearance), v2], axis=-1)
