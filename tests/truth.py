"""The 60-digit solutions that the engine is checked against (assets/truth/truth.json; says itself how it was made)."""

import json
from pathlib import Path

CASES = json.loads((Path(__file__).parents[1] / "assets" / "truth" / "truth.json").read_text())["cases"]


def states(case):
    """{periods: [ξ₁, ξ₁′, ξ₂, ξ₂′]}."""
    return {int(n): [float(x) for x in state] for n, state in CASES[case]["states"].items()}


def events(case):
    """[(τ, kind, gap velocity before)] of the first 10 periods."""
    return [(float(t), int(kind), float(v)) for t, kind, v in CASES[case]["events"]]
