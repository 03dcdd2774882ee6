"""What the solvers found, in plain words; and, a moment later, what the difference is made of and what to change."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from vibroscope.app.explorer.compute import Frame, Run
from vibroscope.app.explorer.present import TIME_POINTS, WINDOW
from vibroscope.app.explorer.state import print_number
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
class Told:
    """What is told at once: what each solver found, and what it cost.

    Attributes
    ----------
    reference, penalty : str
        A line each.
    cost : tuple of (str, str, str)
        Label, value, and what is meant.
    """

    reference: str
    penalty: str
    cost: tuple[tuple[str, str, str], ...]


@dataclass(frozen=True)
class Meaning:
    """What the difference is made of, and what to change first; it takes a few more runs.

    Attributes
    ----------
    verdict : str
        Short sentences.
    agree : str
        "yes", "partly", "no" or "unknown".
    parts : dict of str to float
        Relative rms of the difference of the displacements: ``total``, ``time_step``, ``regularisation`` and
        ``joint_damping``; empty where the motions do not keep step, so that no difference at an instant means anything.
    change : dict of str to str
        What to set first, as texts that `app.explorer.state.read` takes; empty if no number mends it.
    details : tuple of str
        The numbers behind the verdict.
    series : dict of str to (2, n) ndarray
        The same parts of ξ₁ and ξ₂ as they vary over the last ``WINDOW`` periods, evenly spaced, both ends included.
    """

    verdict: str
    agree: str
    parts: dict[str, float]
    change: dict[str, str]
    details: tuple[str, ...]
    series: dict[str, np.ndarray]


def lines(told: Told, meaning: Meaning | None) -> dict[str, str]:
    """All lines by their headings."""
    first = {"Do they agree?": " ".join((meaning.verdict, *meaning.details))} if meaning else {}
    return first | {"Reference": told.reference, "Penalty": told.penalty}


def tell(frame: Frame) -> Told:
    """What is told of a frame at once."""
    scale = frame.setting.scale
    return Told(_found(frame.reference, scale), _found(frame.penalty, scale), _cost(frame))


def explain(frame: Frame, cancelled: Callable[[], bool] | None = None) -> Meaning:
    """What a frame means; raises `engine.Cancelled` if it is withdrawn."""
    setting = frame.setting
    at_hand = [run.response for run in (frame.reference, frame.penalty)]
    found = compare(
        setting.system,
        setting.eta,
        setting.penalty,
        reference=setting.reference,
        responses=at_hand,
        cancelled=cancelled,
    )
    told = verdict(found, cancelled=cancelled)
    parts = {name: getattr(found, name) for name in ("total", *PARTS)}
    known = {name: value for name, value in parts.items() if math.isfinite(value)} if found.pointwise else {}
    series = {name: _last_periods(found, getattr(found.parts, name)[:2]) for name in known}
    return Meaning(told.headline + _apart(found), told.agree, known, _texts(told.change), told.details, series)


def _apart(found: Comparison) -> str:
    """A motion of several periods may begin with any of them; what is compared in step is drawn as it came."""
    shift = found.parts.shifts.reference if found.pointwise else 0
    if not shift:
        return ""
    apart = f"{_COUNTS.get(shift, str(shift)).lower()}{'' if shift <= len(_COUNTS) else ' periods'}"
    return f" They are drawn {apart} apart, and compared in step."


def _last_periods(found: Comparison, rows: np.ndarray) -> np.ndarray:
    """The last periods of rows that are sampled over all kept ones, (2, n)."""
    tail = rows[:, -WINDOW * (rows.shape[1] // found.runs.reference.keep) :]
    old = np.arange(tail.shape[1]) * WINDOW / tail.shape[1]
    new = np.linspace(0, WINDOW, TIME_POINTS)
    return np.stack([np.interp(new, old, row) for row in tail]).astype(np.float32)


def _texts(change: dict[str, float | bool]) -> dict[str, str]:
    """What the verdict would change, as the controls take it."""
    texts = {}
    for name, value in change.items():
        if name == "located":
            texts[name] = "yes" if value else "no"
        else:
            texts[name] = print_number(round(value) if name == "steps" else float(f"{value:.3g}"))
    return texts


def _cost(frame: Frame) -> tuple[tuple[str, str, str], ...]:
    reference, penalty = frame.reference.response, frame.penalty.response
    times = (
        f"Computing took {_milliseconds(penalty)} for the penalty run, {_milliseconds(reference)} for the reference."
    )
    paid = f"Steps that an FE code would compute one by one for these {penalty.periods} periods"
    return (
        ("FE steps", f"{penalty.cost.steps / 1e6:.3g} M", paid),
        ("penalty run", _milliseconds(penalty), times),
        ("reference run", _milliseconds(reference), times),
    )


def cause(error: BaseException) -> str:
    """What of a fault may be told: the engine's own words. All else, a path among them, is for the log alone."""
    return str(error) if isinstance(error, ValueError | ArithmeticError) else "a fault of the server, noted there"


def _milliseconds(response: Response) -> str:
    return (
        f"{1e3 * response.cost.seconds:.2g} ms" if response.cost.seconds < 0.0995 else f"{response.cost.seconds:.2g} s"
    )


def _found(run: Run, scale: Units | None) -> str:
    """Period, impacts per period and share of contact of one run; with a scale, its force too."""
    if not run.response.ok:
        return f"No result. {_sentence(run.response.message)}"
    force = ""
    if scale is not None and run.motion.peak_force > 0:
        force = f" Peak force {scale.physical('force', run.motion.peak_force):.3g} N."
    return f"{_period(run)}, {_impacts(run)} per period, in contact {_share(run)} of the time.{force}"


def _period(run: Run) -> str:
    if run.motion.period:
        return _COUNTS.get(run.motion.period, f"{run.motion.period} periods")
    if run.motion.near_period:
        return f"Nearly {_COUNTS[run.motion.near_period].lower()} (scatter of ξ₂ σ = {run.motion.scatter:.2g})"
    return "No period: the motion does not repeat"


def _impacts(run: Run) -> str:
    rate = run.motion.impacts_per_period
    noun = "impact" if run.response.method.name == "reference" else "contact"
    return f"{rate:.3g} {noun}{'' if rate == 1 else 's'}"


def _share(run: Run) -> str:
    share = 100 * run.motion.contact_share
    if share == 0:
        return "no part" if run.response.method.name != "reference" else "0 %"
    return f"{share:.2g} %" if share < 10 else f"{share:.0f} %"


def _sentence(text: str) -> str:
    text = text.strip()
    return text[:1].upper() + text[1:] + ("" if text.endswith(".") else ".")
