"""``vibroscope compare``: where the penalty solution leaves the reference, in parts and in words.

``vibroscope compare --alone``: the difference over each number alone, as tables.
"""

import argparse
import math
from collections.abc import Iterable, Iterator
from dataclasses import fields, replace
from textwrap import wrap

from vibroscope.app.commands.compare_measured import add_measured_options, measured_report, refuse_without_measurement
from vibroscope.app.commands.options import (
    add_both_solutions,
    add_run_length,
    default_of,
    eta_of,
    kept_periods,
    note_unused,
    reference_of,
    refuse_missing,
    stepping_of,
)
from vibroscope.app.commands.parser import Command, OneLineParser
from vibroscope.app.commands.physical_units import (
    add_units_option,
    motion_text,
    physical_motion,
    physical_part,
    settings_text,
    wanted_units,
)
from vibroscope.app.commands.report import Line, Report, Row, note, progress_line, record, watch_interrupt
from vibroscope.app.explorer.method_words import full_words, plain_motion
from vibroscope.app.explorer.state import SOLVERS
from vibroscope.engine import (
    FREE_PERIODS,
    PARTS,
    Cancelled,
    Comparison,
    ComparisonQuestion,
    Method,
    Motion,
    Regularisation,
    Status,
    System,
    TimeStepParts,
    Units,
    Verdict,
    compare,
    free_length,
    percent,
    print_statement,
    repetition,
    verdict,
    written,
)
from vibroscope.engine.divergence.alone import Alone, Curve
from vibroscope.engine.divergence.search import NEIGHBOURS
from vibroscope.engine.divergence.tolerances import WORKS
from vibroscope.engine.facts import joined
from vibroscope.engine.methods import METHOD_NUMBERS

_HEADS = {"K": "K", "D": "D", "steps": "steps a period"}
_PHYSICAL = {"K": ("stiffness", "K"), "D": ("damping", "2D")}  # name in Units.settings, which is a quantity, and symbol
_LEAST = 1e-4  # a smaller part is rounding
_RESOLVED = {"K": "10 steps in a contact, fewer above", "steps": "10 steps in a contact, fewer below"}


def alone_lines(found: Alone | None, eta: float, method: Method, units: Units | None) -> list[str]:
    """Return a table for each number: values, what each leaves, and marks; K and D in ``units``, too, if given."""
    if found is None:
        return ["", "There is nothing to search for over K, D and the step."]
    lines = []
    for name, curve in found.curves.items():
        rows = [(_HEADS[name], _unit(name, units), "left", "")]
        rows += [
            ("none" if math.isinf(v) else written(v), _physical(name, v, eta, method, units), left, mark)
            for v, left, mark in _rows(found, curve)
        ]
        widths = [max(len(row[i]) for row in rows) for i in range(3)]
        lines.append("")
        for row in rows:
            cells = [cell.rjust(width) for cell, width in zip(row, widths, strict=False) if width]
            lines.append("  ".join([*cells, row[-1]]).rstrip())
    middle = f"At best: the middle of the values that leave at most {WORKS} times the least, by the median of"
    lines += ["", middle, f"{NEIGHBOURS} of each; of fewer steps only those that resolve a contact."]
    if found.floor > _LEAST:
        lines += ["", f"The joint damping makes {percent(found.floor)}: no K, D or step mends that."]
    return lines


def _rows(found: Alone, curve: Curve) -> Iterator[tuple[float, str, str]]:
    """Value, what it leaves, and marks, by ascending values; inf steps are none."""
    left = dict(zip(curve.values.tolist(), curve.left.tolist(), strict=True))
    better = "" if curve.best is not None else f"; no value leaves less together with {NEIGHBOURS}"
    marks: dict[float, list[str]] = {curve.present: [f"present{better}"]}
    left[curve.present] = found.total
    if curve.best is not None:
        left[curve.best.value] = curve.best.left
        marks.setdefault(curve.best.value, []).append("at best")
    for value, words in ((curve.equal, "equal restitution"), (curve.resolved, _RESOLVED.get(curve.name, ""))):
        if math.isfinite(value):
            marks.setdefault(value, []).append(words)
    for value in sorted({*left, *marks}):
        text = "" if value not in left else percent(left[value]) if math.isfinite(left[value]) else "ended early"
        yield value, text, "; ".join(marks.get(value, ()))


