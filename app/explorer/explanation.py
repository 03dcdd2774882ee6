"""The results in sentences: what each solver found, what their difference consists of, and what to change first."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from vibroscope.app.explorer.compute import Run, RunPair
from vibroscope.app.explorer.errors import Refused
from vibroscope.app.explorer.present import TIME_POINTS, WINDOW
from vibroscope.app.explorer.state import Setting, print_number, read_setting
from vibroscope.engine import PARTS, Comparison, Response, Units, compare, verdict

_COUNTS = {
    1: "One period",
    2: "Two periods",
    3: "Three periods",
    4: "Four periods",
    5: "Five periods",
    6: "Six periods",
    7: "Seven periods",
    8: "Eight periods",
}


@dataclass(frozen=True)
class Description:
    """What each solver found, and its cost; known as soon as the runs are.

    Attributes
    ----------
    reference, penalty : str
        A line each.
    cost : tuple of (str, str, str)
        Label, value, and meaning.
    """

    reference: str
    penalty: str
    cost: tuple[tuple[str, str, str], ...]


@dataclass(frozen=True)
class Explanation:
    """What the difference consists of, and what to change first; it takes a few more runs.

    Attributes
    ----------
    headline : str
        Short sentences.
    agree : str
        "yes", "partly", "no" or "unknown".
    parts : dict of str to float
        Relative rms of the difference of the displacements: ``total``, ``time_step``, ``regularisation`` and
        ``joint_damping``; empty where the motions are not in phase, so that a difference at an instant means nothing.
    change : dict of str to str
        What to set first, as texts for `app.explorer.state.read_setting`; empty if no number helps.
    details : tuple of str
        The numbers behind the headline.
    series : dict of str to (2, n) ndarray
        The same parts of ξ₁ and ξ₂ over the last ``WINDOW`` periods, evenly spaced, both ends included.
    """

    headline: str
    agree: str
    parts: dict[str, float]
    change: dict[str, str]
    details: tuple[str, ...]
    series: dict[str, np.ndarray]


def describe(runs: RunPair) -> Description:
    """Describe both runs and their cost."""
    scale = runs.setting.scale
    return Description(_describe_run(runs.reference, scale), _describe_run(runs.penalty, scale), _cost(runs))


def explain(runs: RunPair, cancelled: Callable[[], bool] | None = None) -> Explanation:
    """Explain the difference of both runs; raises `engine.Cancelled` if ``cancelled()``."""
    setting = runs.setting
    comparison = compare(
        setting.system,
        setting.eta,
        setting.penalty,
        reference=setting.reference,
        responses=[run.response for run in (runs.reference, runs.penalty)],
        cancelled=cancelled,
    )
    found = verdict(comparison, cancelled=cancelled)
    values = {name: getattr(comparison, name) for name in ("total", *PARTS)}
    parts = {name: value for name, value in values.items() if math.isfinite(value)} if comparison.pointwise else {}
    series = {name: _last_periods(comparison, getattr(comparison.parts, name)[:2]) for name in parts}
    change, limit = _takeable(_change_texts(found.change), setting)
    headline = found.headline + _shift_note(comparison) + limit
    return Explanation(headline, found.agree, parts, change, found.details, series)


def paragraphs(description: Description, explanation: Explanation | None) -> dict[str, str]:
    """The whole text by headings; without an explanation, what is known so far."""
    first = {"Do they agree?": " ".join((explanation.headline, *explanation.details))} if explanation else {}
    return first | {"Reference": description.reference, "Penalty": description.penalty}


def _shift_note(comparison: Comparison) -> str:
    """The phase by which the motions are drawn apart: one of several periods may start with any of them."""
    shift = comparison.parts.shifts.reference if comparison.pointwise else 0
    if not shift:
        return ""
    apart = f"{_COUNTS.get(shift, str(shift)).lower()}{'' if shift <= len(_COUNTS) else ' periods'}"
    return f" They are drawn {apart} apart, and compared in step."


def _last_periods(comparison: Comparison, rows: np.ndarray) -> np.ndarray:
    """The last ``WINDOW`` periods, (2, n), of rows that are sampled over all kept periods."""
    tail = rows[:, -WINDOW * (rows.shape[1] // comparison.runs.reference.keep) :]
    old = np.arange(tail.shape[1]) * WINDOW / tail.shape[1]
    new = np.linspace(0, WINDOW, TIME_POINTS)
    return np.stack([np.interp(new, old, row) for row in tail]).astype(np.float32)


def _change_texts(change: dict[str, float | bool]) -> dict[str, str]:
    """The proposed change as texts for the controls."""
    texts = {}
    for name, value in change.items():
        if name == "located":
            texts[name] = "yes" if value else "no"
        else:
            texts[name] = print_number(round(value) if name == "steps" else float(f"{value:.3g}"))
    return texts


def _takeable(change: dict[str, str], setting: Setting) -> tuple[dict[str, str], str]:
    """The change if the page takes it; otherwise none, and why not."""
    try:
        read_setting(change, setting)
    except Refused as error:
        return {}, f" Not on this page: {error}"
    return change, ""


def _cost(runs: RunPair) -> tuple[tuple[str, str, str], ...]:
    reference, penalty = runs.reference.response, runs.penalty.response
    times = f"Computing took {_duration(penalty)} for the penalty run, {_duration(reference)} for the reference."
    meaning = f"Steps that an FE code would compute one by one for these {penalty.periods} periods"
    return (
        ("FE steps", f"{penalty.cost.steps / 1e6:.3g} M", meaning),
        ("penalty run", _duration(penalty), times),
        ("reference run", _duration(reference), times),
    )


def _duration(response: Response) -> str:
    return (
        f"{1e3 * response.cost.seconds:.2g} ms" if response.cost.seconds < 0.0995 else f"{response.cost.seconds:.2g} s"
    )


def _describe_run(run: Run, scale: Units | None) -> str:
    """Period, impacts per period and share of contact of one run; with a scale, also its peak force."""
    if not run.response.ok:
        return f"No result. {sentence(run.response.message)}"
    force = ""
    if scale is not None and run.motion.peak_force > 0:
        force = f" Peak force {scale.physical('force', run.motion.peak_force):.3g} N."
    return f"{_period_text(run)}, {_impact_rate(run)} per period, in contact {_contact_share(run)} of the time.{force}"


def _period_text(run: Run) -> str:
    if run.motion.period:
        return _COUNTS.get(run.motion.period, f"{run.motion.period} periods")
    if run.motion.near_period:
        return f"Nearly {_COUNTS[run.motion.near_period].lower()} (scatter of ξ₂ σ = {run.motion.scatter:.2g})"
    return "No period: the motion does not repeat"


def _impact_rate(run: Run) -> str:
    rate = run.motion.impacts_per_period
    noun = "impact" if run.response.method.name == "reference" else "contact"
    return f"{rate:.3g} {noun}{'' if rate == 1 else 's'}"


def _contact_share(run: Run) -> str:
    share = 100 * run.motion.contact_share
    if share == 0:
        return "no part" if run.response.method.name != "reference" else "0 %"
    return f"{share:.2g} %" if share < 10 else f"{share:.0f} %"


def sentence(text: str) -> str:
    """``text`` with a capital letter and a full stop."""
    text = text.strip()
    return text[:1].upper() + text[1:] + ("" if text.endswith(".") else ".")
