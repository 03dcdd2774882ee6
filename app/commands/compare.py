"""``vibroscope compare``: where the penalty solution leaves the reference, in parts and in words."""

import argparse
import json
import math
from collections.abc import Iterable
from dataclasses import fields
from textwrap import wrap

from vibroscope.app.commands.alone_table import alone_lines
from vibroscope.app.commands.compare_measured import add_measured_options, run_measured
from vibroscope.app.commands.numbers import count
from vibroscope.app.commands.options import (
    ETA,
    add_initial_option,
    add_integrator_options,
    add_joint_damping_option,
    add_penalty_options,
    add_system_option,
    add_threshold_option,
    default_of,
    eta_of,
    reference_of,
    stepping_of,
    system_of,
)
from vibroscope.app.commands.output import note
from vibroscope.app.commands.physical_units import (
    add_units_option,
    motion_text,
    physical_motion,
    settings_text,
    unit_names,
    wanted_units,
)
from vibroscope.app.explorer.force import plain_motion
from vibroscope.app.explorer.method_words import full_words
from vibroscope.engine import (
    FREE_PERIODS,
    PARTS,
    Comparison,
    ComparisonQuestion,
    Motion,
    Regularisation,
    Status,
    System,
    TimeStepParts,
    Units,
    Verdict,
    compare,
    finite_or_none,
    percent,
    print_statement,
    repetition,
    verdict,
)

# The parts of the regularisation's part; the last two add up to the one before.
SPLIT = ("contact_time", "wrong_restitution", "pulling", "damper")
TIME_STEP_PARTS = ("status", "integrator")
_KEEP = default_of(ComparisonQuestion, "keep")


def add(commands) -> None:
    """Describe ``vibroscope compare``."""
    command = commands.add_parser(
        "compare",
        allow_abbrev=False,
        help="difference from the reference in three parts, and which number is to blame",
        description="Run the penalty solution and the reference from rest (or --initial), split their difference into "
        "what the time step, K and D, and the joint damping do, and say in words what to change first.",
        epilog="The difference is the rms of the displacements over the kept periods, relative to the reference, in "
        "parts where all motions repeat (pointwise: true). If the reference does not repeat, it is the distance of the "
        "Poincare sections (measure: sections).",
    )
    add = command.add_argument
    add("--eta", **ETA)
    add_penalty_options(command, required=True)
    add_integrator_options(command)
    usual = f"default {default_of(ComparisonQuestion, 'periods')}; where nothing drives the bodies {FREE_PERIODS}"
    add("--periods", type=count, metavar="N", help=f"excitation periods to run ({usual})")
    add("--keep", type=count, metavar="N", help=f"last periods to compare (default {_KEEP}, or all if fewer are run)")
    add_joint_damping_option(command)
    add_threshold_option(command)
    add_initial_option(command)
    add_system_option(command)
    add_measured_options(command)
    add("--alone", action="store_true", help="also the difference over K, over D and over the step, each alone")
    add("--series", action="store_true", help="with --json: also the difference and its parts at every sample")
    add_units_option(command)
    add("--json", action="store_true", help="print one JSON object")
    command.set_defaults(run=run)


def run(options: argparse.Namespace) -> None:
    """Compare and print."""
    eta, system = eta_of(options), system_of(options)
    _note_unused(options)
    _set_length(options, system)
    if options.measured is not None:
        run_measured(options)
        return
    for name in ("fit", "columns"):
        if getattr(options, name) is not None:
            raise ValueError(f"--{name} needs a measurement: give --measured FILE.csv")
    comparison = compare(
        ComparisonQuestion(
            system,
            eta,
            stepping_of(options),
            reference=reference_of(options),
            periods=options.periods,
            keep=options.keep,
            initial=options.initial,
        )
    )
    if not comparison.is_free:
        comparison = comparison.with_evidence()
    judgement = verdict(comparison)
    split, of_step = _splits(comparison)
    units = wanted_units(options)
    if options.json:
        report = as_json(comparison, judgement, split, of_step)
        if options.series:
            report["series"] = _series_json(comparison)
        if options.alone:
            report["alone"] = judgement.alone and judgement.alone.as_dict()
        if units:
            report["physical"] = _physical_json(comparison, units)
        print(json.dumps(report, allow_nan=False))
    else:
        print(
            as_text(
                comparison,
                judgement,
                split,
                of_step,
                units,
            )
        )
        if options.alone:
            print("\n".join(alone_lines(judgement.alone, eta, comparison.runs.penalty.method, units)))
        if units:
            print("\n".join(_physical_lines(comparison, units)))


