"""What moves, by name and with the evidence: periodic, quasi-periodic or chaotic.

In closed form (reference, exact penalty):

- *periodic*: Newton's method closes a cycle that the run is caught by (:mod:`.steady`); the Floquet multipliers belong
  to it;
- otherwise the run is followed with its Jacobian. *Chaotic*: the largest Lyapunov exponent is positive beyond doubt,
  the section irregular, and both halves of the run say the same. *Quasi-periodic*: the exponent is zero as far as it
  can be told, and averages over the section converge as only those of a regular motion do (:mod:`.lyapunov`);
- what is neither is *undecided*: a transient, or a case for a longer run. A motion that settles while it is followed is
  what it settles to.

Newmark's motion is judged by its limit without a time step (:mod:`.time_step_scatter`).
"""

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from ..energy.energy import energy
from ..methods import ExactPenalty, Method, Newmark, Reference
from ..model import System
from ..result import Record, Response
from ..simulate import simulate
from .description import Kind, Motion, describe
from .floquet import exponent, multipliers, nearest
from .lyapunov import Lyapunov, lyapunov
from .section import repeats_after, rotation
from .steady import steady
from .time_step_scatter import told_apart

REST = (0.0, 0.0, 0.0, 0.0)
LONGEST = 64  # periods of a cycle that Newton's method looks for
LONGEST_SEEN = 512  # periods of a cycle that the section shows
FOLLOWED = (8192, 4 * 8192)  # periods with the Jacobian; the more only if the fewer do not decide
DRIFT = 5.0  # standard errors that the halves of a run may differ by
KEEP = 256  # periods described of a motion that does not repeat
RUN = 2050  # periods of a long run, the paper's
SAMPLES, SAMPLED = 2000, 50  # per period; periods
MOST_SAMPLES = 100_000
MOST_STEPS = 1_000_000  # per period that are recorded at all
UNBALANCED = 0.01  # of the energy that is turned over: a balance that leaves more says nothing
FARTHEST = 1e6  # base amplitudes from which no run can start (:func:`engine.simulate`)
IN_CONTACT = 60  # samples in the shortest contact of a cycle; half a sine wave's peak to 0.04 %


def motion(
    subject: Response | System,
    eta: float | None = None,
    method: Method | None = None,
    *,
    initial: Sequence[float] = REST,
    cancelled: Callable[[], bool] | None = None,
) -> Motion:
    """Describe the kept periods of a response; or find what moves, and give the evidence.

    ``motion(response)`` takes a fraction of a millisecond and calls periodic what repeats itself within half of the
    kept periods; anything else is undecided. ``motion(system, eta, method)`` runs what it takes to decide: some
    milliseconds for a periodic motion, some tenths of a second for another.

    Parameters
    ----------
    subject : Response or System
    eta : float
        Excitation frequency η = Ω/ω₁; with a system.
    method : Reference, ExactPenalty or Newmark
        With a system.
    initial : (4,) sequence
        ξ₁, ξ₁′, ξ₂, ξ₂′ at τ = 0, by default rest; with a system.
    cancelled : callable, optional
        Polled many times a second; when it returns true the run is withdrawn.

    Raises
    ------
    ValueError
        If a response ended early, or a number is out of range.
    Cancelled
        If ``cancelled`` returned true.
    """
    if isinstance(subject, Response):
        if eta is not None or method is not None:
            raise ValueError("a response knows its eta and method: give them with a system only")
        if not subject.ok:
            raise ValueError(subject.ending)
        return describe(subject)
    if eta is None or method is None:
        raise ValueError("a system alone does not move: give motion(system, eta, method), or a response")
    find = _of_newmark if isinstance(method, Newmark) else _in_closed_form
    return find(subject, eta, method, initial, cancelled)


# ------------------------------------------------------------------------------------------------------ in closed form


def _in_closed_form(system: System, eta, method: Reference | ExactPenalty, initial, cancelled) -> Motion:
    found = steady(system, eta, method, initial=initial, max_period=LONGEST, cancelled=cancelled)
    run = found.response
    if found.periodic:
        return _cycle(run, found.period, found.multipliers, cancelled)
    if not run.ok:
        return describe(run)
    state = run.section[-1]
    if np.abs(state).max() > FARTHEST:
        return _grown(run)
    for periods in FOLLOWED:
        followed = lyapunov(system, eta, method, initial=state, periods=periods, cancelled=cancelled)
        if len(followed.section) < periods:
            reason = f"after {len(followed.section)} periods more it has no derivative: an impact grazes"
            return replace(describe(run, 0), reason=reason)
        state = followed.section[-1]
        late = _late_cycle(system, eta, method, followed.section, cancelled)
        if late is not None:
            return replace(late, reason=f"{late.reason}; a run of {RUN} periods did not find it")
        kind, reason = _decided(followed)
        if kind is not Kind.UNDECIDED:
            break
    record = Record(SAMPLED, SAMPLES)
    run = simulate(system, eta, method, periods=KEEP, keep=KEEP, initial=state, record=record, cancelled=cancelled)
    return replace(
        _with_energy(describe(run, 0), run),
        type=kind,
        reason=reason,
        lyapunov=followed.exponent,
        lyapunov_error=followed.error,
        rotation=rotation(followed.section) if kind is Kind.QUASI_PERIODIC else np.nan,
    )


