"""The ranges that sliders and axes cover for a system; this rule stands nowhere else. No panel import.

For the paper's bodies they are the `slider` of `FIELDS`. For any other, with the springs k₁ = 1 and k₂ = μκ²:

- K from 1 to 10⁵ times the stiffer spring k;
- D from a damping ratio of the contact of 0.05 at the softest K to 0.5 at the stiffest: D = ζ·√(Kμ/(1+μ))
  (docs/theory/model.md);
- η from a quarter of the lower natural frequency to 5/3 of the upper one, at least to six times the lower one: against
  a wall without clearance a body swings at twice its frequency, and may do so in every third period of the excitation.
"""

from __future__ import annotations

import math

from vibroscope.app.explorer.parameters import FIELDS
from vibroscope.engine import System
from vibroscope.engine.contact import damping_for

Range = tuple[float, float]

_STIFFNESS = (1.0, 1e5)  # times the stiffer spring
_DAMPING_RATIOS = (0.05, 0.5)  # at the softest and at the stiffest contact
_ETA_BELOW, _ETA_ABOVE, _ETA_LEAST = 0.25, 5 / 3, 6.0
_DIGITS = 3  # of an end
_LEAST = 1e-6  # of a range: a logarithmic axis has no 0
_PAPER = System()


def slider_range(name: str, system: System) -> Range:
    """First and last value that the slider of a number covers, within what the number may be."""
    field = FIELDS[name]
    if _has_papers_bodies(system) or name not in _RULES:
        return field.slider or field.bounds
    low, high = field.bounds
    first, last = (float(f"{end:.{_DIGITS}g}") for end in _RULES[name](system))
    return max(low, first), min(high, last)


def widened(usual: Range, value: float) -> Range:
    """A range, as far as the decade of a value outside it: of K or D, whose axes are logarithmic and have no 0."""
    low, high = usual
    if value == 0 or low <= value <= high:
        return usual
    decade = math.log10(max(value, _LEAST))
    return min(low, 10.0 ** math.floor(decade)), max(high, 10.0 ** math.ceil(decade))


def _has_papers_bodies(system: System) -> bool:
    return (system.kappa, system.mass_ratio) == (_PAPER.kappa, _PAPER.mass_ratio)


def _eta_range(system: System) -> Range:
    lower, upper = min(system.frequencies), max(system.frequencies)
    return _ETA_BELOW * lower, max(_ETA_ABOVE * upper, _ETA_LEAST * lower)


def _stiffness_range(system: System) -> Range:
    spring = system.stiffer_spring
    return tuple(times * spring for times in _STIFFNESS)


def _damping_range(system: System) -> Range:
    ends = zip(_DAMPING_RATIOS, _stiffness_range(system), strict=True)
    return tuple(damping_for(system, stiffness, ratio) for ratio, stiffness in ends)


_RULES = {"eta": _eta_range, "K": _stiffness_range, "D": _damping_range}
