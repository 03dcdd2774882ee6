"""Figures 3, 4 and 6: the motions of the reference (sections 2 and 3 of the paper)."""

import numpy as np
from vibroscope.app.explorer.presets import scenes
from vibroscope.app.explorer.state import Setting
from vibroscope.app.paper.claims import (
    SYSTEM,
    TWO_PERIODS,
    Claim,
    Finding,
    count_text,
    cycle_text,
    percent,
    run_reference,
)
from vibroscope.app.paper.pictures import PhasePlots, TimeHistory
from vibroscope.engine import Reference, diagram, motion

_TOLERANCE = 1e-5  # of the largest displacement; the diagram holds single precision


def _check_alternation(scene: Setting) -> Finding:
    """Figure 3: the periods over η, and those of the four scenes [A] to [D]."""
    shown = diagram(SYSTEM, Reference())
    period = _section_periods(np.moveaxis(shown.displacement, 0, -1))
    one, more, none = (period == 1).sum(), (period > 1).sum(), (period == 0).sum()
    changes = np.count_nonzero(np.diff(period == 0))
    four = [int(period[np.abs(shown.eta - scenes()[key].setting.eta).argmin()]) for key in "ABCD"]
    return Finding(
        min(one + more, none) > 0 and changes > 2 and four == [1, 0, 1, 2],
        f"Of {len(period):,} values of η from {shown.eta[0]:g} to {shown.eta[-1]:g}, {one} give one period, {more} "
        f"a longer cycle, {none} none of up to 25 periods; regular and irregular alternate {changes} times. "
        f"[A] to [D]: {', '.join(map(cycle_text, four))}.",
        shown,
        "From rest each time; where motions coexist, a sweep up or down shows others.",
    )


def _section_periods(sections: np.ndarray) -> np.ndarray:
    """Least number of periods after which each section (n, sample, c) repeats, (n,); 0 if more than half the sample."""
    period = np.zeros(len(sections), int)
    allowed = _TOLERANCE * np.abs(sections).max(axis=(1, 2))
    for p in range(sections.shape[1] // 2, 0, -1):
        period[np.abs(sections[:, p:] - sections[:, :-p]).max(axis=(1, 2)) <= allowed] = p
    return period


def _check_sticking(scene: Setting) -> Finding:
    """Figure 4 [A]: several impacts, then permanent contact."""
    run = run_reference(scene)
    found = motion(run)
    return Finding(
        found.period == 1 and found.impacts_per_period > 2 and found.contacts_per_period == 1,
        f"{cycle_text(found.period).capitalize()}; {count_text(found.impacts_per_period, 'impact')} and "
        f"{count_text(found.contacts_per_period, 'permanent contact')} a period, "
        f"{percent(found.contact_share)} of the time.",
        PhasePlots({"reference": run}),
    )


def _check_stripes(scene: Setting) -> Finding:
    """Figure 4 [B]: the stripes are there, but neighbouring motions diverge."""
    run, found = run_reference(scene), motion(SYSTEM, scene.eta, Reference())
    low, high = sorted((run.section[::2, 0], run.section[1::2, 0]), key=np.mean)
    apart = high.min() - low.max()
    bands = f"in two bands that it visits in turn, {apart:.2f} apart in ξ₁" if apart > 0 else "in one band"
    reason = (
        "The picture is the paper's, its name is not: of a quasi-periodic motion the exponent would be zero. Here two "
        f"motions that start close together part e-fold every {1 / found.lyapunov:.1f} periods."
    )
    return Finding(
        found.type == "quasi-periodic",
        f"Stripes, {bands}. The motion is {found.type}, its largest Lyapunov exponent {found.lyapunov:+.3f} ± "
        f"{found.lyapunov_error:.3f} a period.",
        PhasePlots({"reference": run}),
        reason if found.type == "chaotic" else "",
    )


def _check_one_impact(scene: Setting) -> Finding:
    """Figure 4 [C]: one impact a period."""
    run = run_reference(scene)
    found = motion(run)
    return Finding(
        (found.period, found.impacts_per_period, found.contacts_per_period) == (1, 1, 0),
        f"{cycle_text(found.period).capitalize()}; {count_text(found.impacts_per_period, 'impact')} a period, "
        f"closing at {found.closing_speeds[0]:.3f}; {count_text(found.contacts_per_period, 'permanent contact')}.",
        PhasePlots({"reference": run}),
    )


def _check_doubling(scene: Setting) -> Finding:
    """Figure 4 [D]: a cycle of two periods."""
    run = run_reference(scene)
    found = motion(run)
    return Finding(
        found.period == 2,
        f"{cycle_text(found.period).capitalize()}, with {count_text(2 * found.impacts_per_period, 'impact')} in two.",
        PhasePlots({"reference": run}),
    )


def _check_chatter(scene: Setting) -> Finding:
    """Figure 6, η = 1.08: the intervals between the impacts that lead to the last permanent contact."""
    run = run_reference(scene, TWO_PERIODS)
    if len(run.contacts) < 2:
        return Finding(False, "No permanent contact.", TimeHistory(run))
    begin, end = run.contacts[-2]
    before = run.impacts.time[(run.impacts.time > begin - run.period / 2) & (run.impacts.time <= begin)]
    intervals = np.diff(before) / run.period
    peak = run.trajectory.force.max()
    return Finding(
        len(intervals) > 2 and (np.diff(intervals) < 0).all() and np.isclose(before[-1], begin) and peak > 0,
        f"{len(before)} impacts, {intervals[0]:.4f} T apart at first and {intervals[-1]:.4f} T at last, each interval "
        f"shorter than the one before; then contact for {(end - begin) / run.period:.3f} T with a force of up to "
        f"{peak:.2f}.",
        TimeHistory(run),
        _NO_EXPERIMENT,
    )


def _check_sudden_impact(scene: Setting) -> Finding:
    """Figure 6, η = 2.76: one impact and no lasting force."""
    run = run_reference(scene, TWO_PERIODS)
    found = motion(run)
    return Finding(
        found.impacts_per_period == 1 and not found.contact_share and not run.trajectory.force.any(),
        f"One impact a period, at {found.impact_phases[0]:.4f} T, with an impulse of {found.impulse:.3f}; no force at "
        "any other instant.",
        TimeHistory(run),
        _NO_EXPERIMENT,
    )


_NO_EXPERIMENT = "Only the calculated curves are remade: the measured ones exist in print alone."

REFERENCE_CLAIMS = [
    Claim(
        "3",
        "section 2",
        "Over the excitation frequency, regions of irregular motion and windows of periodic motion alternate.",
        "A",
        _check_alternation,
        view="bifurcation",
    ),
    Claim(
        "4A",
        "section 2",
        "η = 1.08: several impacts in a period, then permanent contact; one period.",
        "A",
        _check_sticking,
    ),
    Claim(
        "4B",
        "section 2",
        "η = 1.70: a quasi-periodic motion, its lines widened to stripes.",
        "B",
        _check_stripes,
        holds=False,
    ),
    Claim("4C", "section 2", "η = 2.76: not bifurcated, one impact in each period.", "C", _check_one_impact),
    Claim("4D", "section 2", "η = 3.25: the period is doubled.", "D", _check_doubling),
    Claim(
        "6A",
        "section 3",
        "η = 1.08: impacts at ever shorter intervals lead into permanent contact with a contact force.",
        "A",
        _check_chatter,
    ),
    Claim(
        "6B",
        "section 3",
        "η = 2.76: displacements with one sudden impact and no lasting force.",
        "C",
        _check_sudden_impact,
    ),
]
