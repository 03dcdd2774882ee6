"""The terms of an energy balance: where the energy of each period comes from, and where it goes."""

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class EnergyBalance:
    """Energy over each kept period, in units of m₁ω₁² times the base amplitude squared; all (n,) ndarrays.

    Attributes
    ----------
    gain : ndarray
        Increase of the mechanical energy.
    work : ndarray
        Work of the excitation on both masses, relative to the base.
    dampers : ndarray
        Energy dissipated by the dampers of the pendulums; in permanent contact, by that of the joined pendulums.
    contact : ndarray
        Energy dissipated by the contact damper (penalty).
    impacts : ndarray
        Energy dissipated by impacts (reference).
    stored : float
        Largest mechanical energy, of those at events and at the quarters of each period.
    """

    gain: np.ndarray
    work: np.ndarray
    dampers: np.ndarray
    contact: np.ndarray
    impacts: np.ndarray
    stored: float

    @property
    def lost(self) -> np.ndarray:
        """Energy dissipated by dampers, contact and impacts."""
        return self.dampers + self.contact + self.impacts

    @property
    def residual(self) -> np.ndarray:
        """Gain + losses − work: 0 but for errors of the solution; of steps, the energy that they create."""
        return self.gain + self.lost - self.work

    @property
    def size(self) -> float:
        """Energy to compare a residual with: the largest stored one, plus the work or the losses of a period."""
        return float(self.stored + max(np.abs(self.work).max(initial=0.0), self.lost.max(initial=0.0)))