def _unit(name: str, units: Units | None) -> str:
    if units is None or name not in _PHYSICAL:
        return ""
    quantity, symbol = _PHYSICAL[name]
    return f"{symbol} / ({units.unit(quantity)})".replace("·", ".")


def _physical(name: str, value: float, eta: float, method: Method, units: Units | None) -> str:
    """The value in units, as the settings of a run with it have it."""
    if units is None or name not in _PHYSICAL:
        return ""
    run = replace(method, **{METHOD_NUMBERS[name]: value})
    return written(units.settings(eta, run)[_PHYSICAL[name][0]])


# The parts of the regularisation's part; the last two add up to the one before.
SPLIT = ("contact_time", "wrong_restitution", "pulling", "damper")
TIME_STEP_PARTS = ("status", "integrator")
_KEEP = default_of(ComparisonQuestion, "keep")


def add(command: OneLineParser) -> None:
    """Add the options."""
    add = command.add_argument
    add_both_solutions(command)
    usual = default_of(ComparisonQuestion, "periods")
    free = f"where nothing drives the bodies the first {FREE_PERIODS}, or those from the first contact to the second"
    add_run_length(command, f"default {usual}; {free}", _KEEP, "compare")
    add_measured_options(command)
    add("--alone", action="store_true", help="also the difference over K, over D and over the step, each alone")
    add("--series", action="store_true", help="with --json: also the difference and its parts at every sample")
    add_units_option(command)


def run(options: argparse.Namespace) -> Report:
    """Compare."""
    if options.measured is None:
        refuse_missing(options, "newmark")
    eta, system = eta_of(options), options.file.system
    if options.measured is not None:
        note_unused(options, ["series", "keep", "alone"], "with --measured")
    elif not options.json:
        note_unused(options, ["series"], "without --json")
    _set_length(options, system)
    if options.measured is not None:
        return measured_report(options, system, periods=options.periods)
    refuse_without_measurement(options)
    how = {name: getattr(options, name) for name in ("periods", "keep", "initial")}
    question = ComparisonQuestion(system, eta, stepping_of(options), reference=reference_of(options), **how)
    comparison, judgement = _compared(question)
    units, method = wanted_units(options), comparison.runs.penalty.method

    def data() -> dict:
        more = {"series": _series_json(comparison)} if options.series else {}
        more |= {"alone": judgement.alone and judgement.alone.as_dict()} if options.alone else {}
        motions = {name: physical_motion(units, getattr(comparison, name)) for name in SOLVERS} if units else {}
        return as_json(comparison, judgement) | more | physical_part(units, eta, method, **motions)

    def lines() -> Iterator[Line]:
        yield from lines_of(comparison, judgement, units)
        yield from alone_lines(judgement.alone, eta, method, units) if options.alone else ()
        yield from _physical_lines(comparison, units) if units else ()

    return Report(lines(), data, units and units.of_contact(method))


_STAGES = ("four runs", "evidence for both motions", "search over K, D and the step")
_LONG_RUN = 50_000_000  # steps: where they cannot be skipped, a run takes some seconds


def _compared(question: ComparisonQuestion) -> tuple[Comparison, Verdict]:
    """The comparison and its verdict; says beforehand what takes long, and where it is. Ctrl-C ends it."""
    per_run = question.periods * question.penalty.steps
    if per_run > _LONG_RUN:
        note(
            f"{question.periods:,} periods of {question.penalty.steps:,} steps are {per_run:,} steps in each run, and "
            "the search makes dozens of runs: it takes minutes where no steps can be skipped; fewer --periods or "
            "--steps take less; Ctrl-C ends it"
        )
    show = progress_line(lambda done: f"{'; '.join(_STAGES[: int(done) + 1])} ...", len(_STAGES)) or (lambda done: None)
    with watch_interrupt() as cancelled:
        try:
            show(0)
            comparison = compare(question, cancelled=cancelled)
            show(1)
            if not comparison.is_free:
                comparison = comparison.with_evidence(cancelled)
            show(2)
            judgement = verdict(comparison, cancelled=cancelled)
            show(3)
        except Cancelled:
            raise KeyboardInterrupt from None
    return comparison, judgement


