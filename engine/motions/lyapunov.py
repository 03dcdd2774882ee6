"""The largest Lyapunov exponent, from the exact Jacobian of the Poincaré map.

A small disturbance v of a motion becomes DP v after each excitation period; its growth ln |DP v| / |v|, with v brought
back to length 1 each time, averages to the largest Lyapunov exponent λ. DP is exact, impacts and contact changes
included (the saltation matrices of :mod:`..kernels.event_driven.saltation`), so that no second run and
no size of a disturbance enter.

How sure the average is depends on the motion:

- *Irregular*: the growth is random with a memory of some periods. Averages over batches much longer than that scatter
  as independent ones do, and their standard error is that of λ (batch means).
- *Regular* (periodic or quasi-periodic): the growth is a smooth function along the motion, and the average with the
  weights of :func:`.section.bump` converges faster than any power of 1/n. The error is what the two halves of the
  run differ by.

Which of the two it is the section tells (:func:`.section.irregularity`). λ is only that of the motion while it
was followed: a chaotic transient is longer than any run now and then.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from ..methods import ExactPenalty, Reference
from ..model import System, check_eta, whole
from ..simulate import starting_checkpoint
from .poincare_map import PoincareMap, coordinates, displacements
from .section import bump, irregularity

BATCHES = 32
SETTLING = 64  # periods in which a disturbance turns into the direction that grows most
# Between regular motions, whose sections fall below this within thousands of periods unless their tori are about to
# break, and chaotic ones, of which eight averages would have to agree so well by chance
REGULAR = 1e-5
PERIODS_RANGE = (BATCHES * 8, 10_000_000)


@dataclass(frozen=True)
class Lyapunov:
    """Outcome of :func:`lyapunov`; nan where the motion could not be followed.

    Attributes
    ----------
    exponent : float
        λ per excitation period.
    error : float
        Its standard error.
    drift : float
        Difference of the averages over the two halves of the run, in units of its own standard error: some 1 unless
        the motion changes on the way.
    irregularity : float
        Of the section (:func:`.section.irregularity`).
    section : (n, 4) ndarray
        ξ₁, ξ₁′, ξ₂, ξ₂′ at the end of each period.
    """

    exponent: float
    error: float
    drift: float
    irregularity: float
    section: np.ndarray

    @property
    def regular(self) -> bool:
        """Whether the motion is periodic or quasi-periodic, as far as its section tells."""
        return self.irregularity < REGULAR

    @property
    def sign(self) -> int:
        """1 or −1 if the exponent is told from zero: by 3 standard errors, and over the run at all; else 0."""
        least = max(3 * self.error, 1 / max(len(self.section), 1))
        return int(self.exponent > least) - int(self.exponent < -least)


def lyapunov(
    system: System,
    eta: float,
    method: Reference | ExactPenalty,
    *,
    initial: Sequence[float] = (0.0, 0.0, 0.0, 0.0),
    periods: int = 8192,
    cancelled: Callable[[], bool] | None = None,
) -> Lyapunov:
    """Largest Lyapunov exponent of the motion that begins at ``initial``.

    Parameters
    ----------
    system : System
    eta : float
        Excitation frequency η = Ω/ω₁.
    method : Reference or ExactPenalty
        A solver in closed form.
    initial : (4,) sequence
        ξ₁, ξ₁′, ξ₂, ξ₂′ at τ ≡ 0 mod T, the transient past (64 more periods are not counted).
    periods : int
        Excitation periods to average over.
    cancelled : callable, optional
        Polled every period; when it returns true the run is withdrawn.

    Raises
    ------
    ValueError
        If a number is out of range, or the method is not in closed form.
    Cancelled
        If ``cancelled`` returned true.
    """
    if not isinstance(method, Reference | ExactPenalty):
        raise ValueError(f"{method} has a time step: an exponent wants a closed form, Reference or ExactPenalty")
    eta = check_eta(eta, system)
    periods = whole("periods", periods, *PERIODS_RANGE, "give the excitation periods to average over")
    poincare = PoincareMap(system, eta, method, cancelled)
    y, v = coordinates(starting_checkpoint(initial, system, eta, method).state), np.full(4, 0.5)
    growth, section = np.empty(periods), np.empty((periods, 4))
    for n in range(-SETTLING, periods):
        back = poincare(y)
        length = 0.0 if back is None else float(np.linalg.norm(back.jacobian @ v))
        if not 0.0 < length < np.inf:
            return Lyapunov(np.nan, np.nan, np.nan, np.nan, displacements(section[: max(n, 0)]))
        y, v = back.state, back.jacobian @ v / length
        if n >= 0:
            growth[n], section[n] = np.log(length), y
    return _averaged(growth, displacements(section))


def _averaged(growth: np.ndarray, section: np.ndarray) -> Lyapunov:
    halves = np.array_split(growth, 2)
    means, errors = zip(*(_batch_mean(half) for half in halves), strict=True)
    drift = abs(means[1] - means[0]) / max(np.hypot(*errors), 1e-300)
    strange = irregularity(section)
    if strange < REGULAR:
        first, second = (float(bump(len(half)) @ half) for half in halves)
        exponent, error = (first + second) / 2, abs(first - second) / 2
    else:
        exponent, error = _batch_mean(growth)
    return Lyapunov(exponent, error, float(drift), strange, section)


def _batch_mean(values: np.ndarray) -> tuple[float, float]:
    """Mean and its standard error by batch means."""
    means = [batch.mean() for batch in np.array_split(values, BATCHES)]
    return float(values.mean()), float(np.std(means, ddof=1) / np.sqrt(BATCHES))
