"""A motion as numbers: what the kept periods of a response show, with room for the evidence of what it is."""

from dataclasses import dataclass, field
from enum import StrEnum

import numpy as np

from ..methods import Newmark, Reference
from ..result import Response, Status
from .section import nearly_repeats_after, repeats_after

# "fewer than 30 steps of T/2000 as one sudden impact" (paper, Figures 10 to 12): a longer contact is a lasting one
SUDDEN = 30 / 2000
FEWEST_SAMPLES = 8  # in a contact, to see the peak of its force; half a sine wave's to 2 %


class Kind(StrEnum):
    """What a motion is."""

    PERIODIC = "periodic"
    QUASI_PERIODIC = "quasi-periodic"
    CHAOTIC = "chaotic"
    DIVERGED = "diverged"
    UNDECIDED = "undecided"


@dataclass(frozen=True)
class Motion:
    """Motion over the kept periods of a run, and what it is. Rates are those of whole cycles; nan: not known.

    Attributes
    ----------
    type : Kind
        "periodic", "quasi-periodic", "chaotic", "diverged", or "undecided".
    reason : str
        Why it is called so, in words.
    period : int
        Excitation periods until the motion repeats itself; 0 if it does not.
    near_period : int
        The same, but scatter within :data:`engine.motions.section.SCATTER` of the section's size is forgiven.
    section : (n, 4) ndarray
        Poincaré section τ ≡ 0 mod T: ξ₁, ξ₁′, ξ₂, ξ₂′, oldest first.
    impacts_per_period : float
    impact_phases : (m,) ndarray
        Instants of the impacts of the last cycle in excitation periods, from 0 to ``period``; of a motion that does
        not repeat, those of all kept periods, from 0 to 1.
    closing_speeds : (m,) ndarray
        −g′ at each of them.
    approach : float
        Smallest closing speed, a chatter counted by its first impact: near 0 the motion grazes.
    contacts_per_period : float
        Contacts that begin in a period (reference: permanent contacts).
    contact_share : float
        Share of the time in contact.
    permanent_per_period, permanent_share : float
        The same of lasting contacts: the reference's permanent contacts, the penalty model's longer than SUDDEN of a
        period.
    peak_force : float
        Largest contact force λ of the samples; the reference's impacts are not part of it. In m₁ω₁² base amplitudes;
        nan if there are too few samples in a contact.
    impulse : float
        Impulse between the pendulums in each sampled period, impacts and contacts. In m₁ω₁ base amplitudes.
    energy_lost : float
        What dampers, contact and impacts take in each period. In m₁ω₁² times the base amplitude squared.
    spread : float
        Standard deviation of ξ₂ over the section (the paper's Figure 14 in one number).
    scatter : float
        The same about the points of the near period: what is left if a motion of several periods has several points.
    multipliers : (4,) complex ndarray
        Floquet multipliers of a periodic motion, what ``period`` periods make of a small disturbance, largest first;
        empty if not known. Under ``step_noise`` they are those of the motion without a time step.
    lyapunov : float
        Largest Lyapunov exponent per excitation period; of a periodic motion ln |largest multiplier| / ``period``, of
        another Newmark motion that of its limit without a time step.
    lyapunov_error : float
        Standard error of it; 0 if it comes from multipliers.
    bifurcation : str
        The bifurcation that a periodic motion is nearest to (see :func:`.floquet.nearest`), or "".
    margin : float
        How far it is: distance of the multiplier from the unit circle, or of grazing as a share of the largest
        closing speed.
    rotation : float
        Strongest frequency of a quasi-periodic section, in turns per excitation period; nan of other motions.
    step_noise : float
        Newmark: standard deviation of ξ₁ and ξ₂ about the points of the cycle that is due to the time step; 0 if there
        is none.
    bands : tuple of (int, float)
        Newmark: steps per period, and that standard deviation with so many.
    """

    type: Kind
    reason: str
    period: int
    near_period: int
    impacts_per_period: float
    contacts_per_period: float
    contact_share: float
    permanent_per_period: float
    permanent_share: float
    spread: float
    scatter: float
    approach: float
    peak_force: float
    impulse: float
    section: np.ndarray = field(repr=False)
    impact_phases: np.ndarray = field(repr=False)
    closing_speeds: np.ndarray = field(repr=False)
    energy_lost: float = np.nan
    multipliers: np.ndarray = field(default_factory=lambda: np.empty(0, complex))
    lyapunov: float = np.nan
    lyapunov_error: float = np.nan
    bifurcation: str = ""
    margin: float = np.nan
    rotation: float = np.nan
    step_noise: float = 0.0
    bands: tuple[tuple[int, float], ...] = ()

    def as_dict(self) -> dict:
        """For scripts: plain numbers and lists, None for what is not known; ``floquet`` as [re, im]."""
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
    """What the kept periods of a response show, in a fraction of a millisecond.

    Parameters
    ----------
    response : Response
    period : int, optional
        What the motion repeats itself after, 0 for never, if that is known; else it is read off the section.
    """
    if not response.ok:
        return ended_early(response)
    section = response.section
    period = repeats_after(section) if period is None else period
    near = period or nearly_repeats_after(section)
    cycles = len(section) // near * near if near else len(section)
    end = response.window[1]
    begin = end - cycles * response.period
    hits = response.impacts.time > begin
    spans = np.clip(response.contacts, begin, end)
    lengths = spans[:, 1] - spans[:, 0]
    lasting = np.diff(response.contacts, axis=1)[:, 0] > SUDDEN * response.period
    lasting |= isinstance(response.method, Reference)
    begun = response.contacts[:, 0] > begin
    xi2 = section[len(section) - cycles :, 2].reshape(-1, near or 1)
    last = response.impacts.time > end - (period or len(section)) * response.period
    return Motion(
        type=Kind.PERIODIC if period else Kind.UNDECIDED,
        reason=_by_section(period, len(section)),
        period=period,
        near_period=near,
        impacts_per_period=int(np.sum(hits)) / cycles,
        contacts_per_period=int(np.sum(begun)) / cycles,
        contact_share=float(np.sum(lengths) / (end - begin)),
        permanent_per_period=int(np.sum(begun & lasting)) / cycles,
        permanent_share=float(np.sum(lengths[lasting]) / (end - begin)),
        spread=float(np.std(section[:, 2])),
        scatter=float(np.sqrt(np.mean(np.var(xi2, axis=0)))),
        approach=_smallest_approach(response, response.contacts[lasting, 0], begin),
        peak_force=_peak_force(response),
        impulse=_impulse(response),
        section=section,
        impact_phases=response.impacts.time[last] / response.period % (period or 1),
        closing_speeds=response.impacts.closing_speed[last],
    )


