"""The excitation of the bodies: motion of the base, harmonic and constant forces."""

import math
from dataclasses import dataclass, fields, replace
from functools import cached_property

import numpy as np
from vibroscope.engine.arguments import one_of
from vibroscope.engine.fields import Range, check_numbers, described
from vibroscope.engine.load import Load

AMPLITUDE_RANGE = (-1e6, 1e6)  # of displacements and forces
PHASE_RANGE = (-1e3, 1e3)
_AMPLITUDE = Range(*AMPLITUDE_RANGE), "give an amplitude in units of length, or of k₁ times that"
_BODY_2 = {"of_body_2": True}
_PHASE = "rad", Range(*PHASE_RANGE), "give a phase in rad"
_SIGNED = "base", "force1", "force2", "constant1", "constant2"
HELD = ("displacement", "velocity", "acceleration")  # of the base; its place is the power of η in the amplitude


@dataclass(frozen=True)
class Excitation:
    """The excitation: base motion and a force on each body, with one frequency η; all numbers are non-dimensional.

    By default the base moves as cos ητ, as in the paper. What is ``held`` keeps its amplitude where η changes: a shaker
    that is controlled to an acceleration moves the base by less at a higher frequency. The force on body i is
    forceᵢ cos(ητ + phaseᵢ) + constantᵢ; it pushes towards larger ξᵢ, so that on body 1 a positive constant closes the
    gap and on body 2 it opens it.

    Attributes
    ----------
    base, base_phase : float
        The base moves as a cos(ητ + base_phase) with a = base/ηᵖ, p = 0, 1, 2: ``base`` is the amplitude of what is
        held, in units of length, length · ω₁ or length · ω₁².
    force1, force1_phase, force2, force2_phase : float
        Harmonic forces, in units of k₁ times the length that displacements are counted in; phases in rad.
    constant1, constant2 : float
        Constant forces, such as weights.
    held : {"displacement", "velocity", "acceleration"}
        What of the base keeps its amplitude over η.
    load : Load or None
        A pulse or a record in place of the harmonic motion and forces, which :func:`engine.transient` gives.

    Raises
    ------
    ValueError
        If a value is out of range.
    """

    base: float = described(1.0, "amplitude of the base, of what is held", "length", *_AMPLITUDE)
    base_phase: float = described(0.0, "phase of its displacement", *_PHASE)
    force1: float = described(0.0, "harmonic force on body 1, towards body 2", "k1 length", *_AMPLITUDE)
    force1_phase: float = described(0.0, "phase of force1", *_PHASE)
    force2: float = described(0.0, "harmonic force on body 2, away from body 1", "k1 length", *_AMPLITUDE, **_BODY_2)
    force2_phase: float = described(0.0, "phase of force2", *_PHASE, **_BODY_2)
    constant1: float = described(0.0, "constant force on body 1, towards body 2", "k1 length", *_AMPLITUDE)
    constant2: float = described(0.0, "constant force on body 2, away from body 1", "k1 length", *_AMPLITUDE, **_BODY_2)
    held: str = described(
        HELD[0], "what of the base keeps its amplitude over eta", "text", None, words=" or ".join(HELD)
    )
    load: Load | None = None

    def __post_init__(self):
        one_of("held", self.held, HELD)
        check_numbers(self)

    def as_dict(self) -> dict[str, float | str]:
        """The numbers by name, and ``held``; a load is no number."""
        return {each.name: getattr(self, each.name) for each in fields(self) if each.name != "load"}

    def numbers(self) -> dict[str, float]:
        """The numbers by name."""
        return {name: value for name, value in self.as_dict().items() if name != "held"}

    @property
    def reversed(self) -> "Excitation":
        """The excitation with the other sign."""
        return replace(self, **{name: -getattr(self, name) for name in _SIGNED})

    @property
    def power(self) -> int:
        """The p of a = base/ηᵖ: 0, 1 or 2."""
        return HELD.index(self.held)

    def base_amplitude(self, eta: float) -> float:
        """Return a, the amplitude of the base's displacement at η."""
        return self.base / eta**self.power

    @property
    def drives(self) -> bool:
        """Whether anything that changes with time acts on the bodies."""
        return self.load is not None or any((self.base, self.force1, self.force2))

    @property
    def repeats(self) -> bool:
        """Whether what changes with time is harmonic, so that a motion under it may repeat itself."""
        return self.load is None and self.drives

    def base_motion(self, eta: float, time):
        """Displacement and velocity of the base at the instants τ, a number or an array."""
        (c, s), angle = self.harmonic("base", eta), eta * time
        return c * np.cos(angle) + s * np.sin(angle), eta * (s * np.cos(angle) - c * np.sin(angle))

    def load_at(self, name: str, eta: float, time: np.ndarray) -> np.ndarray:
        """The acceleration b″ of the base ("base") or a force ("force1", "force2") at instants τ, without constants."""
        if self.load is not None:
            return self.load.after(time) if name == self.load.on else np.zeros(len(time))
        (cosine, sine), angle = self.harmonic(name, eta), eta * time
        size = -(eta**2) if name == "base" else 1.0
        return size * (cosine * np.cos(angle) + sine * np.sin(angle))

    def harmonic(self, name: str, eta: float) -> tuple[float, float]:
        """Factors of cos ητ and sin ητ in the base motion or in a force, ``name``: "base", "force1" or "force2".

        With a :attr:`load` they are those of the load and its slope: so much motion of the base has its acceleration.
        """
        if self.load is not None:
            return (-1.0 / eta**2 if name == "base" else 1.0) * (name == self.load.on), 0.0
        cosine, sine = self._harmonics[name]
        size = eta**self.power if name == "base" else 1.0
        return cosine / size, sine / size

    @cached_property
    def _harmonics(self) -> dict[str, tuple[float, float]]:
        found = {}
        for name in ("base", "force1", "force2"):
            amplitude, phase = getattr(self, name), getattr(self, f"{name}_phase")
            turned = amplitude * math.cos(phase), -amplitude * math.sin(phase)
            found[name] = turned if phase != 0.0 else (amplitude, 0.0)
        return found
