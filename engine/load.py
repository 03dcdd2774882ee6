"""Loads over time that are no harmonic: pulses, a sine sweep, a record of the base's acceleration or of a force.

A load is a number L(τ) of one kind: the acceleration b″ of the base, which both bodies feel as −b″, or the force f₁ or
f₂ on a body (Eqs. (1) and (2) of :mod:`.kernels.equations.motion`). It is zero before its first instant and after its
last one. Between them it is exact where it is linear in time or half a sine; a record is linear between its samples. Of
two samples at one instant the first ends what was before, and the second begins what follows: a jump.

All numbers are without dimension, as those of a system: time in 1/ω₁, accelerations in ω₁² times the unit of length,
forces in k₁ times it. A positive acceleration points towards larger ξ, as a positive force does.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from vibroscope.engine.arguments import one_of, require, shown

ON = {"base": "acceleration of the base", "force1": "force on body 1", "force2": "force on body 2"}  # what a load is
SHORTEST_LOAD, LONGEST_LOAD = 1e-6, 1e9  # of a duration, in 1/ω₁
SIZE_RANGE = (-1e12, 1e12)
SWEEP_SAMPLES = 256  # in a cycle of a sweep, linear between them: wrong by 8e-5 of its amplitude at most
CORNERS_LIMIT = 4_000_000
_PERIODIC = (
    "the load is no harmonic and has no period: `transient` runs it, and what needs a period (kind of motion, section, "
    "multipliers, diagrams, basins) does not apply to it"
)


@dataclass(frozen=True, eq=False)
class Load:
    """A load over time: :meth:`half_sine`, :meth:`trapezoid`, :meth:`sawtooth`, :meth:`sweep` or :meth:`record`.

    Attributes
    ----------
    on : {"base", "force1", "force2"}
        The acceleration of the base, or a force on body 1 or 2.
    segments : (n, 3) ndarray
        τ at the beginning of each segment, the load there, and its slope; of a pulse −L′/ω in place of the slope
        (:mod:`.kernels.event_driven.state`). From the last segment on the load is zero.
    frequency : float
        ω of a pulse L″ = −ω²L; 0 where segments are linear in time.
    words : str
        What it is, in words.
    length : float
        τ at which a run under the load ends; that of its own end unless :func:`engine.transient` goes on.

    Examples
    --------
    >>> from vibroscope.engine import Load
    >>> Load.half_sine(peak=2.0, duration=1.0)
    Load(half-sine of the acceleration of the base, to τ = 1)
    >>> Load.record([0.0, 1.0, 3.0], [0.0, 2.0, 0.0], on="force1").at([0.5, 2.0, 9.0]).tolist()
    [1.0, 1.0, 0.0]
    """

    on: str
    segments: np.ndarray
    frequency: float
    words: str
    length: float

    @classmethod
    def half_sine(cls, peak: float, duration: float, on: str = "base") -> "Load":
        """L = peak · sin(πτ/duration) for 0 ≤ τ ≤ duration."""
        peak, duration = _size("peak", peak), _duration(duration)
        segments = np.array([[0.0, 0.0, -peak], [duration, 0.0, 0.0]])
        return cls(_kind(on), segments, math.pi / duration, "half-sine", duration)

    @classmethod
    def trapezoid(cls, peak: float, duration: float, rise: float | None = None, on: str = "base") -> "Load":
        """L rises linearly to its peak, stays there, and falls as long as it rose; ``rise``: a tenth of the duration.

        A rise of 0 is a rectangle, one of half the duration a triangle.
        """
        peak, duration = _size("peak", peak), _duration(duration)
        rise = 0.1 * duration if rise is None else rise
        rise = require("rise", rise, 0.0, 0.5 * duration, "give the time to the peak, at most half of the duration")
        return cls._of_corners([0.0, rise, duration - rise, duration], [0.0, peak, peak, 0.0], on, "trapezoid")

    @classmethod
    def sawtooth(cls, peak: float, duration: float, on: str = "base") -> "Load":
        """L rises linearly to its peak at the end of the duration, and drops to zero there (terminal-peak sawtooth)."""
        peak, duration = _size("peak", peak), _duration(duration)
        return cls._of_corners([0.0, duration], [0.0, peak], on, "sawtooth")

    @classmethod
    def sweep(
        cls, amplitude: float, begin: float, end: float, duration: float, logarithmic: bool = False, on: str = "base"
    ) -> "Load":
        """L = amplitude · sin φ(τ), whose frequency φ′ goes from ``begin`` to ``end``, in units of ω₁, in the duration.

        It grows or falls linearly in time, or by equal factors in equal times. L is linear between SWEEP_SAMPLES
        samples in a cycle.
        """
        amplitude, duration = _size("amplitude", amplitude), _duration(duration)
        low, high = (require(n, v, 1e-6, 1e6, "give a frequency") for n, v in (("begin", begin), ("end", end)))
        ratio, growth = math.log(high / low), (high - low) / duration
        curved = logarithmic and ratio != 0.0
        angle = low * duration * (math.expm1(ratio) / ratio if curved else 0.5 * (1.0 + high / low))
        count = math.ceil(SWEEP_SAMPLES * angle / (2 * math.pi))
        require("samples of the sweep", count, 1, CORNERS_LIMIT, "give a shorter sweep or lower frequencies")
        phase = np.linspace(0.0, angle, count + 1)
        if curved:
            time = duration / ratio * np.log1p(phase * ratio / (low * duration))
        else:  # the root that does not cancel
            time = 2.0 * phase / (low + np.sqrt(np.maximum(low * low + 2.0 * growth * phase, 0.0)))
        return cls._of_corners(time, amplitude * np.sin(phase), on, "sine sweep")

    @classmethod
    def record(cls, time: Sequence[float], value: Sequence[float], on: str = "base", words: str = "record") -> "Load":
        """L of samples, linear between them; ``time`` does not fall, and two samples of one time are a jump.

        Raises
        ------
        ValueError
            If there are fewer than two samples, or a number is none or out of range.
        """
        return cls._of_corners(time, value, on, words)

    @classmethod
    def _of_corners(cls, time: Sequence[float], value: Sequence[float], on: str, words: str) -> "Load":
        time, value = _numbers("time", time), _numbers("value", value)
        if time.ndim != 1 or time.shape != value.shape or not 2 <= len(time) <= CORNERS_LIMIT:
            raise ValueError(
                f"give as many values as times, 2 to {CORNERS_LIMIT:,}, and not {value.shape} to {time.shape}"
            )
        known = np.isfinite(time) & np.isfinite(value) & (np.abs(value) <= SIZE_RANGE[1])
        known[1:] &= np.diff(time) >= 0.0
        if not known.all() or time[0] < 0.0:
            at = 0 if time[0] < 0.0 else int(np.argmin(known))
            raise ValueError(
                f"sample {at + 1}, {value[at]:g} at {time[at]:g}, has no place: give numbers, at times from 0 on that "
                "do not fall"
            )
        _duration(float(time[-1]))
        own = np.flatnonzero(np.diff(time) > 0.0)
        slope = np.diff(value)[own] / np.diff(time)[own]
        segments = np.column_stack([time[own], value[own], slope])
        before = np.zeros((int(time[0] > 0.0), 3))
        return cls(_kind(on), np.vstack([before, segments, [[time[-1], 0.0, 0.0]]]), 0.0, words, float(time[-1]))

    @property
    def end(self) -> float:
        """τ from which on the load is zero."""
        return float(self.segments[-1, 0])

    @cached_property
    def peak(self) -> float:
        """The largest |L|."""
        if self.frequency > 0.0:
            return float(np.abs(self.segments[:, 2]).max())
        lengths = np.diff(self.segments[:, 0], append=self.end)
        return float(np.abs([self.segments[:, 1], self.segments[:, 1] + self.segments[:, 2] * lengths]).max())

    @cached_property
    def jumps(self) -> np.ndarray:
        """The instants at which the load jumps."""
        time = self.segments[:, 0]
        return time[self._side(time, "right") != self._side(time, "left")]

    def at(self, time: Sequence[float]) -> np.ndarray:
        """The load at instants τ; where it jumps the mean of both sides, but at τ = 0 what follows."""
        time = np.asarray(time, dtype=float)
        after = self._side(time, "right")
        return np.where(time > 0.0, 0.5 * (after + self._side(time, "left")), after)

    def after(self, time: Sequence[float]) -> np.ndarray:
        """The load at instants τ; where it jumps what follows."""
        return self._side(np.asarray(time, dtype=float), "right")

    def _side(self, time: np.ndarray, side: str) -> np.ndarray:
        place = np.searchsorted(self.segments[:, 0], time, side=side) - 1
        begin, load, slope = self.segments[np.maximum(place, 0)].T
        if self.frequency > 0.0:
            angle = self.frequency * (time - begin)
            found = load * np.cos(angle) - slope * np.sin(angle)
        else:
            found = load + slope * (time - begin)
        return np.where(place >= 0, found, 0.0)

    def scaled(self, time: float, size: float) -> "Load":
        """The load with all times and all its values multiplied."""
        factors = time, size, size if self.frequency > 0.0 else size / time
        return replace(
            self, segments=self.segments * factors, frequency=self.frequency / time, length=self.length * time
        )

    def check_period(self, period: float) -> None:
        """Refuse what is no run of :func:`engine.transient`, whose only period is as long as the run."""
        if not math.isclose(period, self.length, rel_tol=1e-12):
            raise ValueError(_PERIODIC)

    def __repr__(self) -> str:
        return f"Load({self.words} of the {ON[self.on]}, to τ = {self.end:g})"


def quantity_of(on: str) -> str:
    """What a load has the dimension of: an acceleration, or a force."""
    return ON[on].partition(" ")[0]


def refuse_period() -> None:
    """Refuse a run over periods of a system whose load has none."""
    raise ValueError(_PERIODIC)


def _numbers(name: str, values: Sequence[float]) -> np.ndarray:
    try:
        return np.array(values, dtype=float)
    except (TypeError, ValueError, OverflowError):
        raise ValueError(f"{name} = {shown(values)} is not a sequence of numbers") from None


def _kind(on: str) -> str:
    return one_of("on", on, tuple(ON))


def _size(name: str, value: float) -> float:
    return require(name, value, *SIZE_RANGE, "give an acceleration of the base, or a force")


def _duration(value: float) -> float:
    return require("duration", value, SHORTEST_LOAD, LONGEST_LOAD, "give the time in 1/ω₁ at which the load ends")
