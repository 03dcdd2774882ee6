"""Description of a motion by numbers: what the kept periods of a response show, and the evidence for its type.

Contact force of a sampled response: its peak and its impulse.
"""

from dataclasses import dataclass, field
from enum import IntEnum, StrEnum

import numpy as np
from vibroscope.engine.drivers.section import describe_section, name_numbers
from vibroscope.engine.law_table import LAWS
from vibroscope.engine.motions.tolerances import ALIKE_PHASE, ALIKE_SPEED, SUDDEN
from vibroscope.engine.result import Impacts, Response, Status
from vibroscope.engine.wording import html_table

FEWEST_IN_CONTACT = 8  # in a contact, to see the peak of its force: 2 % off at most for half a sine wave


def peak_force(response: Response) -> float:
    """Largest contact force of the samples, of both stops; nan if there are too few of them in a contact."""
    sampled, method = response.trajectory, response.method
    if sampled is None:
        return np.nan
    spacing = sampled.time[1] - sampled.time[0]
    every_step = spacing * method.grid_steps < 1.5 * response.period and method.grid_steps > 0
    system = response.system
    largest = float(np.abs(sampled.force).max() if system.two_stops else sampled.force.max())
    if method.rigid or every_step:
        return largest
    contacts = response.contacts[response.contacts[:, 1] > sampled.time[0]]
    first = np.clip(np.searchsorted(sampled.time, contacts[:, 0]), 0, len(sampled.time) - 2)
    spacing = sampled.time[first + 1] - sampled.time[first]  # where each begins: under a load it varies
    if (np.diff(contacts, axis=1)[:, 0] < FEWEST_IN_CONTACT * spacing).any():
        return np.nan
    if not LAWS[method.law].jumps:
        return largest
    # the damper's force jumps when the contact begins, between two samples
    impacts = response.impacts
    damping = method.damping * np.where(impacts.impulse < 0, system.damping_factor2, 1.0)
    jumps = 2 * damping * impacts.closing_speed
    return max(largest, float(jumps[impacts.time > sampled.time[0]].max(initial=0.0)))


def impulse_per_period(response: Response) -> float:
    """∫λ dτ per sampled period, from the equation of motion ξ₁″ + 2d₁ξ₁′ + k₁x₁ = l₁(τ) − λ of body 1.

    k₁x₁ is k₁ξ₁ less the constant force. The excitation integrates to zero over whole periods, so that
    ∫λ dτ = −Δξ₁′ − 2d₁Δξ₁ − ∫k₁x₁ dτ. Where the reference is in permanent contact, its joint damping exceeds the two
    dampers, and 2κ₃(d₃ − derived d₃)Δξ₁ is subtracted. An impact with which the run begins lies before the first
    sample, and its impulse is added.

    Between two stops the impulses of both are added by their size: Σ|∫λ dτ| of the contacts that begin in the samples,
    and ∫|λ| dτ of the reference's permanent contacts.
    """
    sampled, c = response.trajectory, response.system
    if sampled is None:
        return np.nan
    if not (len(response.contacts) or len(response.impacts)):
        return 0.0  # from the equation of motion it would be the rounding of its terms
    if c.two_stops:
        met = response.impacts.time >= sampled.time[0]
        total = np.abs(response.impacts.impulse[met]).sum()
        total += np.trapezoid(np.abs(sampled.force), sampled.time) if response.method.rigid else 0.0
        return float(total / (sampled.time[-1] - sampled.time[0]) * response.period)
    time, x, v = sampled.time, sampled.displacement[0], sampled.velocity[0]
    total = v[0] - v[-1] + 2 * c.d1 * (x[0] - x[-1]) - np.trapezoid(c.spring1 * x - c.excitation.constant1, time)
    if response.method.rigid:
        excess = 2 * (c.joint_damper(response.method.joint_damping) - c.joint_damper("derived"))
        total -= excess * np.diff(np.interp(response.contacts, time, x), axis=1).sum()
        impacts = response.impacts
        total += impacts.impulse[impacts.time <= 0.0].sum() if time[0] <= 0.0 else 0.0
    return float(total / (time[-1] - time[0]) * response.period)


