"""What an energy balance says: where the energy of each period comes from, and where it goes."""

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class EnergyBalance:
    """Energy over each kept period, in units of m₁ω₁² times the base amplitude squared; all (n,) ndarrays.

    Attributes
    ----------
    gain : ndarray
        What mechanical energy grows by.
    work : ndarray
        Work of the excitation on both masses, relative to the base.
    dampers : ndarray
        What the dampers of the pendulums take; while they are joined, that of the joint.
    contact : ndarray
        What the contact damper takes (penalty).
    impacts : ndarray
        What impacts take (reference).
    stored : float
        Largest mechanical energy met: at events, and at the quarters of each period.
    """

    gain: np.ndarray
    work: np.ndarray
    dampers: np.ndarray
    contact: np.ndarray
    impacts: np.ndarray
    stored: float

    @property
    def lost(self) -> np.ndarray:
        """What dampers, contact and impacts take."""
        return self.dampers + self.contact + self.impacts

    @property
    def residual(self) -> np.ndarray:
        """Gain + losses − work; 0 but for errors of the solution."""
        return self.gain + self.lost - self.work

    @property
    def size(self) -> float:
        """What a residual compares with: the energy stored, or put in or taken within a period."""
        return float(self.stored + max(np.abs(self.work).max(initial=0.0), self.lost.max(initial=0.0)))
