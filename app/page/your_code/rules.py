"""The table of rules of thumb with small phase plots, and the input of the code that is chosen."""

import math
from collections.abc import Callable, Sequence

import numpy as np
import param
from vibroscope.app.codes.rules import AS_SET, ENDED
from vibroscope.app.explorer.field_units import shown_field, shown_text
from vibroscope.app.explorer.state import Setting
from vibroscope.app.page.shared.component import Component
from vibroscope.app.studies.your_code import Judged
from vibroscope.engine import METHOD_NUMBERS, counted, percent

WIDTH, HEIGHT = 96, 64  # of a small picture
_EDGE = 0.06  # of it that stays empty on each side


class RulesTable(Component):
    """Sends ``{"set": key}``; draws ``code``, ``rows`` and ``reference``."""

    code = param.Dict(
        default={}, doc="name, units, lines, leaves_out, sources of the code that is chosen; empty if none is"
    )
    reference = param.String(default="", doc="phase plot of the reference as an SVG path")
    rows = param.List(default=[], doc="the setting, then the rules that are judged: see `rows_of`")

    script = "your_code/rules"
    sheets = ("shared/scroll_cue",)

    def __init__(self, on_set: Callable[[str], None]) -> None:
        super().__init__(sizing_mode="stretch_width")
        self.listen(set=(str, on_set))


def rows_of(judged: Sequence[Judged], reference: np.ndarray, marked: Sequence[str], setting: Setting) -> dict:
    """The parameters of the table.

    Parameters
    ----------
    judged : sequence of Judged
    reference : (2, n) ndarray
        Phase plot of the reference; all small pictures have its range, widened to hold the widest solution.
    marked : sequence of str
        Keys of the rules of the code that is chosen, which come first.
    setting : Setting
        In its units numbers and sentences are written.
    """
    judged = sorted(judged, key=lambda each: (each.outcome.rule is not AS_SET, each.outcome.rule.key not in marked))
    span = _span([reference, *(each.orbit for each in judged)], reference)
    return {
        "reference": _path(reference, span),
        "rows": [_row(each, span, marked, setting) for each in judged],
    }


def _row(judged: Judged, span: np.ndarray, marked: Sequence[str], setting: Setting) -> dict:
    found, rule = judged.outcome, judged.outcome.rule
    numbers = []
    if found.method is not None:
        # No damping: it follows from the restitution, as some laws have it.
        given = {name: found.method.numbers[name] for name in rule.gives or METHOD_NUMBERS}
        numbers = [_measure(setting, name, value) for name, value in given.items() if value is not None]
    why = shown_text(found.brief, setting.scale)
    if found.without_solution and found.motion != ENDED:
        why += f" {counted(found.without_solution, 'step')} without a solution."
    why = f"{why} {found.contact}".strip()
    return {
        "key": rule.key,
        "title": rule.title,
        "claim": rule.claim,
        "own": rule.key in marked,
        "settable": rule is not AS_SET and bool(found.motion),  # else the server would refuse it
        "numbers": numbers,
        "motion": shown_text(found.motion, setting.scale),
        "total": percent(found.total) if math.isfinite(found.total) else "",
        "holds": {True: "yes", False: "no", None: ""}[found.holds],
        "why": why,
        "source": rule.source,
        "url": rule.url,
        "path": _path(judged.orbit, span),
    }


def _measure(setting: Setting, name: str, value: float) -> str:
    """K, D or steps that a rule gives as the page shows them, with the symbol."""
    if name == "steps":
        return f"{'Δτ' if setting.scale is None else 'Δt'} = T/{value:.0f}"
    return shown_field(name, setting).words(float(f"{value:.4g}"))


def _span(orbits: Sequence[np.ndarray], reference: np.ndarray) -> np.ndarray:
    """Least and largest displacement and velocity, (2, 2): at most 1.6 times what the reference has."""
    held = [orbit for orbit in orbits if orbit.shape[1]]
    if not held:
        return np.array([[-1.0, 1.0], [-1.0, 1.0]])
    every = np.concatenate(held, axis=1)
    span = np.stack([every.min(axis=1), every.max(axis=1)], axis=1)
    if reference.shape[1]:
        low, high = reference.min(axis=1), reference.max(axis=1)
        middle, half = (low + high) / 2, 0.8 * np.maximum(high - low, 1e-12)
        span = np.stack([np.maximum(span[:, 0], middle - half), np.minimum(span[:, 1], middle + half)], axis=1)
    return np.where(span[:, 1:] > span[:, :1], span, span + np.array([-1.0, 1.0]))


def _path(orbit: np.ndarray, span: np.ndarray) -> str:
    """An orbit as an SVG path in a box of `WIDTH` by `HEIGHT`."""
    if not orbit.shape[1]:
        return ""
    share = (orbit - span[:, :1]) / (span[:, 1:] - span[:, :1])
    share = _EDGE + (1 - 2 * _EDGE) * np.clip(share, -0.1, 1.1)
    x, y = np.round(WIDTH * share[0], 1), np.round(HEIGHT * (1 - share[1]), 1)
    return "M" + "L".join(f"{a:g} {b:g}" for a, b in zip(x.tolist(), y.tolist(), strict=True))