def _late_cycle(system: System, eta, method, section: np.ndarray, cancelled) -> Motion | None:
    """The cycle that a motion has come to while it was followed: a transient was long, or the cycle is."""
    state = section[-1]
    found = steady(system, eta, method, initial=state, max_period=LONGEST, cancelled=cancelled)
    if found.periodic:
        return _cycle(found.response, found.period, found.multipliers, cancelled)
    period = repeats_after(section[-2 * LONGEST_SEEN :])
    if not period:
        return None
    values = multipliers(system, eta, method, state, period, cancelled)
    run = simulate(system, eta, method, periods=2 * period, keep=period, initial=state, cancelled=cancelled)
    return _cycle(run, period, values, cancelled)


def _grown(run: Response) -> Motion:
    reason = f"it has grown to more than {FARTHEST:g} base amplitudes: nothing takes the energy that is put in"
    return replace(describe(run, 0), type=Kind.UNDECIDED, reason=reason)


def _decided(followed: Lyapunov) -> tuple[Kind, str]:
    """What the exponent and the section say, in words."""
    rate = f"largest Lyapunov exponent {followed.exponent:+.3g} ± {followed.error:.2g} per period"
    over = f"over {len(followed.section)} periods"
    if followed.regular and followed.sign == 0:
        turns = rotation(followed.section)
        return Kind.QUASI_PERIODIC, (
            f"{rate} {over}, zero as far as can be told, and averages over the section converge as only those of "
            f"regular motion do (to {followed.irregularity:.1g}); the other frequency is {turns:.6f} of the first"
        )
    if not followed.regular and followed.sign == 1 and followed.drift < DRIFT:
        return Kind.CHAOTIC, f"{rate} {over}"
    if followed.sign == -1:
        return Kind.UNDECIDED, f"{rate}: it contracts, but has not come to a cycle {over}"
    return Kind.UNDECIDED, f"{rate} {over}: not told from zero, or changing on the way; it may be a long transient"


def _cycle(once: Response, period: int, values: np.ndarray, cancelled) -> Motion:
    """A periodic motion from a run whose kept periods begin with a cycle: two cycles from there."""
    record = Record(period, _samples(once))
    start, twice = once.checkpoint, {"periods": 2 * period, "keep": 2 * period}
    run = simulate(once.system, once.eta, once.method, initial=start, record=record, cancelled=cancelled, **twice)
    found = _with_energy(describe(run, period), run)
    fate = "die away" if np.abs(values).max(initial=0.0) < 1 else "do not die away"
    reason = f"a cycle of {period} {'period' if period == 1 else 'periods'} closes, and disturbances of it {fate}"
    return _with_multipliers(replace(found, reason=reason, section=run.section[-period:]), values)


def _samples(run: Response) -> int:
    """Samples per period that show the peak of the force: enough of them in the shortest contact."""
    shortest = np.diff(run.contacts, axis=1).min(initial=run.period)
    return int(np.clip(IN_CONTACT * run.period / shortest, SAMPLES, MOST_SAMPLES // max(run.keep, 1)))


def _with_multipliers(found: Motion, values: np.ndarray) -> Motion:
    name, margin = nearest(values, found.closing_speeds, found.approach)
    rate = exponent(values, found.period)
    return replace(found, multipliers=values, lyapunov=rate, lyapunov_error=0.0, bifurcation=name, margin=margin)


def _with_energy(found: Motion, run: Response) -> Motion:
    """Energy lost in each period, over the last cycle or all that the balance knows."""
    if run.trajectory is None:
        return found
    balance = energy(run)
    # the balance follows a located step in closed form, which a coarse one leaves: then it does not close
    located = isinstance(run.method, Newmark) and run.method.located
    if located and not np.abs(balance.residual).max() <= UNBALANCED * balance.size:
        return found
    return replace(found, energy_lost=float(balance.lost[-found.period :].mean()))


# ------------------------------------------------------------------------------------------------------------- Newmark


def _of_newmark(system: System, eta, method: Newmark, initial, cancelled) -> Motion:
    sampled = max(1, min(SAMPLED, MOST_SAMPLES // method.steps))
    record = Record(sampled, method.steps) if method.steps <= MOST_STEPS else None
    run = simulate(system, eta, method, periods=RUN, keep=KEEP, initial=initial, record=record, cancelled=cancelled)
    if not run.ok:
        return describe(run)
    state = run.section[-1]
    if np.abs(state).max() > FARTHEST:
        return _grown(run)
    limit = _in_closed_form(system, eta, ExactPenalty(method.stiffness, method.damping), state, cancelled)
    kind, period, reason, noise, bands = told_apart(run, limit, cancelled)
    found = _with_energy(describe(run, 0 if noise else period), run)
    found = replace(found, type=kind, reason=reason, period=period, step_noise=noise, bands=bands)
    if kind is Kind.PERIODIC:
        values = limit.multipliers if noise else multipliers(system, eta, method, state, period, cancelled)
        section = found.section if noise else found.section[-period:]
        return _with_multipliers(replace(found, section=section), values)
    return replace(found, lyapunov=limit.lyapunov, lyapunov_error=limit.lyapunov_error, rotation=limit.rotation)
