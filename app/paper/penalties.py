"""Figures 9, 10, 13 and 14: penalty solutions beside the reference (section 4 of the paper)."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from vibroscope.app.explorer.scenes import Scene
from vibroscope.app.paper.claim import (
    SEEN,
    SYSTEM,
    Claim,
    Finding,
    Orbits,
    Times,
    count,
    exact,
    newmark,
    percent,
    periods,
    reach,
    reference,
)
from vibroscope.app.paper.claim import run as run_of
from vibroscope.engine import Newmark, Record, Response, compare, motion

SUDDEN = 30  # steps of T/2000: a shorter contact counts as a sudden impact (section 4.2)
_CAPTURED, _MISSED = 0.1, 0.3  # rms difference, relative to the motion: "captures" up to one, "far from reality" above
_LONG = 1000  # kept periods of a disturbed motion: the scatter of the paper's 50 is a matter of chance
_COARSE = 200  # steps per period of the located step
_FINE = 4  # times as many steps, to see how the scatter falls
_TWO_PERIODS = Record(2, 1000)
_LOST = "The paper's K and D for this figure are lost; these are our example."


def _beside(scene: Scene, penalty: Response) -> Orbits:
    return Orbits({"reference": reference(scene), "penalty": penalty})


def _difference(scene: Scene) -> tuple[Finding, float]:
    """Both motions and the parts of what lies between them, for Figure 9; the claim decides whether that agrees."""
    run = newmark(scene)
    apart = compare(SYSTEM, scene.eta, Newmark(scene.K, scene.D, scene.steps))
    found, wanted = apart.motions.penalty, apart.motions.reference
    text = (
        f"{periods(found.period).capitalize()}, {count(found.contacts_per_period, 'contact')} a period, "
        f"{percent(found.contact_share)} of the time; the reference has "
        f"{count(wanted.impacts_per_period, 'impact')} and {percent(wanted.contact_share)}. "
        f"Displacements differ by {percent(apart.total)} (rms)."
    )
    why = (
        f"Time step {percent(apart.time_step)}, K and D {percent(apart.regularisation)}, the joint damping that the "
        f"penalty model has no place for {percent(apart.joint_damping)}; as curves they add up, not as numbers."
    )
    same_kind = found.period == wanted.period and found.permanent_per_period > 0
    return Finding(same_kind, text, _beside(scene, run), why), apart.total


def _captures(scene: Scene) -> Finding:
    """Figure 9 [A]."""
    finding, total = _difference(scene)
    return replace(finding, agrees=finding.agrees and total < _CAPTURED)


def _misses(scene: Scene) -> Finding:
    """Figure 9 [B]: far off, and yet a cycle, so that nothing but the reference tells."""
    finding, total = _difference(scene)
    return replace(finding, agrees=total > _MISSED)


def _bifurcates(scene: Scene) -> Finding:
    """Figure 10 [A] and [C]."""
    finding, regular = _kind(scene)
    return replace(finding, agrees=not regular)


def _regular(scene: Scene) -> Finding:
    """Figure 10 [B]."""
    finding, regular = _kind(scene)
    return replace(finding, agrees=regular)


def _kind(scene: Scene) -> tuple[Finding, bool]:
    run, limit = newmark(scene), motion(exact(scene))
    found = motion(run)
    scatter = found.spread / reach(run.section)
    text = (
        f"K = {scene.K:g}, D = {scene.D:g}: {periods(found.period)}, ξ₂ spreads by {found.spread:.3f} "
        f"({percent(scatter)} of the section's size). Without a time step: {periods(limit.period)}."
    )
    noise = " So the scatter is the time step's alone." if limit.period == 1 and scatter > SEEN else ""
    return Finding(False, text, _beside(scene, run), _LOST + noise), scatter <= SEEN


def _contact(scene: Scene) -> tuple[Response, float, str]:
    """Figure 13: how many steps the longest contact lasts."""
    run = newmark(scene, record=_TWO_PERIODS)
    lasting = np.diff(run.contacts, axis=1).max() / run.period * scene.steps
    rate = count(motion(run).contacts_per_period, "contact")
    text = f"K = {scene.K:g}, D = {scene.D:g}: {rate} a period, of {lasting:.0f} steps; the limit is {SUDDEN}."
    return run, lasting, text


def _sudden(scene: Scene) -> Finding:
    """Figure 13 [A]."""
    run, lasting, text = _contact(scene)
    why = "The paper does not print K and D of this point; these are those that it recommends in the end."
    return Finding(lasting < SUDDEN, text, Times(run), why)


def _lasting(scene: Scene) -> Finding:
    """Figure 13 [B]: a regular motion all the same."""
    run, lasting, text = _contact(scene)
    return Finding(lasting >= SUDDEN and motion(run).period == 1, text, Times(run), _LOST)


def _scatter(scene: Scene, **changed: int | bool) -> float:
    """Standard deviation of ξ₂ over 1,000 periods."""
    method = replace(Newmark(scene.K, scene.D, scene.steps), **changed)
    return motion(run_of(scene, method, _LONG)).spread


def _disturbed(scene: Scene) -> Finding:
    """Figure 14 [A] to [C]."""
    run, limit = newmark(scene), motion(exact(scene))
    found = motion(run)
    return Finding(
        found.period == 0 and limit.period == 1,
        f"{periods(found.period).capitalize()}; ξ₂ scatters by {found.spread:.4f} over the paper's 50 periods "
        f"and by {_scatter(scene):.4f} over {_LONG:,}. Without a time step: {periods(limit.period)}.",
        _beside(scene, run),
        "Each contact change is missed by a part of a step. That disturbs a motion of one period; it makes no "
        "quasi-periodic one.",
    )


def _settled(scene: Scene) -> Finding:
    """Figure 14 [D]: whether the scatter is gone, and how it falls."""
    run = newmark(scene)
    found = motion(run)
    here, finer = _scatter(scene), _scatter(scene, steps=_FINE * scene.steps)
    order = np.log(here / finer) / np.log(_FINE) if finer > 0 else np.inf
    located = _scatter(scene, steps=_COARSE, located=True)
    why = (
        f"The scatter falls as n^−{order:.1f} and is never gone, since a fixed step misses each contact change by a "
        f"part of itself; T/{scene.steps} only hides it in the line of a phase plot. A step that lands on the contact "
        f"changes leaves {located:.1g} with T/{_COARSE}."
    )
    return Finding(
        found.period == 1,
        f"{periods(found.period).capitalize()}; ξ₂ scatters by {found.spread:.4f} over the paper's 50 periods, "
        f"by {here:.4f} over {_LONG:,}, and by {finer:.4f} with T/{_FINE * scene.steps}.",
        _beside(scene, run),
        why if found.period == 0 else "",
    )


def _step(key: str, text: str, check=_disturbed, **more) -> Claim:
    return Claim(key, "section 4.2", text, key, check, tab="step", **more)


PENALTIES = [
    Claim("9A", "section 4.1", "K = 2500, D = 8 with T/2000 capture the motion at η = 1.08.", "9A", _captures),
    Claim(
        "9B",
        "section 4.1",
        "K = 100, D = 50 give a completely different motion, far from reality.",
        "9B",
        _misses,
    ),
    Claim(
        "10A",
        "section 4.2",
        "A first set of K and D at η = 2.76, T/2000: bifurcated.",
        "10A",
        _bifurcates,
        example=True,
    ),
    Claim("10B", "section 4.2", "A second set: not bifurcated.", "10B", _regular, example=True),
    Claim("10C", "section 4.2", "A third set: bifurcated again.", "10C", _bifurcates, example=True),
    Claim(
        "13A",
        "section 4.2",
        "A point of the updated plane whose contact is short, a “sudden” impact.",
        "14A",
        _sudden,
        example=True,
    ),
    Claim(
        "13B",
        "section 4.2",
        "A point whose contact is too long for an impact: permanent contact.",
        "10B",
        _lasting,
        example=True,
    ),
    _step("14A", "K = 12000, D = 18 with T/2000: the step disturbs the motion, which looks quasi-periodic."),
    _step("14B", "T/4000: still disturbed."),
    _step("14C", "T/6000: still disturbed."),
    _step("14D", "T/8000 is small enough: the stationary motion is the reference's.", _settled, holds=False),
]
