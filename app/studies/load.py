"""Both solutions under a pulse, a sweep or a record, from the start that is set; shock response. No panel import."""

import math
from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from typing import NamedTuple

import numpy as np
from vibroscope.app.explorer.load_words import words_of_contact
from vibroscope.app.explorer.present import envelope
from vibroscope.app.explorer.state import SOLVERS
from vibroscope.app.runtime.cache import Cache
from vibroscope.engine import (
    PEAKS,
    Difference,
    Load,
    Method,
    Reference,
    System,
    TimeStepping,
    Transient,
    Units,
    parse_record,
    shock_response,
    transient,
    transient_difference,
)
from vibroscope.engine.arguments import Poll
from vibroscope.engine.facts import Statement, message_of

RATIOS = np.geomspace(0.1, 10.0, 41)  # natural frequencies of the shock response, in units of that of body 1
COLUMNS = PEAKS | {  # of tables: what they are
    **{"tau": "time", "ratio": "frequency", "displacement": "displacement", "displacement_without": "displacement"},
    **{"acceleration": "acceleration", "acceleration_without": "acceleration"},
}
_AT_ONCE = 8  # of these between two pictures
_BINS = 1500  # of a curve that is drawn
_REFERENCE, _BOTH = 0.1, 0.5  # of the work is done then
_RECORDS = Cache(4)  # loads of files


class Pulse(NamedTuple):
    """A pulse or a sweep by its numbers, without dimension; those that its kind does not have are None."""

    kind: str  # the name of the function of `Load` that makes it
    on: str
    numbers: tuple[float | None, ...]

    def load(self) -> Load:
        """Raises ValueError where a number is out of its range."""
        return getattr(Load, self.kind)(*self.numbers, on=self.on)


class RecordFile(NamedTuple):
    """A file with a record."""

    name: str
    content: bytes
    on: str
    units: Units
    physical: bool  # as `engine.read_record` has it

    def load(self) -> Load:
        """Raises ValueError where the file holds no record."""
        return _RECORDS.get_or(self, lambda: parse_record(self.content, self.units, self.on, self.physical))

    @property
    def in_units(self) -> bool:
        """Whether it can be read beside a system in physical units."""
        try:
            self._replace(physical=True).load()
        except ValueError:
            return False
        return True


class LoadQuestion(NamedTuple):
    """Everything that the runs depend on."""

    system: System
    source: Pulse | RecordFile
    reference: Reference
    penalty: TimeStepping  # its steps are those of 2π/ω₁
    free: float
    initial: tuple[float, float, float, float] | None

    @property
    def responds(self) -> bool:
        """Whether a shock response is asked for: of bodies with springs on a base that moves."""
        excitation = self.system.excitation
        sprung = self.system.spring1 > 0 and not excitation.constant1 and not excitation.constant2
        return self.source.on == "base" and sprung

    @property
    def responding(self) -> Method:
        """With which solver: the penalty solution without a time step."""
        return self.penalty.limit


@dataclass(frozen=True, eq=False)
class PartialRuns:
    """What is known so far.

    Attributes
    ----------
    load : Load or None
        None where there is no such load or run.
    runs : dict of str to Transient
        By solver, first the reference.
    difference : Difference or None
        Of the penalty solution and its parts.
    exact : Transient or None
        The penalty solution without a time step.
    contact : str
        What its contact alone gives of the restitution.
    ended : str or Statement
        Why there is no difference, or no run.
    response : dict of str to ndarray
        Columns of :class:`engine.ShockResponse`, of the first of `RATIOS`.
    unanswered : str or Statement
        Why it goes no further.
    curves : dict of (str, str) to (ndarray, ndarray)
        τ and a quantity of a solver, or the load, as figures draw them: least and greatest in each short while.
    share : float
    """

    question: LoadQuestion
    load: Load | None
    runs: dict[str, Transient]
    difference: Difference | None = None
    exact: Transient | None = None
    contact: str = ""
    ended: str | Statement = ""
    response: dict[str, np.ndarray] = field(default_factory=dict)
    unanswered: str | Statement = ""
    curves: dict[tuple[str, str], tuple[np.ndarray, np.ndarray]] = field(default_factory=dict)
    share: float = _REFERENCE

    def whole(self) -> list[tuple[str, Transient]]:
        """The runs that reached their end, by solver."""
        return [(solver, run) for solver, run in self.runs.items() if run.ok]

    def values(self, name: str) -> tuple[float, float]:
        """A peak of the reference and of the penalty solution; nan where it is not known."""
        known = {solver: run.peaks[name] for solver, run in self.whole()}
        return tuple(known.get(solver, math.nan) for solver in SOLVERS)

    def over_time(self) -> dict[str, dict[str, np.ndarray]]:
        """The samples of each run that reached its end."""
        return {solver: samples_of(run) for solver, run in self.whole()}

    def load_over_time(self) -> dict[str, np.ndarray]:
        """The load as it is drawn."""
        return dict(zip(("tau", "load"), self.curves["load", "load"], strict=True))