def ended_early(response: Response) -> Motion:
    """The motion of a run that blew up, or was given up."""
    diverged = response.status is Status.DIVERGED
    unknown = ("impacts", "contacts", "permanent")
    return Motion(
        type=Kind.DIVERGED if diverged else Kind.UNDECIDED,
        reason=response.ending,
        period=0,
        near_period=0,
        section=response.section,
        impact_phases=np.empty(0),
        closing_speeds=np.empty(0),
        **{f"{name}_per_period": np.nan for name in unknown},
        **dict.fromkeys(("contact_share", "permanent_share", "spread", "scatter"), np.nan),
        **dict.fromkeys(("approach", "peak_force", "impulse"), np.nan),
    )


def _by_section(period: int, rows: int) -> str:
    if period:
        return f"the section repeats itself after {period} of {rows} kept periods"
    return f"the section does not repeat itself within {rows // 2} periods; that alone does not tell what it is"


def _smallest_approach(response: Response, joined: np.ndarray, begin: float) -> float:
    """Smallest closing speed after ``begin``, but for the impacts of a chatter on its way to a lasting contact."""
    times, speeds = response.impacts.time, response.impacts.closing_speed
    counted = times > begin
    for beginning in joined:
        k = int(np.searchsorted(times, beginning, side="right")) - 1
        while k > 0 and speeds[k - 1] > speeds[k]:
            counted[k] = False
            k -= 1
    return float(speeds[counted].min()) if counted.any() else np.nan


def _peak_force(response: Response) -> float:
    sampled, method = response.trajectory, response.method
    if sampled is None:
        return np.nan
    spacing = sampled.time[1] - sampled.time[0]
    every_step = isinstance(method, Newmark) and not method.located and spacing < 1.5 * response.period / method.steps
    shown = response.contacts[response.contacts[:, 1] > sampled.time[0]]
    shortest = np.diff(shown, axis=1).min(initial=np.inf)
    largest = float(sampled.force.max())
    if isinstance(method, Reference) or every_step:
        return largest
    if shortest < FEWEST_SAMPLES * spacing:
        return np.nan
    # the damper's force sets in at once, between two samples
    struck = response.impacts.closing_speed[response.impacts.time > sampled.time[0]]
    return max(largest, 2 * method.damping * float(struck.max(initial=0.0)))


def _impulse(response: Response) -> float:
    """∫λ dτ in each sampled period, by what pendulum 1 feels: ξ₁″ + 2d₁ξ₁′ + ξ₁ = η² cos ητ − λ, integrated.

    The excitation averages to nothing over whole periods, so that ∫λ = −Δξ₁′ − 2d₁Δξ₁ − ∫ξ₁ dτ, less what the
    reference's joint damping takes beyond the two dampers, 2κ₃(d₃ − derived d₃)Δξ₁ in each permanent contact.
    """
    sampled, c = response.trajectory, response.system
    if sampled is None:
        return np.nan
    time, x, v = sampled.time, sampled.displacement[0], sampled.velocity[0]
    total = v[0] - v[-1] + 2 * c.d1 * (x[0] - x[-1]) - np.trapezoid(x, time)
    if isinstance(response.method, Reference):
        beyond = 2 * c.kappa3 * (c.joint_damping(response.method.joint_damping) - c.derived_joint_damping)
        total -= beyond * np.diff(np.interp(response.contacts, time, x), axis=1).sum()
    return float(total / (time[-1] - time[0]) * response.period)
