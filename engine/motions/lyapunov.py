"""The largest Lyapunov exponent from the exact Jacobian of the Poincaré map.

A small disturbance v of a motion becomes DP v after each excitation period. Its growth ln(|DP v| / |v|), with v scaled
back to length 1 every time, averages to the largest Lyapunov exponent Λ. DP is exact and includes impacts and contact
changes (by the saltation matrices of :mod:`..kernels.event_driven.saltation`), so that neither a second run nor a
finite disturbance is needed.

The uncertainty of the average depends on the motion:

- *Irregular* motion: the growth is random with a memory of some periods. The standard error follows from batch means.
- *Regular* motion (periodic or quasi-periodic): the growth is a smooth function along the motion, and its average with
  smooth weights converges faster than any power of 1/n. The error is half the difference between the averages over the
  two halves of the run.

The section decides which of the two it is (:func:`.section.irregularity`). Λ belongs to the motion while it was
followed only: a chaotic transient may last longer than any run.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from vibroscope.engine.arguments import Poll, whole
from vibroscope.engine.cells import Cells
from vibroscope.engine.drivers.batch import follow
from vibroscope.engine.drivers.threads import thread_count
from vibroscope.engine.methods import ExactPenalty, Reference
from vibroscope.engine.model import System, check_eta
from vibroscope.engine.motions.poincare_map import PoincareMap
from vibroscope.engine.motions.section import batch_means, irregularity, smooth_weights, standard_error
from vibroscope.engine.motions.steady import REST
from vibroscope.engine.motions.tolerances import EXPONENT_DRIFT, REGULAR
from vibroscope.engine.result import Cancelled
from vibroscope.engine.simulate import starting_checkpoint

EXPONENT_BATCHES = 32
SETTLING = 64  # periods in which a disturbance turns into the direction of fastest growth
PERIODS_RANGE = (EXPONENT_BATCHES * 8, 10_000_000)


@dataclass(frozen=True)
class Lyapunov:
    """Outcome of :func:`lyapunov`; all numbers are nan if the motion could not be followed.

    Attributes
    ----------
    exponent : float
        Λ per excitation period; −∞ where nothing is left of a disturbance, as of a body that sticks to a wall.
    error : float
        Standard error of Λ.
    drift : float
        Difference of the averages over the two halves of the run, in units of its own standard error: about 1 unless
        the motion changes during the run.
    irregularity : float
        Of the section (:func:`.section.irregularity`).
    section : (n, 4) ndarray
        ξ₁, ξ₁′, ξ₂, ξ₂′ at the end of each period.
    growth : float
        Where nothing is left of a disturbance: ln of the most that it had grown by until then; else nan.
    """

    exponent: float
    error: float
    drift: float
    irregularity: float
    section: np.ndarray
    growth: float = np.nan

    @property
    def regular(self) -> bool:
        """Whether the section is that of a periodic or quasi-periodic motion."""
        return self.irregularity < REGULAR

    @property
    def sign(self) -> int:
        """Sign of the exponent, 0 unless it exceeds 3 standard errors and a growth by e over the whole run."""
        least = max(3 * self.error, 1 / max(len(self.section), 1))
        return int(self.exponent > least) - int(self.exponent < -least)

    @property
    def is_quasi_periodic(self) -> bool:
        """Whether a motion that does not repeat itself is regular, with neighbours that stay near it."""
        return self.regular and self.sign == 0

    @property
    def is_chaotic(self) -> bool:
        """Whether the motion is irregular and its neighbours separate, in both halves of the run."""
        return not self.regular and self.sign == 1 and self.drift < EXPONENT_DRIFT


def lyapunov(
    system: System,
    eta: float,
    method: Reference | ExactPenalty,
    *,
    initial: Sequence[float] | None = REST,
    periods: int = 8192,
    cancelled: Poll | None = None,
) -> Lyapunov:
    """Compute the largest Lyapunov exponent of the motion that begins at ``initial``.

    Parameters
    ----------
    system : System
    eta : float
        Excitation frequency η = Ω/ω₁.
    method : Reference or ExactPenalty
        A closed-form solver.
    initial : (4,) sequence
        ξ₁, ξ₁′, ξ₂, ξ₂′ at τ ≡ 0 mod T after the transient (another 64 periods are run and not counted).
    periods : int
        Excitation periods to average over.
    cancelled : callable, optional
        Polled many times a second; when it returns true the run is cancelled.

    Raises
    ------
    ValueError
        If a number is out of range, or the method has a time step.
    Cancelled
        If ``cancelled`` returned true.

    Examples
    --------
    >>> from vibroscope.engine import Reference, System, lyapunov
    >>> found = lyapunov(System(), 1.7, Reference(), periods=400)
    >>> found.is_chaotic, bool(found.exponent > 5 * found.error)
    (True, True)
    """
    if method.has_step:
        raise ValueError(f"{method} has a time step: an exponent needs a closed form, Reference or ExactPenalty")
    eta = check_eta(eta)
    periods = whole("periods", periods, *PERIODS_RANGE, "give the excitation periods to average over")
    start, found = starting_checkpoint(initial, system, eta, method).state, []
    alone, how = Cells(system, [eta], method), {"threads": 1, "cancelled": cancelled}
    follow_cells(alone, np.array([0]), np.array([start]), periods, lambda _, one: found.append(one), **how)
    return found[0]


def follow_cells(
    cells: Cells,
    places: np.ndarray,
    starts: np.ndarray,
    periods: int,
    judge: Callable[[int, Lyapunov], None],
    *,
    threads: int | None = None,
    cancelled: Poll | None = None,
) -> None:
    """Compute the largest Lyapunov exponent of some cells of a method without a time step, each from its own start.

    Parameters
    ----------
    cells : Cells
    places : (m,) ndarray of int
        The cells, by their index.
    starts : (m, 4) ndarray
        ξ₁, ξ₁′, ξ₂, ξ₂′ of each at τ ≡ 0 mod T.
    periods : int
        As of :func:`engine.lyapunov`, which is this for one cell.
    judge : callable
        ``judge(i, followed)`` takes the outcome of cell i as soon as it is known, in any thread and order.
    threads, cancelled
        As of :func:`engine.run_cells`.

    Raises
    ------
    Cancelled
        If ``cancelled`` returned true.
    """

    def by_itself(k: int, signals: np.ndarray) -> bool:
        i = places[k]
        poincare = PoincareMap(cells.system_of(i), cells.eta[i], cells.method_of(i), lambda: signals[0] != 0)
        y, v = poincare.coordinates(starts[k]), np.full(4, 0.5)
        growth, section = np.full(periods, np.nan), np.empty((periods, 4))
        try:
            settled, _ = poincare.follow(y, v, SETTLING)
            if not np.isnan(settled[-1]):
                growth[:], states = poincare.follow(y, v, periods)
                section[:] = poincare.displacements(states)
        except Cancelled:
            return False
        found(k, growth, section)
        return True

    def found(k: int, growth: np.ndarray, section: np.ndarray) -> None:
        judge(int(places[k]), outcome_of(growth, section))

    how = {"threads": thread_count(threads), "cancelled": cancelled}
    starts = np.ascontiguousarray(starts)  # a view would be another type to the compiler
    follow(cells.method, cells.parameters()[places], starts, periods, SETTLING, found, by_itself, **how)


def outcome_of(growth: np.ndarray, section: np.ndarray) -> Lyapunov:
    """The exponent from the growth in each period, (n,), and the section, (n, 4); nan if the growth breaks off."""
    lost = np.flatnonzero(~np.isfinite(growth))
    if not len(lost):
        return average_growth(growth, section.copy())
    rows = section[: lost[0]].copy()
    if np.isnan(growth[lost[0]]):
        return Lyapunov(np.nan, np.nan, np.nan, np.nan, rows)
    most = float(np.cumsum(growth[: lost[0]]).max(initial=0.0))
    return Lyapunov(-np.inf, 0.0, 0.0, 0.0, section[: lost[0] + 1].copy(), most)


def average_growth(growth: np.ndarray, section: np.ndarray) -> Lyapunov:
    """Average the growth of a disturbance in each period, (n,), along a motion with this section, (n, 4)."""
    halves = np.array_split(growth, 2)
    means, errors = zip(*(_mean_and_error(half) for half in halves), strict=True)
    drift = abs(means[1] - means[0]) / max(np.hypot(*errors), 1e-300)
    measure = irregularity(section)
    if measure < REGULAR:
        first, second = (float(smooth_weights(len(half)) @ half) for half in halves)
        exponent, error = (first + second) / 2, abs(first - second) / 2
    else:
        exponent, error = _mean_and_error(growth)
    return Lyapunov(exponent, error, float(drift), measure, section)


def _mean_and_error(values: np.ndarray) -> tuple[float, float]:
    return float(values.mean()), float(standard_error(batch_means(values, EXPONENT_BATCHES)))