def samples_of(run: Transient) -> dict[str, np.ndarray]:
    """The columns of a run that reached its end."""
    sampled = run.response.trajectory
    displacements = {f"displacement{body}": each for body, each in enumerate(sampled.displacement, 1)}
    return {"tau": sampled.time, **displacements, "contact_force": sampled.force}


def drawn(solver: str, run: Transient) -> dict[tuple[str, str], tuple[np.ndarray, np.ndarray]]:
    """The curves of a run, if it reached its end; its peaks, which the page has no time for, are then known, too."""
    if not run.ok:
        return {}
    _ = run.peaks
    time, *columns = samples_of(run).items()
    return {(solver, name): envelope(time[1], values, _BINS) for name, values in columns}


def drawn_load(load: Load, end: float) -> tuple[np.ndarray, np.ndarray]:
    """The load at both ends of its segments and, of a half-sine, between them; ``end``: that of the run."""
    begins = np.append(load.segments[:, 0], end)
    inside = np.linspace(0.0, load.end, 201) if load.frequency else np.empty(0)
    time = np.sort(np.concatenate([begins, np.nextafter(begins[1:-1], -np.inf), inside]))
    return envelope(time, load.after(time), _BINS)


def grow_load(question: LoadQuestion, last: PartialRuns | None, cancelled: Poll) -> Iterator[PartialRuns]:
    """The reference, the penalty solution with the parts of the difference, the shock response; ends if cancelled.

    Raises `Cancelled`.
    """
    how = {"free": question.free, "initial": question.initial, "cancelled": cancelled}
    result = last
    if result is None:
        try:
            load = question.source.load()
            run = transient(question.system, load, question.reference, **how)
        except ValueError as error:  # of what was typed, or of the file
            yield PartialRuns(question, None, {}, ended=message_of(error), share=1.0)
            return
        curves = {("load", "load"): drawn_load(load, run.response.window[1])} | drawn("reference", run)
        result = PartialRuns(question, load, {"reference": run}, curves=curves)
        yield result
    given = question.system, result.load
    if result.load is not None and "penalty" not in result.runs:
        try:
            found = transient_difference(*given, question.penalty, question.reference, **how)
        except ValueError as error:
            more = {"ended": message_of(error)}
            try:
                run = transient(*given, question.penalty, **how)
            except ValueError:  # for the same reason
                run = None
        else:
            run = found.penalty
            contact = words_of_contact(result.runs["reference"], run)
            more = {"difference": found.difference, "exact": found.exact, "contact": contact}
            _ = found.exact.peaks  # which the page has no time for
        share = _BOTH if question.responds else 1.0
        if run is not None:
            more |= {"runs": result.runs | {"penalty": run}, "curves": result.curves | drawn("penalty", run)}
        result = replace(result, share=share, **more)
    yield result
    done = len(result.response.get("ratio", ()))
    while result.load is not None and question.responds and done < len(RATIOS):
        some = RATIOS[done : done + _AT_ONCE]
        try:
            more = vars(shock_response(*given, some, question.responding, cancelled=cancelled))
        except ValueError as error:  # a number is out of range beside one of these frequencies
            yield replace(result, unanswered=message_of(error), share=1.0)
            return
        response = {name: np.append(result.response.get(name, ()), values) for name, values in more.items()}
        done += len(some)
        result = replace(result, response=response, share=_BOTH + (1.0 - _BOTH) * done / len(RATIOS))
        yield result
