"""The runs that the paper's figures rest on: 2,050 periods from rest, of which the last 50 are shown."""

from __future__ import annotations

import numpy as np
from vibroscope.app.explorer.scenes import Scene
from vibroscope.engine import ExactPenalty, Method, Newmark, Record, Reference, Response, System, simulate

SYSTEM = System()
# What a printed phase plot can resolve: points that scatter (standard deviation) by less than this share of the
# section's largest coordinate look like one.
VISIBLE_SCATTER = 0.01
_SAMPLED = Record(12, 500)
TWO_PERIODS = Record(2, 1000)


def run_reference(scene: Scene, record: Record = _SAMPLED) -> Response:
    """The reference."""
    return run_method(scene, Reference(), record=record)


def run_newmark(scene: Scene, keep: int = 50, record: Record = _SAMPLED) -> Response:
    """The scene's penalty solution by Newmark's method; statistics need more than 50 kept periods."""
    return run_method(scene, Newmark(scene.K, scene.D, scene.steps), keep, record)


def run_exact(scene: Scene) -> Response:
    """The scene's penalty solution without a time step."""
    return run_method(scene, ExactPenalty(scene.K, scene.D))


def run_method(scene: Scene, method: Method, keep: int = 50, record: Record = _SAMPLED) -> Response:
    """2,000 periods from rest, and ``keep`` more that are kept."""
    return simulate(SYSTEM, scene.eta, method, periods=2000 + keep, keep=keep, record=record)


def section_size(section: np.ndarray) -> np.ndarray:
    """Largest coordinate of each section, (..., sample, 4)."""
    return np.abs(section).max(axis=(-2, -1))