def _splits(comparison: Comparison) -> tuple[Regularisation | None, TimeStepParts | None]:
    """The parts of K and D, and of the time step, each where it has some."""
    found = []
    for split in (comparison.split, comparison.split_time_step):
        try:
            found.append(split())
        except ValueError:  # a run ended early, or the contact law has no such parts
            found.append(None)
    return tuple(found)


def _set_length(options: argparse.Namespace, system: System) -> None:
    """Periods to run and to keep where they are not given: of a free vibration as `engine.free_length` has them."""
    if options.periods is None and not system.excitation.drives:
        length = free_length(system, options.eta, options.initial)
        options.periods, options.keep = length["periods"], options.keep or length["keep"]
    if options.periods is None:
        options.periods = default_of(ComparisonQuestion, "periods")
    if options.keep is None:
        options.keep = kept_periods(options, _KEEP) if system.excitation.drives else options.periods


# --- for scripts ------------------------------------------------------------------------------------------------------


def as_json(comparison: Comparison, judgement: Verdict) -> dict:
    """The comparison as JSON; None for what is not known."""
    split, of_step = _splits(comparison)
    words = judgement.as_dict()
    del words["alone"]  # long, and asked for by --alone
    run, method = comparison.runs.penalty, {"K": "stiffness", "D": "damping", "integrator": "integrator.name"}
    return {
        "eta": run.eta,
        **record(run.method, "steps", "located", "status", "law", **method),
        **record(run, "steps_without_solution", "steps_with_two"),
        "pointwise": comparison.pointwise,
        **_difference_json(comparison),
        "residual": comparison.residual,
        "split": split and _split_json(comparison, split),
        "split_time_step": of_step and _time_step_json(comparison, of_step),
        "impacts": _numbers(comparison.encounters),
        "statistics": _numbers(comparison.statistics),
        "reference": plain_motion(comparison.reference),
        "penalty": plain_motion(comparison.penalty),
        "verdict": words.pop("headline"),
        **words,
    }


def _difference_json(comparison: Comparison) -> dict:
    """The difference as the verdict measures it, and its parts; None for those that are not known."""
    if comparison.parts is None:
        return {"measure": None, "windows": [], **dict.fromkeys(("total", *PARTS))}
    found = comparison.difference
    return {
        "measure": found.measure,
        "total": found.total,
        "windows": list(found.windows),
        **{name: found.parts.get(name, None if name in comparison.part_names else 0.0) for name in PARTS},
    }


def _split_json(comparison: Comparison, split: Regularisation) -> dict:
    """The parts of the regularisation's part, and the restitution that the contact delivers."""
    return {
        **{name: comparison.parts.relative(getattr(split, name)) for name in SPLIT},
        **record(split, "in_step", "restitution", damping_ratio="ratio", restitution_without_pull="without_pull"),
    }


def _time_step_json(comparison: Comparison, parts: TimeStepParts) -> dict:
    """The parts of the time step's part, of the status and of the integrator."""
    sizes = {name: comparison.parts.relative(getattr(parts, name)) for name in TIME_STEP_PARTS}
    return {**sizes, "in_step": parts.in_step}


def _numbers(found) -> dict | None:
    """The plain numbers of a dataclass."""
    if found is None:
        return None
    values = record(found, *(each.name for each in fields(found)))
    return {name: value for name, value in values.items() if isinstance(value, float | int)}


def _series_json(comparison: Comparison) -> dict | None:
    """xi1, xi2, xi1', xi2' of the difference and its parts at every sample."""
    if comparison.parts is None:
        return None
    return {name: getattr(comparison.parts, name) for name in ("time", "total", *PARTS)}


