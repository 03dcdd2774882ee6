"""What a setting does to the contacts: how the bodies rebound, and the peak of the contact force.

A small difference of displacements does not show that a contact is solved. With few steps in a contact the force is too
large, and the bodies may part faster than they met, while the motion between the contacts compensates for it. So a
setting keeps two more tolerances: the restitution that its contacts deliver is near that of the system, and its peak
force near that of the same K, D and law without a time step. The peak force itself belongs to the contact model, not to
the system: it grows with K.
"""

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from vibroscope.engine.arguments import Poll, require, set_fields
from vibroscope.engine.contact import effective_restitution
from vibroscope.engine.divergence.encounters import delivered_restitution, mean_closing_speed, short_contacts
from vibroscope.engine.divergence.error import Target
from vibroscope.engine.divergence.grid import simulate_samples
from vibroscope.engine.motions.description import peak_force
from vibroscope.engine.result import Record, Response

DISPLACEMENT_RANGE = (1e-6, 1.0)
RESTITUTION_RANGE, FORCE_RANGE = (1e-3, 1.0), (1e-3, 10.0)
TRIAL_SAMPLES_IN_CONTACT = 30  # samples in the shortest contact of a run that has no steps of its own
# Samples of a run, to choose by and to verify: at most, but for those of one cycle.
PEAK_SAMPLES, MORE_PEAK_SAMPLES = 4_000, 40_000
FEWEST_PEAK_SAMPLES = 200  # samples in a period


@dataclass(frozen=True)
class Tolerances:
    """How far a setting may be off. None: that tolerance is switched off.

    Attributes
    ----------
    displacement : float
        Rms difference of the displacements from the reference, relative to it.
    restitution : float or None
        Difference of the restitution that contacts deliver from that of the system. Whatever it is, and where it is
        switched off, too, contacts may not gain energy on the whole, unless the system's restitution is 1.
    force : float or None
        Difference of the peak force from that without a time step, relative to it.

    Raises
    ------
    ValueError
        If a number is out of range: the text names it, the range and what to do.
    """

    displacement: float = 0.05
    restitution: float | None = 0.1
    force: float | None = 0.2

    def __post_init__(self):
        advice = "give the relative rms error to keep to"
        checked = {"displacement": require("tolerance", self.displacement, *DISPLACEMENT_RANGE, advice)}
        if self.restitution is not None:
            advice = "give how far the restitution may be off, or switch it off"
            checked["restitution"] = require("restitution_tolerance", self.restitution, *RESTITUTION_RANGE, advice)
        if self.force is not None:
            advice = "give how far the peak force may be off, relative to it, or switch it off"
            checked["force"] = require("force_tolerance", self.force, *FORCE_RANGE, advice)
        set_fields(self, **checked)


class Contacts(NamedTuple):
    """What the contacts of a run do.

    Attributes
    ----------
    restitution : float
        That they deliver (:func:`..divergence.encounters.delivered_restitution`). If there are no short ones, what a
        contact alone would deliver at the mean closing speed of the reference; nan if that has no impacts.
    wanted : float
        The system's.
    peak_force, without_step : float
        Largest contact force, and that of the same K, D and law without a time step; nan if not known.
    steps : float
        In the median of the short contacts; nan if there are none.
    unsolved : int
        Steps of the run in which no contact status agrees with its own end.
    """

    restitution: float
    wanted: float
    peak_force: float
    without_step: float
    steps: float
    unsolved: int = 0

    @property
    def force_error(self) -> float:
        """How far the peak force is off, relative to that without a time step, with its sign; nan if not known."""
        return self.peak_force / self.without_step - 1.0 if self.without_step > 0 else math.nan

    def excess(self, tolerances: Tolerances) -> float:
        """Return the larger of both deviations in units of its tolerance: above 1, one of them is exceeded."""
        found = self.restitution if self.restitution > 1.0 > self.wanted else 0.0
        if tolerances.restitution is not None and not math.isnan(self.restitution):
            found = max(found, abs(self.restitution - self.wanted) / tolerances.restitution)
        if tolerances.force is not None and not math.isnan(self.force_error):
            found = max(found, abs(self.force_error) / tolerances.force)
        return found


def contacts_of(
    run: Response, without_step: float, target: Target, cancelled: Poll | None, samples: int = PEAK_SAMPLES
) -> Contacts:
    """Return what the contacts of the kept periods of a run do.

    Parameters
    ----------
    run : Response
        Of a method with a time step.
    without_step : float
        Peak force without a time step.
    target : Target
        With the reference, whose impacts say how fast the bodies meet where the run has no short contact.
    """
    durations = short_contacts(run)[0]
    steps = float(np.median(durations)) * run.method.steps / run.period if len(durations) else math.nan
    peak = peak_of(run, target.period, cancelled, samples)
    restitution, speed = delivered_restitution(run), mean_closing_speed(target.reference)
    if math.isnan(restitution) and speed > 0:
        restitution = float(effective_restitution(run.system, run.method, speed))
    return Contacts(restitution, run.system.restitution, peak, without_step, steps, run.steps_without_solution)


def peak_of(run: Response, period: int, cancelled: Poll | None, samples: int = PEAK_SAMPLES) -> float:
    """Return the largest contact force in as many kept periods as the samples allow, and at least in one cycle."""
    steps = run.method.grid_steps
    per_period = steps
    if not steps:
        shortest = np.diff(run.contacts, axis=1).min(initial=run.period)
        per_period = int(np.clip(TRIAL_SAMPLES_IN_CONTACT * run.period / shortest, FEWEST_PEAK_SAMPLES, samples))
    periods = min(run.keep, max(period, samples // per_period))
    return peak_force(simulate_samples(run, Record(periods, per_period, steps or None), cancelled))
