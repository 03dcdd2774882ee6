"""Comparison of a penalty solution with the reference: how far it is from it, and what the difference consists of.

Of motions that do not repeat in step the distributions of the Poincaré sections are compared. Two chaotic motions
separate at the rate of their Lyapunov exponent, so that their difference at an instant says nothing about either. The
distribution of the section does not depend on the initial state. Two distributions differ by their Wasserstein
distance: how far the points of one must move, on average, to become those of the other. For equally many points on a
line it is the mean of |aᵢ − bᵢ| over the sorted values. (The tests check it against scipy.stats.wasserstein_distance;
the engine does not need SciPy.) It is taken for ξ₁ and ξ₂, relative to the rms of the reference's section, from the
static equilibrium.

Finite sections of one motion differ by chance, too: by as much as neighbouring blocks of it do, less the longer they
are (:func:`.grid.chance_distance`). Blocks that follow each other show chance and not drift. That of both motions
together is the floor: a total of a few floors may be chance.
"""

from collections.abc import Iterable, Sequence
from dataclasses import KW_ONLY, dataclass, field, replace
from functools import cached_property
from html import escape

import numpy as np
from vibroscope.engine.arguments import Poll, check_fields
from vibroscope.engine.divergence.encounters import Encounters, match_encounters, mean_closing_speed
from vibroscope.engine.divergence.error import Target
from vibroscope.engine.divergence.grid import (
    PER_PERIOD,
    SECTION,
    about_rest,
    chance_distance,
    change_between,
    relative_to,
    rms,
    run_again,
    settled_length,
    wasserstein_distance,
)
from vibroscope.engine.divergence.parts import (
    PARTS,
    Difference,
    DifferenceSeries,
    PerSolution,
    Regularisation,
    TimeStepParts,
    described,
    difference_series,
    known,
    part_names,
    split_regularisation,
    split_time_step,
)
from vibroscope.engine.divergence.tolerances import CHANCE
from vibroscope.engine.methods import Reference, TimeStepping
from vibroscope.engine.model import DISPLACEMENTS, System, check_eta
from vibroscope.engine.motions.description import Motion, describe
from vibroscope.engine.motions.motion import motion
from vibroscope.engine.motions.steady import REST
from vibroscope.engine.result import Checkpoint, Record, Response, comparison_dataset
from vibroscope.engine.simulate import FARTHEST, KEEP, LONG, check_lengths, simulate


@dataclass(frozen=True)
class ComparisonQuestion:
    """The difference of a penalty solution from the reference is asked for, both from one start.

    Attributes
    ----------
    system : System
    eta : float
        Excitation frequency η = Ω/ω₁.
    penalty : TimeStepping
        Its ``limit``, the exact penalty solution, is run as well.
    reference : Reference
        By default the paper's. With derived joint damping the part of the joint damping vanishes.
    periods, keep : int
        Excitation periods to run at least, and the last of them to compare. Where the solutions are not settled by
        then, more are run, and SECTION of them are compared if the reference does not repeat itself (:mod:`.grid`).
    initial : (4,) sequence, optional
        ξ₁, ξ₁′, ξ₂, ξ₂′ at τ = 0, by default rest.
    per_period : int
        Samples per period at most; they are Newmark's own steps.

    Raises
    ------
    ValueError
        If η is out of range, or the penalty solution has no time step.

    Examples
    --------
    >>> from vibroscope.engine import ComparisonQuestion, Newmark, System
    >>> ComparisonQuestion(System(), 2.76, Newmark(12000, 18, 2000)).keep
    50
    """

    system: System
    eta: float
    penalty: TimeStepping
    _: KW_ONLY
    reference: Reference = field(default_factory=Reference)
    periods: int = LONG
    keep: int = KEEP
    initial: Sequence[float] | None = REST
    per_period: int = PER_PERIOD

    def __post_init__(self) -> None:
        check_fields(self)
        if not self.penalty.has_step:
            raise ValueError(f"{self.penalty} has no time step: compare Newmark, whose limit it is")
        object.__setattr__(self, "eta", check_eta(self.eta))
        periods, keep = check_lengths(self.periods, self.keep)
        object.__setattr__(self, "periods", periods)
        object.__setattr__(self, "keep", keep)
        object.__setattr__(self, "initial", None if self.initial is None else tuple(self.initial))

    @property
    def start(self) -> tuple[float, ...]:
        """ξ₁, ξ₁′, ξ₂, ξ₂′ at τ = 0."""
        return self.system.rest if self.initial is None else tuple(map(float, self.initial))


