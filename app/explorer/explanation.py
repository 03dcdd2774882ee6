"""The results in sentences: what each solver found, what their difference consists of, and what to change first."""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace

import numpy as np
from vibroscope.app.explorer.compute import RunPair, SolverRun, run_length
from vibroscope.app.explorer.contact_count import contact_count, contact_share
from vibroscope.app.explorer.errors import Refused
from vibroscope.app.explorer.field_units import shown_content, shown_text
from vibroscope.app.explorer.method_words import force_text, words_of_method
from vibroscope.app.explorer.present import contact_intervals, time_grid
from vibroscope.app.explorer.reading import read_setting
from vibroscope.app.explorer.state import SOLVERS, Setting
from vibroscope.app.runtime.number_text import print_value
from vibroscope.app.runtime.settings import current_settings
from vibroscope.engine import (
    PARTS,
    Comparison,
    ComparisonQuestion,
    Difference,
    Method,
    Motion,
    Response,
    Units,
    Verdict,
    compare,
    counted,
    finite_or_none,
    many,
    percent,
    repetition,
    verdict,
)
from vibroscope.engine.arguments import Poll
from vibroscope.engine.divergence.alone import Alone, Curve
from vibroscope.engine.divergence.sentences import change_of
from vibroscope.engine.divergence.verdict import agreement
from vibroscope.engine.facts import Statement, message_of, sentence, stated
from vibroscope.engine.motions.words import of_section

_WITHOUT_IMPACTS = {  # by the share of contact
    0.0: "Nothing touches: the bodies move as if they were alone.",
    1.0: "Permanent contact: the bodies never part.",
}
AloneFacts = dict[str, object]  # plain numbers, lists and dictionaries, without dimension
DISPLACEMENTS = "displacements, rms, relative"
_MEASURES = {"displacements": DISPLACEMENTS, "sections": "Poincaré sections, relative"}


@dataclass(frozen=True)
class Description:
    """The motion that each solver found, and its cost; known as soon as the runs are.

    Attributes
    ----------
    reference, penalty : tuple of (str, str)
        What the motion is as far as the run shows it, and with units its contact force.
    cost : tuple of (str, str, str)
        Label, value, and meaning.
    """

    reference: tuple[str, str]
    penalty: tuple[str, str]
    cost: tuple[tuple[str, str, str], ...]

    def lines(self, explanation: "Explanation | None") -> dict[str, str]:
        """A line for each solver; once there is an explanation, with the kind of motion that it speaks of."""
        kinds = explanation.kinds if explanation else {}
        lines = {"reference": self.reference, "penalty": self.penalty}
        return {name: f"{kinds.get(name, kind)} {force}".strip() for name, (kind, force) in lines.items()}


_SENTENCES = ("headline", "kinds", "details")  # of an explanation


@dataclass(frozen=True, kw_only=True)
class Explanation:
    """The parts of the difference, and the number to change first; computing it takes a few more runs.

    Attributes
    ----------
    headline : str or Statement
        Short sentences.
    agree : str
        "yes", "partly", "no" or "unknown".
    kinds : dict of str to str or Statement
        What motion the ``reference`` and the ``penalty`` show, decided with evidence where the runs leave it open;
        empty if a run ended early.
    measure : str
        What ``parts`` measure.
    parts : dict of str to float
        The difference that the headline states, ``total``, and as far as they are known its parts ``time_step``,
        ``regularisation`` and ``joint_damping``; empty if a run ended early.
    note : str
        Why there are no parts, or how much of it is chance; may be empty.
    change : dict of str to str
        What to set first, as texts for `app.explorer.reading.read_setting`; empty if no number helps.
    details : tuple of str or Statement
        The numbers behind the headline.
    series : dict of str to (2, n) ndarray
        The difference of ξ₁ and ξ₂, and its parts, over the periods that are shown, evenly spaced, both
        ends included; empty where the motions are not in phase, so that a difference at an instant means nothing.
    alone : dict or None
        The difference over each number alone, :func:`alone_facts`; None where there is nothing to search for.
    """

    headline: str
    agree: str = "unknown"
    kinds: dict[str, str] = field(default_factory=dict)
    measure: str = ""
    parts: dict[str, float] = field(default_factory=dict)
    note: str = ""
    change: dict[str, str] = field(default_factory=dict)
    details: tuple[str, ...] = ()
    series: dict[str, np.ndarray] = field(default_factory=dict)
    alone: AloneFacts | None = None

    def in_units(self, scale: Units | None) -> "Explanation":
        """The explanation as the page shows it, with the numbers of its sentences in units."""
        return replace(self, **{name: shown_content(getattr(self, name), scale) for name in _SENTENCES})


def describe(runs: RunPair) -> Description:
    """Describe both runs and their cost."""
    scale = runs.setting.scale
    return Description(_describe_run(runs.reference, scale), _describe_run(runs.penalty, scale), _cost(runs))


