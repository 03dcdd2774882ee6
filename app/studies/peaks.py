"""What an analyst reads off both solutions, from one sampled run each. No panel import."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from vibroscope.app.explorer.compute import free_text, run_length
from vibroscope.app.explorer.state import SOLVERS
from vibroscope.engine import (
    PEAKS,
    Method,
    Record,
    Reference,
    Response,
    Spectrum,
    System,
    TimeStepping,
    peaks,
    percent,
    simulate,
    spectrum,
    transmissibility,
)
from vibroscope.engine.arguments import Poll
from vibroscope.engine.facts import Statement

PERIODS = 16  # lines of the spectrum at sixteenths of an order
PER_PERIOD, FEW = 4000, 400  # samples: for the peak of a short contact; for the first order
MOTIONS = ("displacement1", "displacement2", "acceleration1", "acceleration2")  # with a spectrum, as has the force


def sampled(
    system: System,
    eta: float,
    method: Method,
    initial: Sequence[float] | None = None,
    samples: int = PER_PERIOD,
    cancelled: Poll | None = None,
) -> Response:
    """The last periods of a run; of a free vibration the first ones, since it decays. Raises as `simulate`."""
    length = run_length(system, eta, initial)
    record = record_of(length, samples)
    return simulate(system, eta, method, initial=initial, record=record, cancelled=cancelled, **length)


def record_of(length: Mapping[str, int], samples: int = PER_PERIOD) -> Record:
    """The samples of a run of `run_length`: no more of many periods than of PERIODS, but FEW in each."""
    keep = length.get("keep", PERIODS)
    return Record(keep, max(FEW, samples * PERIODS // max(keep, PERIODS)))


def kept_text(system: System, eta: float, initial: Sequence[float] | None) -> str:
    """Over which periods :func:`sampled` looks."""
    return f"the last {PERIODS} periods" if system.excitation.drives else free_text(system, eta, initial)


class PeaksQuestion(NamedTuple):
    """Everything that the numbers depend on."""

    system: System
    eta: float
    reference: Reference
    penalty: TimeStepping
    initial: tuple[float, float, float, float]


class Read(NamedTuple):
    """What was read off one run; without a spectrum where the run ended early."""

    peaks: dict[str, float]  # by the names of `engine.PEAKS`; nan where there is none
    spectrum: Spectrum | None
    transmissibility: np.ndarray  # (2,); nan where the base does not move
    ended: str | Statement  # why the run ended early; empty if it did not

    @property
    def amplitudes(self) -> dict[str, np.ndarray]:
        """The columns of the spectrum: order, those of `MOTIONS`, contact_force; none without a spectrum."""
        if self.spectrum is None:
            return {}
        found = [*self.spectrum.displacement, *self.spectrum.acceleration]
        columns = dict(zip(MOTIONS, found, strict=True))
        return {"order": self.spectrum.order, **columns, "contact_force": self.spectrum.force}


@dataclass(frozen=True, eq=False)
class PartialPeaks:
    """What is known so far, by the name of the solver: first the reference, then the penalty solution."""

    question: PeaksQuestion
    found: dict[str, Read] = field(default_factory=dict)

    @property
    def share(self) -> float:
        """The share of the runs that are done."""
        return len(self.found) / 2

    def values(self, name: str) -> tuple[float, float]:
        """A peak of the reference and of the penalty solution; nan where it is not known."""
        return tuple(self.found[solver].peaks[name] if solver in self.found else np.nan for solver in SOLVERS)


def off_text(reference: float, penalty: float) -> str:
    """How far a peak of the penalty solution is off, with its sign; empty where there is no such number."""
    if not (np.isfinite([reference, penalty]).all() and reference):
        return ""
    off = (penalty - reference) / reference
    text = percent(abs(off))
    return text if text == percent(0.0) else f"{'+' if off > 0 else '-'}{text}"


def difference_text(name: str, values: Sequence[float], struck: bool) -> str:
    """How far a peak is off, as :func:`off_text`.

    Where the reference has impacts (``struck``), its force is that of permanent contact alone and not compared.
    """
    return "" if struck and name == "contact_force" else off_text(*values)


def has_impacts(reference: Mapping[str, float]) -> bool:
    """Whether the reference has impacts, by its peaks: their acceleration is not finite."""
    return bool(np.isnan(reference["acceleration1"]) and np.isfinite(reference["displacement1"]))


def impacts_note(reference: Mapping[str, float]) -> str:
    """Why the reference has no acceleration and which force it has; empty where it has no impacts, or no peaks."""
    if not has_impacts(reference):
        return ""
    force = "; its contact force is that of permanent contact" if np.isfinite(reference["contact_force"]) else ""
    return f"An impact of the reference has no duration: its acceleration and force are not finite{force}."


def read_off(response: Response) -> Read:
    """The numbers of a sampled run."""
    if not response.ok:
        return Read(dict.fromkeys(PEAKS, np.nan), None, np.full(2, np.nan), response.ending)
    return Read(peaks(response), spectrum(response), transmissibility(response), "")


def grow_peaks(question: PeaksQuestion, last: PartialPeaks | None, cancelled: Poll) -> Iterator[PartialPeaks]:
    """What is known after each run. Raises `Cancelled`."""
    result = last or PartialPeaks(question)
    for solver in SOLVERS[len(result.found) :]:
        run = sampled(question.system, question.eta, getattr(question, solver), question.initial, cancelled=cancelled)
        result = PartialPeaks(question, result.found | {solver: read_off(run)})
        yield result