# --- for people -------------------------------------------------------------------------------------------------------


def lines_of(comparison: Comparison, judgement: Verdict, units: Units | None = None) -> Iterator[Line]:
    """The comparison as text: the verdict, the parts of the difference, both motions, and the evidence."""
    penalty, reference = comparison.runs.penalty, comparison.runs.reference
    units = units and units.of_contact(penalty.method)
    yield full_words(penalty.method)
    yield f"eta = {penalty.eta:g}, against the {full_words(reference.method, wall=reference.system.wall)}"
    yield ""
    yield from wrap(print_statement(judgement.headline, units), 100)
    yield ""
    yield from columns([*part_rows(comparison, *_splits(comparison)), *_motion_rows(comparison)])
    yield ""
    for text in judgement.details:
        yield from wrap(print_statement(text, units), 100, subsequent_indent="  ")


def columns(texts: Iterable[tuple[str, str]]) -> list[Row]:
    """Labels and what they stand for, below each other."""
    texts = list(texts)
    width = max(22, *(len(label) + 2 for label, _ in texts))  # one for most comparisons; the name of a law is long
    return [Row(label, text, indent=width) for label, text in texts]


def part_rows(
    comparison: Comparison, split: Regularisation | None, of_step: TimeStepParts | None = None
) -> list[tuple[str, str]]:
    """The difference and its parts as the verdict takes them: label and share."""
    if comparison.parts is None:
        return [("difference", "not known: a run ended early")]
    found = comparison.difference
    head = {"displacements": "difference (rms)", "sections": "sections differ by"}[found.measure]
    rows = [(head, f"{found.amount}{found.certainty and f' ({found.certainty})'}")]
    own = {"time_step": (of_step, TIME_STEP_PARTS), "regularisation": (split, SPLIT)}
    for name, share in found.parts.items():
        rows.append((f"  {found.name(name)}", percent(share)))
        parts, names = own.get(name, (None, ()))
        if parts is not None and parts.in_step and found.measure == "displacements":
            sizes = ((part, comparison.parts.relative(getattr(parts, part))) for part in names)
            known = ((part, size) for part, size in sizes if not math.isnan(size))
            rows += [(f"    {part.replace('_', ' ')}", percent(size)) for part, size in known]
    return rows


def _motion_rows(comparison: Comparison) -> list[tuple[str, str]]:
    """Both motions, which a free vibration does not repeat."""
    free = comparison.is_free
    texts = {name: "free vibration" if free else _motion_text(getattr(comparison, name)) for name in SOLVERS}
    if comparison.runs.penalty.status is Status.WITHOUT_SOLUTION:
        texts["penalty"] = "not known: stopped at a step without a solution"
    return list(texts.items())


def _motion_text(motion: Motion) -> str:
    rate = f"; Lyapunov exponent {motion.lyapunov:+.3g} a period" if math.isfinite(motion.lyapunov) else ""
    return joined("", (repetition(motion), rate))


def _physical_lines(comparison: Comparison, units: Units) -> list[Line]:
    runs = comparison.runs
    texts = {"physical": settings_text(units, runs.penalty.eta, runs.penalty.method)}
    for name in () if comparison.is_free else SOLVERS:
        motion, method = getattr(comparison, name), getattr(runs, name).method
        texts[f"  {name}"] = motion_text(units, runs.penalty.eta, motion, method) or "nothing known"
    return ["", *columns(texts.items())]


COMMAND = Command(
    "difference from the reference in three parts, and which number is to blame",
    "Run the penalty solution and the reference from rest (or --initial), split their difference into what the time "
    "step, K and D, and the joint damping do, and say in words what to change first.",
    "The difference is the rms of the displacements over the kept periods, relative to the reference, in parts where "
    "all motions repeat (pointwise: true). If the reference does not repeat, it is the distance of the Poincare "
    "sections (measure: sections).",
    add,
    run,
    "one JSON object",
)
