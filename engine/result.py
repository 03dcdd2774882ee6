"""The result of a run: plain arrays with the standard names of the field."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from vibroscope.engine.kernels.status import STATUSES, Status
from vibroscope.engine.methods import Method
from vibroscope.engine.model import System

__all__ = [
    "STATUSES",
    "Cancelled",
    "Checkpoint",
    "Cost",
    "Impacts",
    "Record",
    "Response",
    "Status",
    "Trajectory",
]


class Cancelled(Exception):
    """The caller withdrew a run before it ended."""


def check_cancelled(cancelled: Callable[[], bool] | None) -> None:
    """Raise Cancelled if the caller asks for it."""
    if cancelled is not None and cancelled():
        raise Cancelled


@dataclass(frozen=True)
class Impacts:
    """Impacts of the kept periods, oldest first (reference: Newton's; penalty solutions: beginnings of contact).

    Attributes
    ----------
    time : (n,) ndarray
        τ since the start of the run.
    position : (n,) ndarray
        ξ₁; ξ₂ is less by the clearance, at a second stop more (:meth:`position2`), but for what penalty solutions that
        locate no contact leave of the gap.
    velocity_before, velocity_after : (n, 2) ndarray
        ξ₁′ and ξ₂′; for penalty solutions at the beginning and the end of the contact. With constant steps that is the
        first step which ends with an open gap, and what a method that averages over a step feels of the last force in
        the step after it is added.
    impulse : (n,) ndarray
        Impulse between the bodies; for penalty solutions the time integral of the contact force over the contact.
    closing_speed : (n,) ndarray
        −g′ before the impact, > 0; for Newmark the mean over the step in which the gap closes, or there if located.
    """

    time: np.ndarray
    position: np.ndarray
    velocity_before: np.ndarray
    velocity_after: np.ndarray
    impulse: np.ndarray
    closing_speed: np.ndarray

    def __len__(self) -> int:
        return len(self.time)

    def __repr__(self) -> str:
        speeds = f", closing at {self.closing_speed.min():.3g} to {self.closing_speed.max():.3g}" if len(self) else ""
        return f"Impacts({len(self)}{speeds})"

    def position2(self, system: System) -> np.ndarray:
        """ξ₂ where the bodies touch, (n,); at a second stop the impulse is negative."""
        first = self.position - system.clearance
        return np.where(self.impulse < 0, self.position + system.clearance2, first) if system.two_stops else first


@dataclass(frozen=True)
class Trajectory:
    """Samples of the last periods, relative to the base (ξ₂ = 0 of a wall).

    Attributes
    ----------
    time : (n,) ndarray
        τ since the start of the run.
    displacement, velocity : (2, n) ndarray
        ξ₁, ξ₂ and ξ₁′, ξ₂′.
    force : (n,) ndarray
        Contact force λ; the reference's impulses are not part of it (see Impacts).
    """

    time: np.ndarray
    displacement: np.ndarray
    velocity: np.ndarray
    force: np.ndarray

    def __repr__(self) -> str:
        times = f", tau from {self.time[0]:g} to {self.time[-1]:g}" if len(self.time) else ""
        return f"Trajectory({len(self.time)} samples{times})"


@dataclass(frozen=True)
class Cost:
    """The cost of a run: seconds in compiled code; steps (Newmark) or events and evaluations (closed form).

    Steps are those of the discrete solution, all of which an FE code takes, whether or not they were skipped here.
    """

    seconds: float
    steps: int = 0
    events: int = 0
    evaluations: int = 0


@dataclass(frozen=True)
class Checkpoint:
    """State of a solver after a whole number of periods; a run that goes on from it gives the same bits.

    It belongs to the system, η and method of its run.
    """

    system: System
    eta: float
    method: Method
    periods: int
    state: tuple[float, ...]


@dataclass(frozen=True)
class Record:
    """A request for samples of the last ``periods`` kept periods.

    Attributes
    ----------
    periods : int
        Periods to sample; the end of the last one is sampled too.
    per_period : int
        Samples per period, at most. Newmark takes every m-th step of each period, with the smallest m that keeps to it.
    steps : int, optional
        For a solution in closed form: use the sampling instants of a Newmark run with this many steps per period.
    """

    periods: int = 2
    per_period: int = 1000
    steps: int | None = None

    def stride(self, steps: int) -> int:
        """Steps from sample to sample, if there are so many in a period."""
        return -(-steps // self.per_period)

    def phases(self, steps: int) -> np.ndarray:
        """The sampled instants of a period as shares of T: every stride-th of its steps."""
        return np.arange(0, steps, self.stride(steps)) / steps


@dataclass(frozen=True)
class Response:
    """Outcome of :func:`engine.simulate`.

    Attributes
    ----------
    system, eta, method, periods, keep
        What was asked.
    status : Status
    message : str or Ending
        Why the run ended early and what to change; empty when it did not.
    section : (keep, 4) ndarray
        Poincaré section τ ≡ 0 mod T: ξ₁, ξ₁′, ξ₂, ξ₂′ at the end of each kept period, oldest first; only the periods
        that were completed.
    impacts : Impacts
    contacts : (m, 2) ndarray
        Beginning and end of each contact that overlaps the kept periods: permanent contacts for the reference, all
        contacts for the penalty solutions. A contact still open at the end of the run ends there.
    trajectory : Trajectory or None
    cost : Cost
    checkpoint : Checkpoint
        The solver's state at the beginning of the kept periods.
    steps_without_solution, steps_with_two : int
        Of :class:`engine.TimeStepping` with status "end": the steps since the start in which neither contact status
        agreed with its own end, or both did.
    """

    system: System
    eta: float
    method: Method
    periods: int
    keep: int
    status: Status
    message: str
    section: np.ndarray
    impacts: Impacts
    contacts: np.ndarray
    trajectory: Trajectory | None
    cost: Cost
    checkpoint: Checkpoint
    steps_without_solution: int = 0
    steps_with_two: int = 0

    def __repr__(self) -> str:
        what = f"{self.method.name} at eta = {self.eta:g}, {self.keep} of {self.periods} periods kept"
        samples = f", {len(self.trajectory.time)} samples" if self.trajectory else ""
        how = str(self.status) if self.ok else self.ending
        return f"Response({what}: {how}; {len(self.impacts)} impacts, {len(self.contacts)} contacts{samples})"

    def to_xarray(self):
        """The arrays as an `xarray.Dataset`: see :func:`.datasets.response_dataset`."""
        from vibroscope.engine.datasets import response_dataset

        return response_dataset(self)

    def _repr_html_(self) -> str:
        return self.to_xarray()._repr_html_()

    @property
    def ok(self) -> bool:
        """Whether the run reached its end."""
        return self.status is Status.OK

    @property
    def ending(self) -> str:
        """How a run ended that did not reach its end, and why."""
        return f"the run ended as {self.status}: " + self.message  # which may be a statement

    @property
    def period(self) -> float:
        """T = 2π/η."""
        return 2 * np.pi / self.eta

    @property
    def window(self) -> tuple[float, float]:
        """τ at the beginning and the end of the kept periods."""
        end = self.checkpoint.periods + self.keep
        return self.checkpoint.periods * self.period, end * self.period
