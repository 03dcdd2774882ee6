"""What the solvers found, in plain words."""

from __future__ import annotations

from dataclasses import dataclass

from app.compute import Frame, Run
from engine import PARTS, Comparison, Response, compare

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
# Relative rms difference of both displacements; below the first two curves are one on the screen.
_SAME = 0.02
_CLOSE = 0.10
_SAMPLES = 100  # per period; more change the third digit of a difference


@dataclass(frozen=True)
class Told:
    """What is told beside the figures.

    Attributes
    ----------
    reference, penalty, verdict : str
        Lines of words.
    agree : str
        "yes", "partly", "no" or "unknown".
    parts : dict of str to float
        The relative rms difference of the displacements: ``total`` and, where they are known, its parts; empty where
        no difference at each instant means anything.
    cost : tuple of (str, str, str)
        What the runs cost: label, value, and what is meant.
    """

    reference: str
    penalty: str
    verdict: str
    agree: str
    parts: dict[str, float]
    cost: tuple[tuple[str, str, str], ...]

    def lines(self) -> dict[str, str]:
        """The lines by their headings."""
        return {"Do they agree?": self.verdict, "Reference": self.reference, "Penalty": self.penalty}

    def summary(self) -> str:
        """All in one text, for those who cannot see the figures."""
        return " ".join(f"{head} {text}" for head, text in self.lines().items())


def tell(frame: Frame) -> Told:
    """All that is told of one frame."""
    verdict, agree, parts = _verdict(frame)
    return Told(_found(frame.reference), _found(frame.penalty), verdict, agree, parts, _cost(frame))


def _cost(frame: Frame) -> tuple[tuple[str, str, str], ...]:
    reference, penalty = frame.reference.response, frame.penalty.response
    times = (
        f"Computing took {_milliseconds(penalty)} for the penalty run, {_milliseconds(reference)} for the reference."
    )
    paid = f"Steps that an FE code would compute one by one for these {penalty.periods} periods"
    return (
        ("FE steps", f"{penalty.cost.steps / 1e6:.3g} M", paid),
        ("penalty", _milliseconds(penalty), times),
        ("reference", _milliseconds(reference), times),
    )


def _milliseconds(response: Response) -> str:
    return (
        f"{1e3 * response.cost.seconds:.2g} ms" if response.cost.seconds < 0.0995 else f"{response.cost.seconds:.2g} s"
    )


def _found(run: Run) -> str:
    """Period, impacts per period and share of contact of one run."""
    if not run.response.ok:
        return f"No result. {_sentence(run.response.message)}"
    return f"{_period(run)}, {_impacts(run)} per period, in contact {_share(run)} of the time."


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


def _verdict(frame: Frame) -> tuple[str, str, dict[str, float]]:
    reference, penalty = frame.reference, frame.penalty
    if not penalty.response.ok:
        return (
            "The penalty run ended early, so there is nothing to compare: take more steps per period, or a softer K.",
            "unknown",
            {},
        )
    if not reference.response.ok:
        return "The reference did not come to its end, so there is nothing to compare.", "unknown", {}
    found = _compared(reference.response, penalty.response)
    periods = found.reference.near_period, found.penalty.near_period
    if found.pointwise and periods[0] == periods[1]:
        return *_tell_periodic(found), {name: getattr(found, name) for name in ("total", *PARTS)}
    if periods == (0, 0):
        return *_tell_irregular(found), {}
    mine, theirs = (_COUNTS[p].lower() if p in _COUNTS else f"{p} periods" if p else "no period" for p in periods)
    return f"They disagree: the penalty solution has {theirs}, the reference {mine}.", "no", {}


def _compared(reference: Response, penalty: Response) -> Comparison:
    return compare(
        reference.system,
        reference.eta,
        penalty.method,
        reference=reference.method,
        periods=reference.periods,
        keep=reference.keep,
        responses=(reference, penalty),
        per_period=_SAMPLES,
    )


def _tell_irregular(found: Comparison) -> tuple[str, str]:
    r, p = found.reference.impacts_per_period, found.penalty.impacts_per_period
    if abs(r - p) <= 0.1 * max(r, 0.1):
        return (
            "Neither repeats, so curves cannot match point by point; the numbers of impacts agree within 10 %.",
            "partly",
        )
    return "Neither repeats, and their numbers of impacts differ.", "no"


def _tell_periodic(found: Comparison) -> tuple[str, str]:
    same_impacts = abs(found.reference.impacts_per_period - found.penalty.impacts_per_period) < 0.01
    amount = f"{100 * found.total:.2g} % (rms)"
    but = "" if same_impacts else ", but not in the number of impacts"
    if found.total <= _SAME:
        return f"They agree: the displacements differ by {amount}{but}.", "yes" if same_impacts else "partly"
    if found.total <= _CLOSE:
        return f"They agree roughly: the displacements differ by {amount}{but}.", "partly"
    return f"They disagree: the period is the same, but the displacements differ by {amount}.", "no"
