"""What analysts read off a sampled run: accelerations, peaks, spectra, transmissibility."""

from typing import NamedTuple

import numpy as np
from vibroscope.engine.contact import spring_duration
from vibroscope.engine.motions.description import chatter_before, peak_force
from vibroscope.engine.motions.tolerances import SHORT_CONTACT
from vibroscope.engine.result import Response, Trajectory

# The numbers of `peaks`, each with its quantity (`units.QUANTITIES`), in the order of tables.
PEAKS = {
    "displacement1": "displacement",
    "displacement2": "displacement",
    "velocity1": "velocity",
    "velocity2": "velocity",
    "acceleration1": "acceleration",
    "acceleration2": "acceleration",
    "penetration": "displacement",
    "contact_force": "force",
    "impulse": "impulse",
    "closing_speed": "velocity",
    "contact_time": "time",
}


class Spectrum(NamedTuple):
    """Amplitudes of a sampled run over orders of the excitation frequency.

    ``order`` (m,): frequency as a multiple of η, 0 the mean; ``displacement`` (2, m) and ``acceleration`` (2, m) of
    both bodies, base motion included; ``force`` (m,) of the contact, impulses of impacts included.
    """

    order: np.ndarray
    displacement: np.ndarray
    acceleration: np.ndarray
    force: np.ndarray


def absolute_accelerations(response: Response) -> np.ndarray:
    """ξ₁″ + b″ and ξ₂″ + b″ of the samples, (2, n), from the equations of motion (1), (2), and (4) of joined bodies.

    The second row is b″ beside a wall. The infinite acceleration within an impact of the reference lies between
    samples.

    Raises
    ------
    ValueError
        If the run has no samples.

    Examples
    --------
    >>> from vibroscope.engine import ExactPenalty, Record, System, absolute_accelerations, simulate
    >>> run = simulate(System(), 2.76, ExactPenalty(12000, 18), record=Record(periods=2, per_period=400))
    >>> absolute_accelerations(run).shape
    (2, 801)
    """
    sampled, c, eta = _sampled(response), response.system, response.eta
    (x1, x2), (v1, v2), force = sampled.displacement, sampled.velocity, sampled.force
    drive = c.excitation
    base, load1, load2 = (drive.load_at(name, eta, sampled.time) for name in ("base", "force1", "force2"))
    found = np.array([load1 + drive.constant1 - 2 * c.d1 * v1 - c.spring1 * x1 - force, base])
    if not c.wall:
        found[1] = (load2 + drive.constant2 + force) / c.mass_ratio - 2 * c.damper2 * v2 - c.kappa**2 * x2
    if response.method.rigid:
        joined = _within(sampled.time, response.contacts)
        if c.wall:
            found[0, joined] = base[joined]
        else:
            ratio = 1 + c.mass_ratio
            push = (load1 + load2 + drive.constant1 + drive.constant2) / ratio
            second = c.two_stops & (sampled.force < 0)  # of the stop at which they are joined
            clearance = np.where(second, -c.clearance2 if c.two_stops else 0.0, c.clearance)
            rest = c.stiffness_share * clearance  # of both springs, from where that of body 1 is relaxed
            damper = 2 * c.joint_damper(response.method.joint_damping) * v1
            found[:, joined] = (push - damper - c.kappa3**2 * (x1 - rest))[joined]
    return found


def peaks(response: Response) -> dict[str, float]:
    """Largest values of a sampled run, by the names of :data:`PEAKS`.

    Displacements and velocities are relative to the base, accelerations absolute; penetration, contact force, impulse
    of one contact, closing speed and duration of one contact, all of what lies within the samples. For the impulse a
    lasting contact and the chatter that leads into it count as one contact, whose impulse does not depend on how
    many bounces a solution makes. The force of the reference is that of its permanent contacts. What has no finite
    value (acceleration and force of an impact without duration) or is not resolved by the samples is nan.

    Raises
    ------
    ValueError
        If the run has no samples.

    Examples
    --------
    >>> from vibroscope.engine import ExactPenalty, Record, System, peaks, simulate
    >>> found = peaks(simulate(System(), 2.76, ExactPenalty(12000, 18), record=Record(2, 4000)))
    >>> print(f"{found['contact_force']:.0f}, {found['contact_time']:.3f}")
    725, 0.020
    """
    sampled, c = _sampled(response), response.system
    begin, end = sampled.time[[0, -1]]
    impacts, contacts = response.impacts, response.contacts[response.contacts[:, 1] > begin]
    met = impacts.time > begin
    struck = response.method.rigid and met.any()
    force = np.nan if struck and not len(contacts) else peak_force(response)
    acceleration = np.abs(absolute_accelerations(response)).max(axis=1)
    if struck or np.isnan(force):
        acceleration = np.where([True, not c.wall], np.nan, acceleration)
    values = (
        *np.abs(sampled.displacement).max(axis=1),
        *np.abs(sampled.velocity).max(axis=1),
        *acceleration,
        max(0.0, -c.nearest_gap(*sampled.displacement).min()),
        force,
        _largest_impulse(response, contacts),
        impacts.closing_speed[met].max(initial=0.0),
        np.diff(np.clip(contacts, begin, end), axis=1).max(initial=0.0),
    )
    return dict(zip(PEAKS, map(float, values), strict=True))


