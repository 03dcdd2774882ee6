"""Words for how stable a periodic motion is: its largest Floquet multiplier, and how fast a run leaves it."""

import math

from vibroscope.engine.wording import every

_EXACT = 1e-12  # size of the errors with which a run begins, in displacements: what an unstable motion enlarges


def multiplier_words(multiplier: complex) -> str:
    """A Floquet multiplier; of a pair, both."""
    if not math.isfinite(abs(multiplier)):
        return "∞"
    real = f"{multiplier.real:.4g}".replace("-", "−")
    return real if abs(multiplier.imag) < 1e-9 else f"{real} ± {abs(multiplier.imag):.4g}i"


def stability_words(largest: complex, period: int) -> str:
    """Whether a motion is stable by its largest multiplier, and how fast a run leaves it."""
    size, shown = abs(largest), multiplier_words(largest)
    if not math.isfinite(size):
        return "at the edge of an impact, where a small deviation has no bounded effect (multiplier ∞)."
    if size < 1:
        return f"stable (largest multiplier {shown})."
    if size < 1 + 1e-6:
        return f"at the edge of its stability (largest multiplier {shown})."
    periods = max(period, round(-math.log(_EXACT) / math.log(size) * period))
    left = f"after about {periods:,} excitation periods" if periods < 2000 else "very slowly"
    grows = f"a small deviation grows {size:.3g}-fold {every(period)}"
    return f"unstable (largest multiplier {shown}): {grows}, and a run that begins on it leaves it {left}."