@dataclass(frozen=True)
class Statistics:
    """Wasserstein distances of the sections, relative to ``size``; nan where a run ended early, inf where that is 0.

    Attributes
    ----------
    total : float
        Distance of Newmark's section from the reference's.
    time_step, regularisation, joint_damping : float
        Distance between neighbours in the chain of :mod:`.parts`. Distances do not add up: the total is at most
        their sum.
    floor : float
        Distance that chance alone causes between sections of this length.
    sections : PerSolution of (SECTION, 2) ndarray
        ξ₁ and ξ₂ of each run.
    size : float
        Rms of the reference's section from the static equilibrium.
    """

    total: float
    time_step: float
    regularisation: float
    joint_damping: float
    floor: float
    sections: PerSolution[np.ndarray] = field(repr=False)
    size: float = field(repr=False)

    @property
    def chance(self) -> float:
        """The largest distance that may be chance."""
        return CHANCE * self.floor

    def total_of(self, section: np.ndarray) -> float:
        """Return the relative distance of another section, (SECTION, 2), from the reference's."""
        return _apart(section, self.sections.reference, self.size)

    @property
    def without_joint_damping(self) -> float:
        """Relative distance of Newmark's section from that of the reference with derived joint damping."""
        return _apart(self.sections.penalty, self.sections.derived, self.size)


def statistics(runs: PerSolution[Response], cancelled: Poll | None = None) -> Statistics:
    """Compare the sections of four runs over their SECTION kept periods, or as many from their checkpoints."""
    sections = PerSolution(*(_section(run, cancelled) for run in runs))
    size = rms(about_rest(sections.reference.T, runs.reference.system))

    chance = rms(np.array([chance_distance(each) for each in (sections.penalty, sections.reference)]))
    return Statistics(
        total=_apart(sections.penalty, sections.reference, size),
        time_step=_apart(sections.penalty, sections.exact, size),
        regularisation=_apart(sections.exact, sections.derived, size),
        joint_damping=_apart(sections.derived, sections.reference, size),
        floor=relative_to(chance, size),
        sections=sections,
        size=size,
    )


def _apart(one: np.ndarray, other: np.ndarray, size: float) -> float:
    """The distance of two sections relative to a size; inf if the reference always is at rest when a period ends."""
    return relative_to(wasserstein_distance(one, other), size)


def _section(run: Response, cancelled: Poll | None) -> np.ndarray:
    """Return ξ₁ and ξ₂ of the section, (SECTION, 2); nan if the run ends early."""
    if run.ok and run.keep != SECTION:
        run = run_again(run, periods=SECTION, keep=SECTION, initial=run.checkpoint, cancelled=cancelled)
    return run.section[:, DISPLACEMENTS] if run.ok else np.full((SECTION, 2), np.nan)


# What a motion with evidence takes from the kept periods, so that everything that is counted is counted in them.
COUNTS = ("impacts_per_period", "contacts_per_period", "contact_share", "permanent_per_period", "permanent_share")


