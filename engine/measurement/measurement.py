"""A measurement: displacements of both pendulums over time, and perhaps a contact sensor."""

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Measurement:
    """Displacements over time, in units of the model.

    Attributes
    ----------
    time : (n,) ndarray
        τ since the first sample, increasing; the samples need not be equally spaced.
    displacement : (2, n) ndarray
        Of pendulum 1 and 2, in base amplitudes.
    contact : (n,) bool ndarray or None
        Whether the pendulums touch, if there was a contact sensor.
    frame : {"absolute", "relative"}
        As seen by a fixed sensor, ξ + cos ητ, or relative to the base, ξ.
    """

    time: np.ndarray
    displacement: np.ndarray
    contact: np.ndarray | None
    frame: str

    def __len__(self) -> int:
        return len(self.time)

    @property
    def span(self) -> float:
        """τ from the first to the last sample."""
        return float(self.time[-1])

    def thinned(self, count: int) -> "Measurement":
        """Return at most ``count`` of the samples, evenly chosen, without the contact sensor."""
        chosen = np.unique(np.linspace(0, len(self) - 1, min(count, len(self))).astype(int))
        return Measurement(self.time[chosen], self.displacement[:, chosen], None, self.frame)

    def velocity(self, span: float) -> np.ndarray:
        """Return the velocities of both pendulums, (2, n), which a sensor of displacements does not show.

        Each is the slope between the mean of the samples within ``span``/2 before and that of those after, the sample
        itself and at least its neighbours included. Jumps at impacts are smoothed over that time.
        """
        n, own = len(self), np.arange(len(self))
        first = np.clip(np.searchsorted(self.time, self.time - span / 2), 0, np.maximum(own - 1, 0))
        last = np.clip(np.searchsorted(self.time, self.time + span / 2, "right"), np.minimum(own + 2, n), n)
        data = np.vstack([self.time, self.displacement])
        total = np.concatenate([np.zeros((3, 1)), np.cumsum(data, axis=1)], axis=1)
        before = (total[:, own + 1] - total[:, first]) / (own + 1 - first)
        after = (total[:, last] - total[:, own]) / (last - own)
        change = after - before
        return change[1:] / change[0]