class Kind(StrEnum):
    """Kind of a motion: the only vocabulary. Results of many cells hold the number of a word (`CellKind`).

    The numbers follow the order here, and stores keep them: a new kind comes last.
    """

    UNKNOWN = "unknown"  # not computed, or not judged yet
    UNDECIDED = "undecided"  # it does not repeat itself as far as is known
    PERIODIC = "periodic"
    QUASI_PERIODIC = "quasi-periodic"
    CHAOTIC = "chaotic"
    ENDED_EARLY = "ended-early"
    ARTEFACT = "artefact"  # periodic without a time step; the scatter of the section is caused by the step
    DIVERGED = "diverged"


# The number of each kind of motion; "unknown" is the one of a cell that was not computed.
CellKind = IntEnum("CellKind", {kind.name: number for number, kind in enumerate(Kind, -1)}, module=__name__)


@dataclass(frozen=True)
class Motion:
    """Motion over the kept periods of a run, and its type. Rates are averages over whole cycles; nan means unknown.

    Attributes
    ----------
    type : Kind
        "periodic", "quasi-periodic", "chaotic", "diverged", or "undecided".
    reason : str
        Why it has this type, in words.
    period : int
        Excitation periods until the motion repeats itself; 0 if it does not.
    near_period : int
        The same without scatter. Found from the section alone, at most four, with scatter up to
        :data:`engine.drivers.section.NEAR_TOLERANCE` of its size; with evidence, that of the motion without a time
        step if the scatter is the time step's.
    section : (n, 4) ndarray
        Poincaré section τ ≡ 0 mod T: ξ₁, ξ₁′, ξ₂, ξ₂′, oldest first.
    periods : int
        Over which what is given per period, and shares of the time, are averages: the last ones.
    sampled : int
        Periods in which peak force and impulse are looked for; 0 without samples.
    impacts_per_period : float
    impact_phases : (m,) ndarray
        Instants of the impacts of the last cycle in excitation periods, from 0 to ``period``; if the motion does not
        repeat itself, those of all kept periods, from 0 to 1.
    closing_speeds : (m,) ndarray
        −g′ at each of these impacts.
    approach : float
        Smallest closing speed, where a chatter counts with its first impact only; near 0 the motion grazes.
    contacts_per_period : float
        Contacts that begin in a period (reference: permanent contacts).
    contact_share : float
        Share of the time in contact.
    permanent_per_period, permanent_share : float
        The same for lasting contacts: permanent contacts of the reference, and contacts of the penalty model that last
        longer than SUDDEN of a period.
    peak_force : float
        Largest contact force λ of the samples, without the reference's impacts, in m₁ω₁² base amplitudes; nan if
        a contact has too few samples.
    impulse : float
        Impulse between the pendulums per sampled period, of impacts and contacts, in m₁ω₁ base amplitudes.
    energy_lost : float
        Energy dissipated per period by dampers, contact and impacts, in m₁ω₁² times the base amplitude squared. That
        of a solution with a time step includes what the step creates.
    energy_created : float
        Energy that the time step creates per period, in the same unit; negative: removes. nan without a time step.
    spread : float
        Standard deviation of a displacement over the section: of ξ₂, as in the paper's Figure 14, of ξ₁ at a wall.
    scatter : float
        Standard deviation of the same about the points of the nearly repeated cycle: ``spread`` without the difference
        between the points of a cycle of several periods.
    multipliers : (4,) complex ndarray
        Floquet multipliers of a periodic motion, the factors of small disturbances over ``period`` periods, largest
        first; empty if unknown. If ``step_noise`` is not zero, those of the motion without a time step.
    lyapunov : float
        Largest Lyapunov exponent per excitation period. For a periodic motion the logarithm of the largest multiplier's
        modulus over ``period``, for another motion of Newmark's method that of its limit without a time step.
    lyapunov_error : float
        Standard error of ``lyapunov``; 0 if it follows from multipliers.
    bifurcation : str
        The bifurcation that a periodic motion is nearest to (:func:`.poincare_map.nearest_bifurcation`), or "".
    margin : float
        Distance from that bifurcation: of the multiplier from the unit circle, or for grazing the smallest closing
        speed relative to the largest.
    rotation : float
        Rotation number of a quasi-periodic section, in turns per excitation period; nan for other motions.
    step_noise : float
        Newmark: ``scatter`` if the time step causes it; else 0.
    bands : tuple of (int, float)
        Newmark: numbers of steps per period, and the scatter of the same displacement with each.
    own_period : float
        τ after which a free vibration repeats itself, whatever η; nan of any other motion.
    symmetric : bool or None
        Between two stops that are alike, whether the cycle is its own mirror image half its length later; None
        elsewhere, and of what does not repeat itself.
    body : int
        The body whose displacement ``spread`` and ``scatter`` are of (:attr:`System.observed_body`).
    """

    type: Kind
    reason: str
    period: int = 0
    near_period: int = 0
    impacts_per_period: float = np.nan
    contacts_per_period: float = np.nan
    contact_share: float = np.nan
    permanent_per_period: float = np.nan
    permanent_share: float = np.nan
    spread: float = np.nan
    scatter: float = np.nan
    approach: float = np.nan
    peak_force: float = np.nan
    impulse: float = np.nan
    section: np.ndarray = field(repr=False, kw_only=True)
    impact_phases: np.ndarray = field(repr=False, default_factory=lambda: np.empty(0))
    closing_speeds: np.ndarray = field(repr=False, default_factory=lambda: np.empty(0))
    energy_lost: float = np.nan
    energy_created: float = np.nan
    multipliers: np.ndarray = field(default_factory=lambda: np.empty(0, complex))
    lyapunov: float = np.nan
    lyapunov_error: float = np.nan
    bifurcation: str = ""
    margin: float = np.nan
    rotation: float = np.nan
    step_noise: float = 0.0
    bands: tuple[tuple[int, float], ...] = ()
    own_period: float = np.nan
    symmetric: bool | None = None
    body: int = 2
    periods: int = 0
    sampled: int = 0

    def __repr__(self) -> str:
        period = f", period {self.period}" if self.period else ""
        rates = f"{self.impacts_per_period:.3g} impacts per period, {self.contact_share:.3g} of the time in contact"
        return f"Motion({self.type}{period}: {rates})"

    def _repr_html_(self) -> str:
        numbers = {name: value for name, value in self.as_dict().items() if isinstance(value, str | float) and value}
        return html_table(repr(self), numbers)

    def as_dict(self) -> dict:
        """Return plain numbers and lists for scripts; None for unknown numbers, ``floquet`` as pairs [re, im]."""
        plain = {
            name: None if isinstance(value, float) and not np.isfinite(value) else value
            for name, value in vars(self).items()
            if name not in ("type", "multipliers", "section", "impact_phases", "closing_speeds", "bands")
        }
        return {
            "type": str(self.type),
            **plain,
            "floquet": [[value.real, value.imag] for value in self.multipliers.tolist()],
            "impact_phases": self.impact_phases.tolist(),
            "closing_speeds": self.closing_speeds.tolist(),
            "bands": [list(pair) for pair in self.bands],
            "section": self.section.tolist(),
        }