@dataclass(frozen=True)
class Comparison:
    """A penalty solution beside the reference. Numbers are nan where a run that they need ended early.

    Newmark stands for whatever method with a time step was asked for.

    Attributes
    ----------
    runs : PerSolution of Response
        Newmark, exact penalty, reference with derived joint damping, reference; all of the same periods, in which the
        reference and Newmark are settled as far as is known (:mod:`.grid`).
    motions : PerSolution of Motion
        Descriptions of their kept periods.
    reference, penalty : Motion
        The reference's motion and Newmark's; of the kept periods, or after :meth:`decided` or :meth:`with_evidence`
        with evidence, but with the counts of the kept periods. Whatever says what the motions are takes these.
    pointwise : bool
        Whether all four motions repeat themselves, Newmark's but for scatter. Only then do they stay in phase with each
        other, so that a difference at each instant is meaningful; otherwise ``statistics`` is. It is meaningful for a
        free vibration, too, if its first periods are kept.
    parts : DifferenceSeries or None
        The difference and its parts as time series; None if Newmark or the reference ended early.
    total, time_step, regularisation, joint_damping : float
        Rms of the displacements in each of them over the kept periods, relative to the reference's.
    residual : float
        Largest deviation of the sum of the parts from the total at any instant, in base amplitudes.
    encounters : Encounters or None
        How contacts match impacts; None unless the reference repeats itself.
    grid : Record
        Of one period of the series.
    question : ComparisonQuestion
        What was asked for: ``runs`` have more periods if the motions were not settled by then.
    """

    runs: PerSolution[Response]
    motions: PerSolution[Motion]
    reference: Motion
    penalty: Motion
    pointwise: bool
    parts: DifferenceSeries | None
    total: float
    time_step: float
    regularisation: float
    joint_damping: float
    residual: float
    encounters: Encounters | None
    grid: Record
    question: ComparisonQuestion

    def __repr__(self) -> str:
        run = self.runs.penalty
        far = f"{self.difference.measure} {self.total:.3g} apart" if self.parts and self.pointwise else ""
        which = f"{run.method.name} with the reference at eta = {run.eta:g}"
        return f"Comparison({which}: {far or 'no pointwise difference'})"

    def to_xarray(self):
        """The series as an `xarray.Dataset`: see :func:`..result.comparison_dataset`."""
        return comparison_dataset(self)

    def _repr_html_(self) -> str:
        return self.to_xarray()._repr_html_() if self.parts else escape(repr(self))

    @property
    def complete(self) -> bool:
        """Whether all four runs reached their end."""
        return all(run.ok for run in self.runs)

    @cached_property
    def statistics(self) -> Statistics | None:
        """Differences of the sections over SECTION periods; None if ``pointwise``, or without ``parts``."""
        return self._measured(None)

    def measure(self, cancelled: Poll | None = None) -> None:
        """Compute ``statistics`` now, some seconds of runs that can be cancelled; asked for later, they cannot be.

        Raises
        ------
        Cancelled
            If ``cancelled`` returned true.
        """
        if "statistics" not in vars(self):
            vars(self)["statistics"] = self._measured(cancelled)

    def _measured(self, cancelled) -> Statistics | None:
        return statistics(self.runs, cancelled) if self.parts and not self.pointwise else None

    @property
    def is_free(self) -> bool:
        """Whether nothing drives the bodies, so that the motions are free vibrations from their start."""
        return not self.runs.reference.system.excitation.drives

    def changing(self, cancelled: Poll | None = None) -> dict[str, float]:
        """How far the section of the "reference" or "penalty" moved since half of the periods, where it still moves.

        Relative to its size; only of motions that do not repeat themselves, which are run again for that.
        """
        runs = {name: getattr(self.runs, name) for name in ("reference", "penalty")}
        if self.is_free or not all(run.ok and run.keep >= SECTION for run in runs.values()):
            return {}
        moves = {name: self._moved(run, cancelled) for name, run in runs.items()}
        return {name: moved for name, moved in moves.items() if moved}

    def _moved(self, run: Response, cancelled) -> float:
        before = run_again(run, periods=run.periods // 2, keep=SECTION, initial=self.start, cancelled=cancelled)
        return change_between(before.section[:, DISPLACEMENTS], run.section[:, DISPLACEMENTS])

    @property
    def closing_speed(self) -> float:
        """The mean of the reference's impacts (:func:`.encounters.mean_closing_speed`)."""
        return mean_closing_speed(self.runs.reference)

    @property
    def reference_rests(self) -> bool:
        """Whether the reference does not move in the kept periods while the penalty solution lies elsewhere."""
        return self.parts is not None and self.parts.size == 0 and self.total == np.inf

    @property
    def part_names(self) -> tuple[str, ...]:
        """The names of its parts."""
        return part_names(self.runs.reference.system, self.runs.reference.method)

    @cached_property
    def difference(self) -> Difference:
        """The numbers that measure how far the solutions are apart; all statements take them from here.

        Raises
        ------
        ValueError
            If Newmark or the reference ended early.
        """
        if self.parts is None:
            raise ValueError("a run ended early, so that there is no difference: see the runs' messages")
        if self.motions.reference.period or self.is_free:
            parts = known({name: getattr(self, name) for name in self.part_names}) if self.pointwise else {}
            scattered = not (self.motions.penalty.period or self.is_free)
            windows = self.parts.of_windows() if scattered else ()
            return Difference("displacements", self.total, parts, law=self.runs.penalty.method.law, windows=windows)
        found = self.statistics
        parts = known({name: getattr(found, name) for name in self.part_names})
        return Difference("sections", found.total, parts, found.chance, self.runs.penalty.method.law)

    def decided(self, cancelled: Poll | None = None) -> "Comparison":
        """Add evidence to the motions whose kind the kept periods alone do not show.

        A motion that repeats itself is plain; Newmark's only if the exact penalty solution repeats after as many
        periods. Otherwise a time step may have scattered its section, or locked the scatter into a long cycle. Where
        neither motion comes near to repeating itself, nor does the exact penalty solution repeat, that is all that a
        comparison needs.

        Raises
        ------
        Cancelled
            If ``cancelled`` returned true.
        """
        described = self.motions
        plain = {
            "reference": described.reference.period > 0,
            "penalty": described.penalty.period == described.exact.period > 0,
        }
        if not (described.reference.near_period or described.penalty.near_period or described.exact.period):
            return self
        unclear = [name for name in plain if not plain[name] and getattr(self, name) is getattr(described, name)]
        runs = {name: getattr(self.runs, name) for name in unclear}
        return self._with(**self._judged(runs, cancelled))

    def _judged(self, runs: dict[str, Response], cancelled) -> dict[str, Motion]:
        """The motions of those runs that reached their ends, with evidence."""
        described = self.motions._asdict()
        return {name: self._judge(run, described[name], cancelled) for name, run in runs.items() if run.ok}

    @property
    def start(self) -> tuple[float, ...] | None:
        """The argument ``initial`` of a further run: None for rest, which may lie where no other start may."""
        return None if self.question.start == self.question.system.rest else self.question.start

    def _judge(self, run: Response, described: Motion, cancelled) -> Motion:
        """Return the motion that a run has settled to, with evidence; its counts stay those of the kept periods."""
        state, start = run.section[-1], self.start
        if run.periods > self.question.periods and np.abs(state).max() <= FARTHEST:
            start = tuple(run.system.without_penetration(state))
        judged = motion(run.system, run.eta, run.method, initial=start, cancelled=cancelled)
        return replace(judged, **{name: getattr(described, name) for name in COUNTS})

    def _with(self, **motions: Motion) -> "Comparison":
        """The comparison with other descriptions of its motions; the results for the difference stay."""
        changed = replace(self, **motions)
        cached = {name: value for name, value in vars(self).items() if name in ("statistics", "difference")}
        vars(changed).update(cached)
        return changed

    def with_evidence(self, cancelled: Poll | None = None) -> "Comparison":
        """Add multipliers and Lyapunov exponents to the reference's motion and Newmark's.

        It takes some tenths of a second where they do not repeat themselves (:func:`..motions.motion.motion`).

        Raises
        ------
        Cancelled
            If ``cancelled`` returned true.
        """
        runs = {name: getattr(self.runs, name) for name in ("reference", "penalty")}
        return self._with(**self._judged(runs, cancelled))

    def split(self, cancelled: Poll | None = None) -> Regularisation:
        """Split the regularisation into its own parts, by two more runs of the reference.

        Raises
        ------
        ValueError
            If a run ended early.
        """
        if not self.complete:
            raise ValueError("a run ended early, so that there is no regularisation to split: see the runs' messages")
        exact = self.runs.exact.method
        return split_regularisation(self.parts, exact, self.runs.derived, self.grid, self.start, cancelled)

    def split_time_step(self, cancelled: Poll | None = None) -> TimeStepParts:
        """Split the part of the time step into those of the contact status and of the integrator, by one run.

        Raises
        ------
        ValueError
            If a run ended early.
        """
        if not (self.runs.penalty.ok and self.runs.exact.ok and self.parts):
            raise ValueError("a run ended early, so that there is no time step to split: see the runs' messages")
        return split_time_step(self.parts, self.runs.penalty, self.grid, self.start, cancelled)


def compare(
    question: ComparisonQuestion, *, responses: Iterable[Response] = (), cancelled: Poll | None = None
) -> Comparison:
    """Compare a penalty solution with the reference, and split the difference into its parts.

    Parameters
    ----------
    question : ComparisonQuestion
    responses : iterable of Response
        Those of the four runs that exist already, of the same system, η, periods, keep and start, with or without
        samples.
    cancelled : callable, optional
        Polled many times a second; when it returns true the comparison is cancelled.

    Raises
    ------
    ValueError
        If a number is out of range, or a response does not belong to the four runs.
    Cancelled
        If ``cancelled`` returned true.

    Examples
    --------
    >>> from vibroscope.engine import ComparisonQuestion, Newmark, System, compare
    >>> found = compare(ComparisonQuestion(System(), 1.08, Newmark(2500, 8, 2000), periods=600, keep=60))
    >>> found.pointwise  # the motions keep step, so that displacements are compared
    True
    >>> print(f"{found.difference.total:.1%}", [f"{part:.1%}" for part in found.difference.parts.values()])
    7.9% ['0.0%', '0.2%', '7.7%']
    """
    runs = _settled_runs(question, responses, cancelled)
    system, per_period = question.system, question.per_period
    motions = PerSolution(*map(described, runs))
    if motions.reference.period > question.keep // 2:  # too late to be in step with
        motions = motions._replace(reference=describe(runs.reference, 0))
    # a reference that repeats itself only nearly has no time step that scatters it: nothing stays in phase with it
    pointwise = bool(motions.reference.period) and all(described.near_period for described in motions)
    if not system.excitation.drives:
        pointwise = all(run.ok for run in runs)
    comparable = runs.penalty.ok and runs.reference.ok
    series = difference_series(runs, motions, per_period, cancelled) if comparable else None
    period = motions.reference.period
    shift = series.shifts.reference if series else 0
    encounters = match_encounters(runs.reference, runs.penalty, period, shift) if series and period else None
    return Comparison(
        runs=runs,
        motions=motions,
        reference=motions.reference,
        penalty=motions.penalty,
        pointwise=pointwise,
        parts=series,
        **{name: series.relative(getattr(series, name)) if series else np.nan for name in ("total", *PARTS)},
        residual=series.residual if series else np.nan,
        encounters=encounters,
        grid=Record(1, per_period, question.penalty.steps),
        question=question,
    )


def compare_changed(comparison: Comparison, method: TimeStepping, cancelled: Poll | None = None) -> Difference | None:
    """Return the difference that a user gets who asks the same of another penalty method; None if a run ends early."""
    question = replace(comparison.question, penalty=method)
    known = (comparison.runs.reference, comparison.runs.derived)
    same = [run for run in known if (run.periods, run.keep) == (question.periods, question.keep)]
    found = compare(question, responses=same, cancelled=cancelled)
    return None if found.parts is None else found.difference


def _settled_runs(
    question: ComparisonQuestion, responses: Iterable[Response], cancelled: Poll | None
) -> PerSolution[Response]:
    """Return the four runs, until they are settled; those that exist are not repeated."""
    system, eta, periods, keep = question.system, question.eta, question.periods, question.keep
    penalty, reference = question.penalty, question.reference
    methods = PerSolution(penalty, penalty.limit, replace(reference, joint_damping="derived"), reference)
    known = {(response.method, periods, keep): response for response in responses}
    for response in known.values():
        asked = (system, eta, periods, keep)
        if response.method not in methods or (response.system, response.eta, response.periods, response.keep) != asked:
            raise ValueError(
                f"a response of {response.method} at eta = {response.eta:g} over {response.periods} periods, "
                f"{response.keep} kept, is none of the four that are compared: {', '.join(map(str, methods))}"
            )

    def run(name: str, *length: int) -> Response:
        key = (getattr(methods, name), *length)
        if key not in known:
            kept = {"periods": length[0], "keep": length[1], "initial": question.initial, "cancelled": cancelled}
            known[key] = simulate(system, eta, key[0], **kept)
        return known[key]

    length = settled_length(run, periods, keep) if system.excitation.drives else (periods, keep)
    return PerSolution(*(run(name, *length) for name in PerSolution._fields))


def error_from_penalty_state(comparison: Comparison, cancelled: Poll | None = None) -> float:
    """Return the error of the penalty solution against the reference that starts from the penalty's final state.

    The reference may have several motions at the same parameters. A penalty solution that agrees with one of them is
    not wrong because the reference reaches another one from rest.

    Returns
    -------
    float
        As ``total``; inf if the reference does not repeat itself from there, or a run ended early.
    """
    run = comparison.runs.reference
    if not comparison.runs.penalty.ok:
        return np.inf
    # A checkpoint, which may lie anywhere: a motion that grows may not have ended early yet.
    start = Checkpoint(
        run.system, run.eta, run.method, 0, run.system.without_penetration(comparison.runs.penalty.section[-1])
    )
    there = run_again(run, initial=start, cancelled=cancelled)
    target = Target(there) if there.ok else None
    return target.error(comparison.runs.penalty, cancelled) if target and target.periodic else np.inf
