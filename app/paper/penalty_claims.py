"""Figures 9, 10, 13 and 14: penalty solutions beside the reference (section 4 of the paper)."""

from dataclasses import replace

import numpy as np
from vibroscope.app.explorer.state import Setting
from vibroscope.app.paper.claims import (
    SYSTEM,
    TWO_PERIODS,
    VISIBLE_SCATTER,
    Claim,
    Finding,
    count_text,
    cycle_text,
    percent,
    run_exact,
    run_method,
    run_newmark,
    run_reference,
    section_size,
)
from vibroscope.app.paper.pictures import PhasePlots, TimeHistory
from vibroscope.engine import ComparisonQuestion, Newmark, Response, compare, motion

SUDDEN_STEPS = 30  # steps of T/2000: a shorter contact counts as a sudden impact (section 4.2)
# rms difference relative to the motion: up to the first it "captures" the motion, above the second it is far from it
_CAPTURED, _MISSED = 0.1, 0.3
_LONG = 1000  # kept periods of a disturbed motion; over the paper's 50, the scatter is a matter of chance
_COARSE = 200  # steps per period of the located step
_FINE = 4  # factor of the steps that shows how the scatter falls
_LOST = "The paper's K and D for this figure are lost; these are our example."


def _both_plots(scene: Setting, penalty: Response) -> PhasePlots:
    """The reference and the penalty solution in one frame."""
    return PhasePlots({"reference": run_reference(scene), "penalty": penalty})


def _check_difference(scene: Setting) -> tuple[Finding, float]:
    """Figure 9: what was found, and the rms difference, on which the claims decide."""
    run = run_newmark(scene)
    found = compare(ComparisonQuestion(SYSTEM, scene.eta, scene.penalty)).decided()
    penalty, reference = found.penalty, found.reference  # scatter may be locked into a long cycle
    blurred = ", blurred by the time step" if penalty.step_noise else ""
    text = (
        f"{cycle_text(penalty.near_period).capitalize()}{blurred}, "
        f"{count_text(penalty.contacts_per_period, 'contact')} a period, {percent(penalty.contact_share)} of the time; "
        f"the reference has {count_text(reference.impacts_per_period, 'impact')} and "
        f"{percent(reference.contact_share)}. Displacements differ by {percent(found.total)} (rms)."
    )
    reason = (
        f"Time step {percent(found.time_step)}, K and D {percent(found.regularisation)}, the joint damping that the "
        f"penalty model has no place for {percent(found.joint_damping)}; as curves they add up, not as numbers."
    )
    same_kind = penalty.near_period == reference.period and penalty.permanent_per_period > 0
    return Finding(same_kind, text, _both_plots(scene, run), reason), found.total


def _check_captured(scene: Setting) -> Finding:
    """Figure 9 [A]: the penalty model captures the motion."""
    finding, total = _check_difference(scene)
    return replace(finding, agrees=finding.agrees and total < _CAPTURED)


def _check_missed(scene: Setting) -> Finding:
    """Figure 9 [B]: far from the reference, and yet a cycle, so that only the reference reveals it."""
    finding, total = _check_difference(scene)
    return replace(finding, agrees=total > _MISSED)


def _check_bifurcated(scene: Setting) -> Finding:
    """Figure 10 [A] and [C]: bifurcated."""
    finding, regular = _check_kind(scene)
    return replace(finding, agrees=not regular)


def _check_regular(scene: Setting) -> Finding:
    """Figure 10 [B]: not bifurcated."""
    finding, regular = _check_kind(scene)
    return replace(finding, agrees=regular)


def _check_kind(scene: Setting) -> tuple[Finding, bool]:
    """Figure 10: what was found, and whether the motion looks regular, on which the claims decide."""
    run, limit = run_newmark(scene), motion(run_exact(scene))
    found = motion(run)
    share = found.spread / section_size(run.section)
    text = (
        f"K = {scene.K:g}, D = {scene.D:g}: {cycle_text(found.period)}, ξ₂ spreads by {found.spread:.3f} "
        f"({percent(share)} of the section's size). Without a time step: {cycle_text(limit.period)}."
    )
    noise = " So the blur is the time step's alone." if limit.period == 1 and share > VISIBLE_SCATTER else ""
    return Finding(False, text, _both_plots(scene, run), _LOST + noise), share <= VISIBLE_SCATTER


def _longest_contact(scene: Setting) -> tuple[Response, float, str]:
    """Figure 13: the run, how many steps its longest contact lasts, and that in words."""
    run = run_newmark(scene, record=TWO_PERIODS)
    lasting = np.diff(run.contacts, axis=1).max() / run.period * scene.steps
    rate = count_text(motion(run).contacts_per_period, "contact")
    text = f"K = {scene.K:g}, D = {scene.D:g}: {rate} a period, of {lasting:.0f} steps; the limit is {SUDDEN_STEPS}."
    return run, lasting, text