def explain(
    runs: RunPair,
    cancelled: Poll | None = None,
    on_judged: Callable[[str, Motion], None] = lambda name, found: None,
    on_alone: Callable[[AloneFacts], None] = lambda facts: None,
) -> Explanation:
    """Explain the difference of both runs; raises `engine.Cancelled` if ``cancelled()``.

    ``on_judged`` gets "reference" or "penalty" and its motion where the explanation needs the evidence for its kind.
    ``on_alone`` gets `Explanation.alone` as far as it is known.
    """
    setting = runs.setting
    start = setting.system, setting.eta, setting.initial
    try:
        comparison = compare(
            ComparisonQuestion(
                setting.system,
                setting.eta,
                setting.penalty,
                reference=setting.reference,
                initial=setting.initial,
                **run_length(*start),
            ),
            responses=[run.response for run in (runs.reference, runs.penalty)],
            cancelled=cancelled,
        )
    except ValueError as error:  # a law without a solution in closed form has no parts
        return Explanation(headline=stated("Not compared: {}.", message_of(error)))
    try:
        found = verdict(
            comparison,
            progress=lambda alone: on_alone(alone_facts(alone, setting)),
            threads=current_settings().threads,
            cancelled=cancelled,
        )
    except ValueError as error:
        found = _without_verdict(comparison, error)
    for name in SOLVERS:
        judged = getattr(found, name)
        if judged is not None and judged is not getattr(comparison, name):
            on_judged(name, judged)
    difference = comparison.difference if comparison.parts and math.isfinite(comparison.difference.total) else None
    in_step = ("total", *PARTS) if comparison.pointwise else ()
    change, limit = _takeable(_change_texts(found.change, setting), setting)
    return Explanation(
        headline=found.headline + _shift_note(comparison) + limit,
        agree=found.agree,
        kinds=motion_texts(runs, {name: getattr(found, name) for name in SOLVERS}),
        measure=_MEASURES[difference.measure] if difference else "",
        parts={"total": difference.total, **difference.parts} if difference else {},
        note=_parts_note(difference),
        change=change,
        details=found.details,
        series={name: _shown_periods(runs, comparison, getattr(comparison.parts, name)[:2]) for name in in_step},
        alone=found.alone and alone_facts(found.alone, setting),
    )


def alone_facts(found: Alone, setting: Setting) -> AloneFacts:
    """The difference over each number alone as `engine` gives it in plain numbers.

    ``done`` says whether the search is done, and ``set`` of each curve has the texts that set its best value, empty
    while it is not known, and where the page takes none. ``value`` of a best is the number, None for no time step.
    """
    facts = found.as_dict() | {"done": found.done}
    for name, curve in found.curves.items():
        change = _change_texts(_settable(curve, found), setting)
        facts["curves"][name]["set"], _ = _takeable(change, setting)
        if curve.best is not None:
            facts["curves"][name]["best"]["value"] = finite_or_none(curve.best.value)
    return facts


def _settable(curve: Curve, found: Alone) -> dict[str, float | bool | str]:
    """What to set for the best value of a curve; steps cut at contact stand for no step at all."""
    if curve.best is None:
        return {}
    if math.isfinite(curve.best.value):
        return change_of(curve.best)
    cut = (each for each in found.choices if each.changed == "status" and each.method.located)
    return next(map(change_of, cut), {})


def _without_verdict(comparison: Comparison, error: ValueError) -> Verdict:
    """How far the solutions agree, where the engine has no verdict for the penalty solution."""
    motions = {"reference": comparison.reference, "penalty": comparison.penalty}
    if comparison.parts is None:
        run = next(run for run in (comparison.runs.penalty, comparison.runs.reference) if not run.ok)
        return Verdict(sentence(run.message), "unknown")
    if comparison.is_free:
        agree, first = "unknown", f"The displacements differ by {percent(comparison.difference.total)} (rms)."
    else:
        agree, first = agreement(comparison)
    return Verdict(stated("{} No number is blamed: {}.", first, message_of(error)), agree, **motions)


def paragraphs(description: Description, explanation: Explanation | None) -> dict[str, str]:
    """The whole text by headings; without an explanation, what is known so far."""
    first = {}
    if explanation:
        first = {"Do they agree?": explanation.headline, "Numbers": " ".join(explanation.details)}
    lines = description.lines(explanation)
    return {head: text for head, text in first.items() if text} | {
        "Reference": lines["reference"],
        "Penalty": lines["penalty"],
    }


def _parts_note(difference: Difference | None) -> str:
    if difference is None:
        return "No number: a run ended early."
    certainty = sentence(difference.certainty) if difference.certainty else ""
    if not difference.parts:
        return (
            "Its parts are not known: they exist only where all motions compared come close to repeating in the kept "
            f"periods. {certainty}".rstrip()
        )
    return f"{certainty} The parts do not add up.".lstrip() if difference.measure == "sections" else certainty


