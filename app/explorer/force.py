"""The contact force of a motion in words. No panel import.

An impact has an impulse and no peak force. Where a contact is shorter than the samples show, the impulse is given with
its duration and its mean.
"""

import math

from vibroscope.engine import Method, Motion, Units, counted
from vibroscope.engine.units import time_text


def has_peak_force(motion: Motion) -> bool:
    """Whether a peak force has a meaning: not where the bodies meet in impacts alone."""
    return not (motion.peak_force == 0 and motion.impacts_per_period > 0)


def plain_motion(motion: Motion) -> dict:
    """A motion as JSON without dimension; a peak force that has no meaning is None."""
    return motion.as_dict() | ({} if has_peak_force(motion) else {"peak_force": None})


def force_text(units: Units, eta: float, motion: Motion, method: Method) -> str:
    """Peak force, or what takes its place; empty without contact.

    Where the motion does not repeat itself in the periods that have samples, others may have a higher one, and that is
    said.
    """
    impulse = f"impulse {units.text('impulse', motion.impulse)} per period"
    if math.isnan(motion.peak_force):
        duration = motion.contact_share * 2 * math.pi / eta
        if not duration > 0:
            return ""
        mean = units.text("force", motion.impulse / duration)
        lasts = time_text(units.physical("time", duration))
        return f"contacts too short to sample a peak force: {impulse} in {lasts} of contact, mean {mean}"
    peak = f"peak force {units.text('force', motion.peak_force)}" if motion.peak_force > 0 else ""
    if peak and not 0 < motion.period <= motion.sampled:
        peak += f" in {counted(motion.sampled, 'period')}"
    if method.rigid and motion.impacts_per_period > 0:
        where = f"{peak} in permanent contact; " if peak else ""
        return f"{where}impacts have an impulse and no peak force: {impulse}"
    return peak