def describe(response: Response, period: int | None = None) -> Motion:
    """Describe the kept periods of a response, in a fraction of a millisecond.

    Parameters
    ----------
    response : Response
    period : int, optional
        Excitation periods until the motion repeats itself, 0 for never; by default it is found from the section.
    """
    if not response.ok:
        return _early_end(response)
    section, numbers = response.section, name_numbers(describe_section(response, period))
    period, near = int(numbers["period"]), int(numbers["near_period"])
    cycles = len(section) // max(near, 1) * max(near, 1)
    end = response.window[1]
    begin = end - cycles * response.period
    spans = np.clip(response.contacts, begin, end)
    lengths = spans[:, 1] - spans[:, 0]
    lasting = np.diff(response.contacts, axis=1)[:, 0] > SUDDEN * response.period
    lasting |= response.method.rigid
    at_start = (response.contacts[:, 0] <= 0.0) & (begin <= 0.0)  # which the section does not count
    begun = (response.contacts[:, 0] > begin) | at_start
    last = response.impacts.time > end - (period or len(section)) * response.period
    return Motion(
        type=Kind.PERIODIC if period else Kind.UNDECIDED,
        reason=_reason(period, len(section)),
        period=period,
        near_period=near,
        impacts_per_period=float(numbers["impacts_per_period"]),
        contacts_per_period=float(numbers["contacts_per_period"]) + int(at_start.sum()) / cycles,
        contact_share=float(numbers["contact_share"]),
        permanent_per_period=int(np.sum(begun & lasting)) / cycles,
        permanent_share=float(np.sum(lengths[lasting]) / (end - begin)),
        spread=float(numbers["spread"]),
        scatter=float(numbers["scatter"]),
        approach=_smallest_approach(response, response.contacts[lasting], begin),
        peak_force=peak_force(response),
        impulse=impulse_per_period(response),
        section=section,
        impact_phases=response.impacts.time[last] / response.period % (period or 1),
        closing_speeds=response.impacts.closing_speed[last],
        symmetric=_is_symmetric(response, period, last),
        body=response.system.observed_body,
        periods=cycles,
        sampled=sampled_periods(response),
    )