def _largest_impulse(response: Response, contacts: np.ndarray) -> float:
    """The largest impulse of one contact of the samples, which ``contacts``, (m, 2), overlap.

    A contact that lasts longer than SHORT_CONTACT durations of a contact alone, and each permanent contact of the
    reference, is one with the chatter that leads into it at the same stop
    (:func:`.motions.description.chatter_before`).
    """
    impacts, sampled = response.impacts, response.trajectory
    size = np.where(impacts.time > sampled.time[0], impacts.impulse, 0.0)
    last = np.searchsorted(impacts.time, contacts[:, 0], side="right") - 1
    recorded = np.isin(contacts[:, 0], impacts.time) & (not response.method.rigid)  # with its whole impulse
    lasting = np.ones(len(contacts), bool)
    if recorded.any():
        speeds = np.maximum(impacts.closing_speed[last[recorded]], np.finfo(float).tiny)
        alone = spring_duration(response.system.mass_share, response.method, speeds)
        lasting[recorded] = np.diff(contacts[recorded], axis=1)[:, 0] > SHORT_CONTACT * alone
    found = np.abs(size).max(initial=0.0)
    for contact, at, whole in zip(contacts[lasting], last[lasting].tolist(), recorded[lasting], strict=True):
        led = size[max(chatter_before(impacts, at, contact[1] - contact[0]), 0) : at + 1]
        other = np.flatnonzero(led * led[-1:] < 0.0)  # at the other stop
        led = led[other[-1] + 1 :] if len(other) else led
        found = max(found, abs(led.sum() + (0.0 if whole else _impulse_within(sampled, contact))))
    return float(found)


def _impulse_within(sampled: Trajectory, contact: np.ndarray) -> float:
    """∫λ dτ of the samples over a contact, at whose ends the force may jump."""
    begin, end = np.clip(contact, *sampled.time[[0, -1]])
    inside = (sampled.time >= begin) & (sampled.time < end)
    if not inside.any():
        return 0.0
    force, time = sampled.force[inside], sampled.time[inside]
    return float(np.trapezoid([force[0], *force, force[-1]], [begin, *time, end]))


def spectrum(response: Response, highest: float = 20.0) -> Spectrum:
    """Amplitudes over orders of the excitation, up to order ``highest``, from the sampled periods.

    A motion that repeats in them has lines; another one has a continuous spectrum that they resolve to 1/periods.

    Raises
    ------
    ValueError
        If the run has no samples, or too few in a period for that order.

    Examples
    --------
    >>> from vibroscope.engine import ExactPenalty, Record, System, simulate, spectrum
    >>> found = spectrum(simulate(System(), 2.76, ExactPenalty(12000, 18), record=Record(2, 400)), highest=3)
    >>> found.order.tolist()
    [0.0, 0.5, 1.0, 1.5, 2.0, 2.5, 3.0]
    """
    sampled, eta = _sampled(response), response.eta
    time, n = sampled.time[:-1], len(sampled.time) - 1
    periods = round((sampled.time[-1] - sampled.time[0]) / response.period)
    lines = int(highest * periods) + 1
    if lines > n // 2:
        raise ValueError(
            f"highest = {highest:g} needs more than {2 * highest:g} samples a period, and there are {n / periods:g}: "
            "record more, or ask for lower orders"
        )
    order = np.arange(lines) / periods
    base = response.system.excitation.base_motion(eta, time)[0]
    moved = np.fft.rfft(sampled.displacement[:, :-1] + base)[:, :lines] / n
    force = np.fft.rfft(sampled.force[:-1])[:lines] / n
    if response.method.rigid:
        within = (response.impacts.time >= sampled.time[0]) & (response.impacts.time < sampled.time[-1])
        instants, impulses = response.impacts.time[within] - sampled.time[0], response.impacts.impulse[within]
        turns = np.exp(-1j * eta * np.outer(order, instants))
        force = force + turns @ impulses / (periods * response.period)
    twice = np.where(order > 0, 2.0, 1.0)
    displacement = twice * np.abs(moved)
    return Spectrum(order, displacement, (order * eta) ** 2 * displacement, twice * np.abs(force))


def transmissibility(response: Response) -> np.ndarray:
    """Amplitude of each body's absolute motion at the excitation frequency, relative to that of the base, (2,).

    nan where the base does not move. Raises as :func:`spectrum`.

    Examples
    --------
    >>> from vibroscope.engine import Record, Reference, System, simulate, transmissibility
    >>> transmissibility(simulate(System(), 0.05, Reference(), record=Record())).round(2).tolist()  # slow: as the base
    [1.0, 1.0]
    """
    amplitude = abs(response.system.excitation.base_amplitude(response.eta))
    found = spectrum(response, 1.0)
    return found.displacement[:, -1] / amplitude if amplitude else np.full(2, np.nan)


def _sampled(response: Response):
    if response.trajectory is None:
        raise ValueError("the run has no samples: ask for them with record=Record(…)")
    return response.trajectory


def _within(time: np.ndarray, spans: np.ndarray) -> np.ndarray:
    """Whether each instant lies in one of the spans, (m, 2), which are in order and do not overlap."""
    place = np.searchsorted(spans[:, 0], time, side="right") - 1
    return (place >= 0) & (time < spans[np.maximum(place, 0), 1]) if len(spans) else np.zeros(len(time), bool)
