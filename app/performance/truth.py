"""Errors of solvers against the 60-digit solutions in ``assets/truth``."""

from __future__ import annotations

import json
import math
from functools import cache

import numpy as np
from vibroscope.app.performance.contenders import CHECKED, Contender
from vibroscope.app.runtime.files import ASSETS
from vibroscope.engine import ExactPenalty, Reference

TRUTH = ASSETS / "truth"


@cache
def solutions() -> tuple[dict, ...]:
    """The 60-digit solutions from rest: ``eta``, ``method``, and the ``state`` after `CHECKED` periods or None.

    Empty where the files are missing.
    """
    found = []
    for key, case in _cases("truth.json").items():
        law, eta, numbers = key.split("|")
        if law == "ref":
            method = Reference({"published": "table"}.get(numbers, numbers))
        else:
            method = ExactPenalty(*map(float, numbers.split(",")))
        found.append({"eta": float(eta), "method": method, "state": case["states"].get(str(CHECKED))})
    for case in _cases("hard.json").values():
        if case["system"] or any(case["initial"]) or case["periods"] < CHECKED or case["status"] != "ok":
            continue
        numbers = dict(case["method"])
        kind = {Reference.name: Reference, ExactPenalty.name: ExactPenalty}[numbers.pop("name")]
        found.append({"eta": case["eta"], "method": kind(**numbers), "state": case["states"][CHECKED - 1]})
    return tuple(found)


def _cases(name: str) -> dict:
    path = TRUTH / name
    return json.loads(path.read_text(encoding="utf-8"))["cases"] if path.is_file() else {}


def true_state(eta: float, method: Reference | ExactPenalty) -> np.ndarray | None:
    """The state after `CHECKED` periods from rest, (4,); None where there is no 60-digit solution."""
    for case in solutions():
        if case["eta"] == eta and case["method"] == method and case["state"] is not None:
            return np.array([float(x) for x in case["state"]])
    return None


def state_error(contender: Contender, truth: np.ndarray | None) -> float | None:
    """Largest difference from the truth after `CHECKED` periods; None where there is no truth or no result."""
    if truth is None:
        return None
    error = float(np.abs(contender.solve(CHECKED)[1] - truth).max())
    return error if math.isfinite(error) else None