def sampled_periods(response: Response) -> int:
    """Excitation periods that a response has samples of."""
    sampled = response.trajectory
    return 0 if sampled is None else round((sampled.time[-1] - sampled.time[0]) / response.period)


def _early_end(response: Response) -> Motion:
    """Return the motion of a run that did not reach its end: nothing but its type is known."""
    kind = Kind.DIVERGED if response.status is Status.DIVERGED else Kind.UNDECIDED
    return Motion(kind, response.ending, section=response.section, body=response.system.observed_body)


def _is_symmetric(response: Response, period: int, last: np.ndarray) -> bool | None:
    """Whether the impacts of the last cycle at the second stop are those at the first, half a cycle later."""
    if not (response.system.is_symmetric and period):
        return None
    impacts = response.impacts
    turn, speed = np.exp(2j * np.pi * impacts.time[last] / response.period / period), impacts.closing_speed[last]
    first = impacts.impulse[last] > 0
    if period % 2 == 0 or first.sum() != (~first).sum():
        return False
    step = 1 / response.method.grid_steps if response.method.grid_steps else 0.0
    allowed = 2 * np.pi * (ALIKE_PHASE + 2 * step) / period
    for phase, closing in zip(turn[first], speed[first], strict=True):
        near = np.abs(turn[~first] + phase) <= allowed
        if not (near & (np.abs(speed[~first] - closing) <= ALIKE_SPEED * speed.max())).any():
            return False
    return True


def _reason(period: int, rows: int) -> str:
    """The section in words."""
    if period:
        return f"the section repeats itself after {period} of {rows} kept periods"
    return f"the section does not repeat itself within {rows // 2} periods; that alone does not show what it is"


def chatter_before(impacts: Impacts, last: int, lasts: float) -> int:
    """The first impact of the chatter that ends with impact ``last`` in a contact that lasts so long.

    Each is slower than the one before, at ever shorter intervals, and the last of these is shorter than the contact: a
    decay of separate impacts is no chatter.
    """
    times, speeds, first, shortest = impacts.time, impacts.closing_speed, last, 0.0
    while first > 0 and speeds[first - 1] > speeds[first]:
        interval = times[first] - times[first - 1]
        if interval < shortest or (first == last and interval > lasts):
            break
        first, shortest = first - 1, interval
    return first


def _smallest_approach(response: Response, lasting: np.ndarray, begin: float) -> float:
    """Smallest closing speed after ``begin``; of a chatter that ends in a lasting contact only the first impact counts.

    Parameters
    ----------
    lasting : (m, 2) ndarray
        τ at which lasting contacts begin and end.
    """
    times, speeds = response.impacts.time, response.impacts.closing_speed
    counted = times > begin
    for start, end in lasting.tolist():
        last = int(np.searchsorted(times, start, side="right")) - 1
        counted[chatter_before(response.impacts, last, end - start) + 1 : last + 1] = False
    return float(speeds[counted].min()) if counted.any() else np.nan