def _check_sudden(scene: Setting) -> Finding:
    """Figure 13 [A]: a short contact."""
    run, lasting, text = _longest_contact(scene)
    reason = "The paper does not print K and D of this point; these are those that it recommends in the end."
    return Finding(lasting < SUDDEN_STEPS, text, TimeHistory(run), reason)


def _check_lasting(scene: Setting) -> Finding:
    """Figure 13 [B]: a long contact in a regular motion."""
    run, lasting, text = _longest_contact(scene)
    return Finding(lasting >= SUDDEN_STEPS and motion(run).period == 1, text, TimeHistory(run), _LOST)


def scatter(scene: Setting, steps: int | None = None, *, located: bool = False) -> float:
    """Standard deviation of ξ₂ over 1,000 periods, by the scene's method or with other steps."""
    method = Newmark(scene.K, scene.D, steps or scene.steps, located=located)
    return motion(run_method(scene, method, _LONG)).spread


def _check_disturbed(scene: Setting) -> Finding:
    """Figure 14 [A] to [C]: the time step disturbs the motion."""
    run, limit = run_newmark(scene), motion(run_exact(scene))
    found = motion(run)
    return Finding(
        found.period == 0 and limit.period == 1,
        f"{cycle_text(found.period).capitalize()}; the time step blurs ξ₂ by ±{found.spread:.4f} over the paper's 50 "
        f"periods and by ±{scatter(scene):.4f} over {_LONG:,}. Without a time step: {cycle_text(limit.period)}.",
        _both_plots(scene, run),
        "Each contact change is missed by a part of a step. That disturbs a motion of one period; it makes no "
        "quasi-periodic one.",
    )


def _check_settled(scene: Setting) -> Finding:
    """Figure 14 [D]: whether the blur is gone, and its order in the time step."""
    run = run_newmark(scene)
    found = motion(run)
    here, finer = scatter(scene), scatter(scene, steps=_FINE * scene.steps)
    order = np.log(here / finer) / np.log(_FINE) if finer > 0 else np.inf
    located = scatter(scene, steps=_COARSE, located=True)
    reason = (
        f"The blur falls as n^−{order:.1f} and is never gone, since a fixed step misses each contact change by a "
        f"part of itself; T/{scene.steps} only hides it in the line of a phase plot. Steps cut at the contact changes "
        f"leave {located:.1g} with T/{_COARSE}."
    )
    return Finding(
        found.period == 1,
        f"{cycle_text(found.period).capitalize()}; the time step blurs ξ₂ by ±{found.spread:.4f} over the paper's 50 "
        f"periods, by ±{here:.4f} over {_LONG:,}, and by ±{finer:.4f} with T/{_FINE * scene.steps}.",
        _both_plots(scene, run),
        reason if found.period == 0 else "",
    )


def _step_claim(key: str, text: str, check=_check_disturbed, **more) -> Claim:
    """A claim of Figure 14, with the scene of its own key."""
    return Claim(key, "section 4.2", text, key, check, view="step", **more)


PENALTY_CLAIMS = [
    Claim("9A", "section 4.1", "K = 2500, D = 8 with T/2000 capture the motion at η = 1.08.", "9A", _check_captured),
    Claim(
        "9B",
        "section 4.1",
        "K = 100, D = 50 give a completely different motion, far from reality.",
        "9B",
        _check_missed,
    ),
    Claim(
        "10A",
        "section 4.2",
        "A first set of K and D at η = 2.76, T/2000: bifurcated.",
        "10A",
        _check_bifurcated,
        example=True,
    ),
    Claim("10B", "section 4.2", "A second set: not bifurcated.", "10B", _check_regular, example=True),
    Claim("10C", "section 4.2", "A third set: bifurcated again.", "10C", _check_bifurcated, example=True),
    Claim(
        "13A",
        "section 4.2",
        "A point of the updated plane whose contact is short, a “sudden” impact.",
        "14A",
        _check_sudden,
        example=True,
    ),
    Claim(
        "13B",
        "section 4.2",
        "A point whose contact is too long for an impact: permanent contact.",
        "10B",
        _check_lasting,
        example=True,
    ),
    _step_claim("14A", "K = 12000, D = 18 with T/2000: the step disturbs the motion, which looks quasi-periodic."),
    _step_claim("14B", "T/4000: still disturbed."),
    _step_claim("14C", "T/6000: still disturbed."),
    _step_claim(
        "14D", "T/8000 is small enough: the stationary motion is the reference's.", _check_settled, holds=False
    ),
]
