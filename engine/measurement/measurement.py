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
