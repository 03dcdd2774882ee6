"""Many runs side by side: the bifurcation diagram over η (paper, Figure 3)."""

import os
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

import numpy as np

from .methods import Method
from .model import System
from .simulate import simulate


@dataclass(frozen=True)
class Diagram:
    """Bifurcation diagram from rest.

    Attributes
    ----------
    eta : (n,) ndarray
    displacement : (2, n, keep) ndarray of float32
        ξ₁ and ξ₂ at τ ≡ 0 mod T; nan in rows whose run ended early.
    """

    eta: np.ndarray
    displacement: np.ndarray


def bifurcation(
    system: System,
    eta: np.ndarray,
    method: Method,
    *,
    periods: int = 2050,
    keep: int = 50,
    progress: Callable[[int], None] | None = None,
) -> Diagram:
    """Poincaré sections over a range of η, each run from rest.

    Runs go to a pool of threads one by one (the kernels release the GIL), so that a hard η holds up no other.

    Parameters
    ----------
    eta : (n,) ndarray
    method : Reference or Newmark
    progress : callable, optional
        Called with the number of η done so far.

    Raises
    ------
    ValueError
        If a number is out of range (see :func:`engine.simulate`).
    """
    eta = np.asarray(eta, dtype=float)
    displacement = np.full((2, len(eta), keep), np.nan, dtype=np.float32)

    def fill(row: int) -> None:
        response = simulate(system, eta[row], method, periods=periods, keep=keep)
        if response.ok:
            displacement[:, row] = response.section[:, [0, 2]].T

    with ThreadPoolExecutor(os.cpu_count()) as pool:
        for done, _ in enumerate(pool.map(fill, range(len(eta))), start=1):
            if progress is not None:
                progress(done)
    return Diagram(eta, displacement)