def _shift_note(comparison: Comparison) -> str:
    """The phase by which the motions are drawn apart: one of several periods may start with any of them."""
    shift = comparison.parts.shifts.reference if comparison.pointwise else 0
    return f" They are drawn {counted(shift, 'period')} apart, and compared in step." if shift else ""


def _shown_periods(runs: RunPair, comparison: Comparison, rows: np.ndarray) -> np.ndarray:
    """The last periods, those of the figures, (2, n), of rows that are sampled over all kept periods."""
    window = runs.reference.window
    count = window * (rows.shape[1] // comparison.parts.periods)
    old, new = np.arange(count) * window / count, time_grid(window)
    return np.stack([np.interp(new, old, row) for row in rows[:, -count:]]).astype(np.float32)


def _change_texts(change: dict[str, float | bool | str], setting: Setting) -> dict[str, str]:
    """The proposed change as texts for the controls, which have a switch of their own for located steps.

    It was tried with the present K and D, which therefore no longer follow where another number is proposed.
    """
    texts = {}
    for name, value in change.items():
        if "located" in (name, value):
            texts["located"] = "yes"
        else:
            texts[name] = print_value(value)
    return setting.with_contact(texts)


def _takeable(change: dict[str, str], setting: Setting) -> tuple[dict[str, str], str]:
    """The change if the page takes it; otherwise none, and why not."""
    try:
        read_setting(change, setting)
    except Refused as error:
        return {}, f" Not on this page: {error}"
    return change, ""


def _cost(runs: RunPair) -> tuple[tuple[str, str, str], ...]:
    reference, penalty = runs.reference.response, runs.penalty.response
    times = f"Computing took {_duration(penalty)} for the penalty run, {_duration(reference)} for the reference."
    meaning = f"Steps that an FE code would compute one by one for these {penalty.periods} periods"
    return (
        ("FE steps", many(penalty.cost.steps), meaning),
        ("penalty took", _duration(penalty), times),
        ("reference took", _duration(reference), times),
    )


def _duration(response: Response) -> str:
    return (
        f"{1e3 * response.cost.seconds:.2g} ms" if response.cost.seconds < 0.0995 else f"{response.cost.seconds:.2g} s"
    )


def _describe_run(run: SolverRun, scale: Units | None) -> tuple[str, str]:
    """The motion of a run in words, and with a scale its contact force."""
    how = _stepping_text(run.response)
    if not run.response.ok:
        return "No result.", f"{shown_text(sentence(run.response.message), scale)} {how}".strip()
    method = run.response.method
    if run.response.system.excitation.drives:
        repeats = of_section(repetition(run.motion), run.motion.period, method.has_step)
        words = shown_text(_motion_text(run.motion, method, repeats), scale)
    else:
        words = _free_text(run)
    force = scale and force_text(scale, run.response.eta, run.motion, run.response.method)
    return words, " ".join(filter(None, (sentence(force) if force else "", how)))


def _stepping_text(response: Response) -> str:
    """The method of a run that is not Newmark's, and how many of its steps have no solution, or two."""
    words = words_of_method(response.method)
    if not words:
        return ""
    counts = {"without a solution": response.steps_without_solution, "with two": response.steps_with_two}
    said = ", ".join(f"{counted(count, 'step')} {what}" for what, count in counts.items() if count)
    return f"By {words}{'; ' + said if said else ''}."


def _free_text(run: SolverRun) -> str:
    """What the figures show of a free vibration."""
    spans = contact_intervals(run)
    if not len(spans["left"]):
        return f"Free vibration. {_WITHOUT_IMPACTS[0.0]}"
    number = contact_count(**spans, length=run.window, rigid=run.response.method.rigid)
    share = contact_share(**spans, length=run.window)
    return f"Free vibration. {number} in {run.window} periods T, in contact {share} of that time."


def motion_texts(runs: RunPair, motions: Mapping[str, Motion | None]) -> dict[str, str | Statement]:
    """The motions of the ``reference`` and the ``penalty`` model in words, as far as they are known.

    Of a free vibration those of the periods that are shown.
    """
    if not runs.setting.system.excitation.drives:
        return {name: _free_text(run) for name in SOLVERS if (run := getattr(runs, name)).response.ok}
    known = {name: found for name, found in motions.items() if found is not None}
    return {name: _motion_text(found, getattr(runs.setting, name), repetition(found)) for name, found in known.items()}


def _motion_text(found: Motion, method: Method, repeats: str | Statement) -> str | Statement:
    """How a motion ``repeats`` itself, its impacts per period, and its share of contact."""
    if found.impacts_per_period == 0 and found.contact_share in (0.0, 1.0):
        return sentence(repeats) + f" {_WITHOUT_IMPACTS[found.contact_share]}"
    rate = counted(found.impacts_per_period, "impact" if method.rigid else "contact")
    share = percent(found.contact_share)
    return sentence(repeats) + f" {rate} per period, in contact {share} of the time."
