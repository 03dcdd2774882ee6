"""The published problems by the keys that assets/validation/cases.toml has: each yields (what, figure)."""

from published.driven_body import b2, b2_displacements, b2_step, b2_twin
from published.problems import (
    b1,
    b3,
    b5,
    b5_two,
    backlash,
    bounces,
    contraction,
    grazing,
    orbit,
    reference_fmu,
    restitution,
    sdnd105,
    sdnd108,
    sdnd122,
    sticking,
)

__all__ = ["CASES"]

CASES = {
    "B1": b1,
    "B2": b2,
    "B2-step": b2_step,
    "B2-twin": b2_twin,
    "B2-path": b2_displacements,
    "B3": b3,
    "B3-2.2": lambda: orbit("2.2", "0.7", "0.1", 1),
    "B3-2.6": lambda: orbit("2.6", "0.8", "-0.1", 1),
    "B3-4.2": lambda: orbit("4.2", "0.7", "0.02", 2),
    "B4": lambda: iter([("force that grazes", grazing(1, 1, "0.1"))]),
    "B5": b5,
    "B5-two": b5_two,
    "B6-0.7": lambda: iter([("force that grazes", grazing("0.7", 1, "0.1"))]),
    "B6-1.3": lambda: iter([("force that grazes", grazing("1.3", "0.5", "0.04"))]),
    "B6-2.6": lambda: iter([("force that grazes", grazing("2.6", 2, "0.2"))]),
    "SDND122": sdnd122,
    "SDND105": sdnd105,
    "SDND108": sdnd108,
    "backlash": backlash,
    "bounces": bounces,
    "FMU": reference_fmu,
    "sticking-0": lambda: sticking("0"),
    "sticking-0.5": lambda: sticking("0.5"),
    "contraction": contraction,
    "restitution": restitution,
}
