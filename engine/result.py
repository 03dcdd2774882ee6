"""The result of a run: plain arrays with the standard names of the field.

Results as labelled arrays (xarray), with meaning and unit of each variable as its attributes.
"""

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from vibroscope.engine.arguments import Poll
from vibroscope.engine.kernels.status import STATUSES as STATUSES
from vibroscope.engine.kernels.status import Status
from vibroscope.engine.methods import Method
from vibroscope.engine.model import COORDINATES, System

if TYPE_CHECKING:
    import xarray as xr
    from vibroscope.engine.divergence.compare import Comparison


BODIES = (1, 2)
LENGTH, SPEED, TIME = "unit of length", "unit of length times omega1", "1/omega1"


def response_dataset(response: "Response") -> "xr.Dataset":
    """The arrays of a run.

    Returns
    -------
    xarray.Dataset
        ``section`` (period, coordinate), the impacts (impact; body), ``contact`` (contact, edge), and where samples
        were asked for ``displacement``, ``velocity`` (body, time) and ``force`` (time). Attributes: what was asked,
        and how the run ended.
    """
    import xarray as xr

    impacts, first = response.impacts, response.checkpoint.periods + 1
    found = xr.Dataset(
        {
            "section": labelled(("period", "coordinate"), response.section, "Poincaré section", f"{LENGTH}, {SPEED}"),
            "impact_time": labelled("impact", impacts.time, "instant of the impact", TIME),
            "impact_position": labelled("impact", impacts.position, "displacement of body 1", LENGTH),
            "velocity_before": labelled(("impact", "body"), impacts.velocity_before, "velocities before", SPEED),
            "velocity_after": labelled(("impact", "body"), impacts.velocity_after, "velocities after", SPEED),
            "impulse": labelled("impact", impacts.impulse, "impulse between the bodies", f"m1 times {SPEED}"),
            "closing_speed": labelled("impact", impacts.closing_speed, "closing speed", SPEED),
            "contact": labelled(("contact", "edge"), response.contacts, "beginning and end of each contact", TIME),
        },
        {
            "period": range(first, first + len(response.section)),
            "coordinate": list(COORDINATES),
            "body": list(BODIES),
            "edge": ["begin", "end"],
        },
        {
            "system": str(response.system),
            "method": str(response.method),
            "eta": response.eta,
            "status": str(response.status),
            "message": response.message,
        },
    )
    path = response.trajectory
    if path is None:
        return found
    return found.assign_coords(time=path.time).assign(
        displacement=labelled(("body", "time"), path.displacement, "displacements relative to the base", LENGTH),
        velocity=labelled(("body", "time"), path.velocity, "velocities relative to the base", SPEED),
        force=labelled("time", path.force, "contact force", "k1 times unit of length"),
    )


def comparison_dataset(comparison: "Comparison") -> "xr.Dataset":
    """The four solutions of a comparison, their difference and its parts.

    Returns
    -------
    xarray.Dataset
        ``solution`` (run, coordinate, time), ``total`` and the parts (coordinate, time). Attributes: the rms of each,
        relative to the reference.

    Raises
    ------
    ValueError
        If a run ended early, so that there are no series.
    """
    import xarray as xr

    series = comparison.parts
    if series is None:
        raise ValueError("a run ended early, so that there are no series: see the runs' messages")
    names = ("total", *comparison.part_names)
    variables = {
        name: labelled(("coordinate", "time"), getattr(series, name), "", f"{LENGTH}, {SPEED}") for name in names
    }
    return xr.Dataset(
        {"solution": labelled(("run", "coordinate", "time"), list(series.runs), "", f"{LENGTH}, {SPEED}")} | variables,
        {"time": series.time, "run": list(series.runs._fields), "coordinate": ["xi1", "xi2", "v1", "v2"]},
        {name: getattr(comparison, name) for name in names},
    )


def labelled(dims, values, meaning: str, unit: str) -> tuple:
    """A variable with its meaning and its unit."""
    return dims, values, {"units": unit} | ({"long_name": meaning} if meaning else {})


class Cancelled(Exception):
    """The caller withdrew a run before it ended."""


def check_cancelled(cancelled: Poll | None) -> None:
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
        """The arrays as an `xarray.Dataset`: see :func:`response_dataset`."""
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