def _note_unused(options: argparse.Namespace) -> None:
    """Note on stderr what has no effect on what is printed."""
    if options.series and options.measured is None and not options.json:
        note("--series has no effect without --json")
    for name in ("series", "keep", "alone") if options.measured is not None else ():
        if getattr(options, name):
            note(f"--{name} has no effect with --measured")


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
    """Periods to run and to keep where they are not given: of a free vibration the first ones, since it decays."""
    drives = system.excitation.drives
    if options.periods is None:
        options.periods = default_of(ComparisonQuestion, "periods") if drives else FREE_PERIODS
    if options.keep is None:
        options.keep = min(_KEEP, options.periods) if drives else options.periods


# --- for scripts ------------------------------------------------------------------------------------------------------


def as_json(
    comparison: Comparison, judgement: Verdict, split: Regularisation | None, of_step: TimeStepParts | None = None
) -> dict:
    """The comparison as JSON; None for what is not known."""
    run = comparison.runs.penalty
    method = run.method
    words = judgement.as_dict()
    del words["alone"]  # long, and asked for by --alone
    return {
        "eta": comparison.runs.penalty.eta,
        "K": method.stiffness,
        "D": method.damping,
        "steps": method.steps,
        "located": method.located,
        "integrator": method.integrator.name,
        "status": method.status,
        "law": method.law,
        "steps_without_solution": run.steps_without_solution,
        "steps_with_two": run.steps_with_two,
        "pointwise": comparison.pointwise,
        **_difference_json(comparison),
        "residual": finite_or_none(comparison.residual),
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
        return {"measure": None, **dict.fromkeys(("total", *PARTS))}
    found = comparison.difference
    return {
        "measure": found.measure,
        "total": finite_or_none(found.total),
        **{name: found.parts.get(name, None if name in comparison.part_names else 0.0) for name in PARTS},
    }


def _split_json(comparison: Comparison, split: Regularisation) -> dict:
    """The parts of the regularisation's part, and the restitution that the contact delivers."""
    return {
        **{name: finite_or_none(comparison.parts.relative(getattr(split, name))) for name in SPLIT},
        "in_step": split.in_step,
        "damping_ratio": finite_or_none(split.ratio),
        "restitution": split.restitution,
        "restitution_without_pull": finite_or_none(split.without_pull),
    }


def _time_step_json(comparison: Comparison, parts: TimeStepParts) -> dict:
    """The parts of the time step's part, of the status and of the integrator."""
    sizes = {name: finite_or_none(comparison.parts.relative(getattr(parts, name))) for name in TIME_STEP_PARTS}
    return {**sizes, "in_step": parts.in_step}


def _numbers(record) -> dict | None:
    """The plain numbers of a dataclass."""
    if record is None:
        return None
    values = {each.name: getattr(record, each.name) for each in fields(record)}
    return {name: finite_or_none(value) for name, value in values.items() if isinstance(value, float | int)}


def _series_json(comparison: Comparison) -> dict | None:
    """xi1, xi2, xi1', xi2' of the difference and its parts at every sample."""
    if comparison.parts is None:
        return None
    rows = {name: getattr(comparison.parts, name) for name in ("total", *PARTS)}
    return {
        "time": comparison.parts.time.tolist(),
        **{name: [[finite_or_none(value) for value in row] for row in rows[name].tolist()] for name in rows},
    }


def _physical_json(comparison: Comparison, units: Units) -> dict:
    """Settings and both motions in the units of an FE input file."""
    penalty = comparison.runs.penalty
    return {
        "units": unit_names(units, penalty.method),
        "settings": units.settings(penalty.eta, penalty.method),
        "reference": physical_motion(units, comparison.reference),
        "penalty": physical_motion(units, comparison.penalty),
    }


# --- for people -------------------------------------------------------------------------------------------------------


def as_text(
    comparison: Comparison,
    judgement: Verdict,
    split: Regularisation | None,
    of_step: TimeStepParts | None = None,
    units: Units | None = None,
) -> str:
    """The comparison as text: the verdict, the parts of the difference, both motions, and the evidence."""
    penalty, reference = comparison.runs.penalty, comparison.runs.reference
    units = units and units.of_contact(penalty.method)
    details = (print_statement(text, units) for text in judgement.details)
    rows = [*part_rows(comparison, split, of_step), *_motion_rows(comparison, units)]
    return "\n".join(
        [
            full_words(penalty.method),
            f"eta = {penalty.eta:g}, against the {full_words(reference.method, wall=reference.system.wall)}",
            "",
            *wrap(print_statement(judgement.headline, units), 100),
            "",
            *columns(rows),
            "",
            *(line for text in details for line in wrap(text, 100, subsequent_indent="  ")),
        ]
    )


def columns(rows: Iterable[tuple[str, str]]) -> list[str]:
    """Labels and what they stand for, below each other."""
    rows = list(rows)
    width = max(22, *(len(label) + 2 for label, _ in rows))  # one width for most comparisons; the name of a law is long
    return [f"{label:{width}}{text}" for label, text in rows]


def part_rows(
    comparison: Comparison, split: Regularisation | None, of_step: TimeStepParts | None = None
) -> list[tuple[str, str]]:
    """The difference and its parts as the verdict takes them: label and share."""
    if comparison.parts is None:
        return [("difference", "not known: a run ended early")]
    found = comparison.difference
    head = {"displacements": "difference (rms)", "sections": "sections differ by"}[found.measure]
    chance = f" (chance explains up to {percent(found.chance)})" if found.chance and math.isfinite(found.total) else ""
    rows = [(head, f"{percent(found.total)}{chance}")]
    own = {"time_step": (of_step, TIME_STEP_PARTS), "regularisation": (split, SPLIT)}
    for name, share in found.parts.items():
        rows.append((f"  {found.name(name)}", percent(share)))
        parts, names = own.get(name, (None, ()))
        if parts is not None and parts.in_step and found.measure == "displacements":
            sizes = ((part, comparison.parts.relative(getattr(parts, part))) for part in names)
            known = ((part, size) for part, size in sizes if not math.isnan(size))
            rows += [(f"    {part.replace('_', ' ')}", percent(size)) for part, size in known]
    return rows


def _motion_rows(comparison: Comparison, units: Units | None) -> list[tuple[str, str]]:
    """Both motions, which a free vibration does not repeat."""
    motions = {"reference": comparison.reference, "penalty": comparison.penalty}
    free = comparison.is_free
    texts = {name: "free vibration" if free else _motion_text(each, units) for name, each in motions.items()}
    if comparison.runs.penalty.status is Status.WITHOUT_SOLUTION:
        texts["penalty"] = "not known: stopped at a step without a solution"
    return list(texts.items())


def _motion_text(motion: Motion, units: Units | None) -> str:
    rate = f"; Lyapunov exponent {motion.lyapunov:+.3g} a period" if math.isfinite(motion.lyapunov) else ""
    return f"{print_statement(repetition(motion), units)}{rate}"


def _physical_lines(comparison: Comparison, units: Units) -> list[str]:
    penalty, exact = comparison.runs.penalty, comparison.runs.reference.method
    rows = {"physical": settings_text(units, penalty.eta, penalty.method)}
    motions = (
        {}
        if comparison.is_free
        else {
            "  reference": motion_text(units, penalty.eta, comparison.reference, exact) or "nothing known",
            "  penalty": motion_text(units, penalty.eta, comparison.penalty, penalty.method) or "nothing known",
        }
    )
    return ["", *columns((rows | motions).items())]
