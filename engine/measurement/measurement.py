"""A measurement: displacements of one body or both over time, and perhaps a contact sensor."""

from dataclasses import dataclass, replace

import numpy as np
from vibroscope.engine.arguments import one_of, set_fields, shown
from vibroscope.engine.model import System

FRAMES = ("absolute", "relative")


@dataclass(frozen=True)
class Measurement:
    """Displacements over time, in units of the model.

    Attributes
    ----------
    time : (n,) ndarray
        τ since the first sample, increasing; the samples need not be equally spaced.
    displacement : (2, n) or (1, n) ndarray
        Of body 1 and 2, or of body 1 alone, in base amplitudes.
    contact : (n,) bool ndarray or None
        Whether the pendulums touch, if there was a contact sensor.
    frame : {"absolute", "relative"}
        As seen by a fixed sensor, ξ + cos ητ, or relative to the base, ξ.
    mean_known : bool
        False if the displacements follow from accelerations: then differences are taken without their means.
    eta : float or None
        Excitation frequency that the numbers of the file were read with, where they depend on it.
    left_out : tuple of str
        What the file holds beside this, such as columns of other names.
    physical : bool
        Whether the file gives units; else its numbers are those of the model.

    Raises
    ------
    ValueError
        If an array does not hold finite numbers of this shape, or the time decreases.
    """

    time: np.ndarray
    displacement: np.ndarray
    contact: np.ndarray | None
    frame: str
    mean_known: bool = True
    eta: float | None = None
    left_out: tuple[str, ...] = ()
    physical: bool = True

    def __post_init__(self):
        time = _numbers("time", self.time, 1)
        checked = {"time": time, "displacement": _numbers("displacement", self.displacement, 2, len(time))}
        if self.contact is not None:
            checked["contact"] = _numbers("contact", self.contact, 1, len(time)) > 0
        one_of("frame", self.frame, FRAMES)
        if (np.diff(time) < 0).any():
            raise ValueError("time decreases: give the samples in the order of their time")
        set_fields(self, **checked)

    def __len__(self) -> int:
        return len(self.time)

    def __repr__(self) -> str:
        sensor = "" if self.contact is None else ", with a contact sensor"
        return f"Measurement({len(self)} samples over tau = {self.span:g}, {self.frame}{sensor})"

    @property
    def span(self) -> float:
        """τ from the first to the last sample."""
        return float(self.time[-1])

    def of(self, system: System) -> "Measurement":
        """The measurement of a system's bodies: a wall does not move, whatever a second column holds."""
        return replace(self, displacement=self.displacement[:1]) if system.wall else self

    def residual(self, displacement: np.ndarray) -> np.ndarray:
        """Measured less computed displacements, (k, n), of the bodies that were measured; without unknown means.

        Parameters
        ----------
        displacement : (2, n) ndarray
            Of both bodies, at the instants of the samples.
        """
        difference = self.displacement - displacement[: len(self.displacement)]
        return difference if self.mean_known else difference - difference.mean(axis=1, keepdims=True)

    def thinned(self, count: int) -> "Measurement":
        """Return at most ``count`` of the samples, evenly chosen, without the contact sensor."""
        chosen = np.unique(np.linspace(0, len(self) - 1, min(count, len(self))).astype(int))
        return replace(self, time=self.time[chosen], displacement=self.displacement[:, chosen], contact=None)

    def velocity(self, span: float) -> np.ndarray:
        """Return the velocities of the measured bodies, (2, n) or (1, n), which no sensor of displacements shows.

        Each is the slope between the mean of the samples within ``span``/2 before and that of those after, the sample
        itself and at least its neighbours included. Jumps at impacts are smoothed over that time.
        """
        n, own = len(self), np.arange(len(self))
        first = np.clip(np.searchsorted(self.time, self.time - span / 2), 0, np.maximum(own - 1, 0))
        last = np.clip(np.searchsorted(self.time, self.time + span / 2, "right"), np.minimum(own + 2, n), n)
        data = np.vstack([self.time, self.displacement])
        total = np.concatenate([np.zeros((len(data), 1)), np.cumsum(data, axis=1)], axis=1)
        before = (total[:, own + 1] - total[:, first]) / (own + 1 - first)
        after = (total[:, last] - total[:, own]) / (last - own)
        change = after - before
        return change[1:] / change[0]


def _numbers(name: str, values: object, dimensions: int, samples: int | None = None) -> np.ndarray:
    """Finite numbers as an array, (samples,), or (2, samples) or (1, samples); else a ValueError."""
    try:
        found = np.asarray(values, dtype=float)
    except (TypeError, ValueError, OverflowError):
        raise ValueError(f"{name} = {shown(values)} are not numbers: give one for each sample") from None
    count = found.shape[-1] if samples is None and found.ndim else samples
    wanted = [(count,)] if dimensions == 1 else [(2, count), (1, count)]
    if not count or found.shape not in wanted:
        sizes = "(n,), n > 0" if samples is None else " or ".join(map(str, wanted))
        raise ValueError(f"{name} has the shape {found.shape}: give {sizes}")
    if not np.isfinite(found).all():
        raise ValueError(f"{name} holds numbers that are not finite: leave these samples out")
    return found
