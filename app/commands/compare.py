"""``vibroscope compare``: where the penalty solution leaves the reference, in three parts and in words."""

import argparse
import json
import math
from dataclasses import fields
from textwrap import wrap

from vibroscope.app.commands import measured
from vibroscope.app.commands.options import add_system_option, default_of, reference_of, system_of
from vibroscope.app.commands.physical import add_units_option, motion_in, motion_text, settings_text, wanted_units
from vibroscope.engine import PARTS, Comparison, Newmark, Reference, Regularisation, Units, Verdict, compare, verdict

SPLIT = ("contact_time", "wrong_restitution", "pulling", "damper")  # the last two make up the one before
_KEEP = default_of(compare, "keep")


def add(commands) -> None:
    """``vibroscope compare``."""
    command = commands.add_parser(
        "compare",
        allow_abbrev=False,
        help="difference from the reference in three parts, and which number is to blame",
        description="Run Newmark's penalty solution and the reference from rest, split their difference into what the "
        "time step, K and D, and the joint damping do, and say in words what to change first.",
        epilog="Differences are rms over the kept periods, relative to the reference. Where motions do not repeat they "
        "mean nothing at an instant (pointwise: false), and statistics are compared.",
    )
    add = command.add_argument
    add("--eta", required=True, type=float, metavar="F", help="excitation frequency Omega/omega1; paper: 1.08 to 3.25")
    add("--K", required=True, type=float, metavar="F", help="contact stiffness; the paper uses 100 to 12000")
    add("--D", required=True, type=float, metavar="F", help="contact damping; the paper uses 8 to 50")
    add("--steps", required=True, type=float, metavar="N", help="steps per excitation period, the time step is T/N")
    add("--located", action="store_true", help="cut the steps at each contact change, located within the step")
    add("--periods", type=float, metavar="N", help="excitation periods to run (default %(default)s)")
    add("--keep", type=float, metavar="N", help=f"last periods to compare (default {_KEEP}, or all if fewer are run)")
    add(
        "--joint-damping",
        choices=("table", "derived"),
        default=Reference().joint_damping,
        help="damping of the reference's joined pendulums (default %(default)s); derived: no part of it",
    )
    add(
        "--threshold",
        type=float,
        metavar="F",
        help=f"parting speed that begins permanent contact (default {Reference().threshold:g}); 0: its limit",
    )
    add_system_option(command)
    measured.add_measured_options(command)
    add("--series", action="store_true", help="with --json: the difference and its parts at every sampled instant, too")
    add_units_option(command)
    add("--json", action="store_true", help="print one JSON object")
    command.set_defaults(run=run, periods=default_of(compare, "periods"))


def run(options: argparse.Namespace) -> None:
    """Compare and print."""
    if options.measured is not None:
        measured.run(options)
        return
    if options.fit is not None:
        raise ValueError("--fit needs a measurement: give --measured FILE.csv")
    found = compare(
        system_of(options),
        options.eta,
        Newmark(options.K, options.D, options.steps, located=options.located),
        reference=reference_of(options),
        periods=options.periods,
        keep=min(_KEEP, options.periods) if options.keep is None else options.keep,
    ).with_evidence()
    told = verdict(found)
    split = found.split() if found.complete else None
    units = wanted_units(options)
    if options.json:
        numbers = as_json(found, told, split)
        if options.series:
            numbers["series"] = _series(found)
        if units:
            numbers["physical"] = _physical(found, units)
        print(json.dumps(numbers, allow_nan=False))
    else:
        print("\n".join([as_text(found, told, split), *(_physical_lines(found, units) if units else ())]))


def as_json(found: Comparison, told: Verdict, split: Regularisation | None) -> dict:
    """The contract for scripts; None for what is not known."""
    method = found.runs.penalty.method
    words = told.as_dict()
    return {
        "eta": found.runs.penalty.eta,
        "K": method.stiffness,
        "D": method.damping,
        "steps": method.steps,
        "located": method.located,
        "pointwise": found.pointwise,
        **{name: _known(getattr(found, name)) for name in ("total", *PARTS, "residual")},
        "split": _split(found, split),
        "impacts": _numbers(found.encounters),
        "statistics": _numbers(found.statistics),
        "reference": found.reference.as_dict(),
        "penalty": found.penalty.as_dict(),
        "verdict": words.pop("headline"),
        **words,
    }


def _split(found: Comparison, split: Regularisation | None) -> dict | None:
    """The regularisation's own parts, and the restitution that the contact delivers."""
    if split is None:
        return None
    return {
        **{name: _known(found.parts.relative(getattr(split, name))) for name in SPLIT},
        "in_step": split.in_step,
        "damping_ratio": split.ratio,
        "restitution": split.restitution,
        "restitution_without_pull": split.without_pull,
    }


def _numbers(record) -> dict | None:
    """The plain numbers of a dataclass."""
    if record is None:
        return None
    values = {each.name: getattr(record, each.name) for each in fields(record)}
    return {name: _known(value) for name, value in values.items() if isinstance(value, float | int)}


def _series(found: Comparison) -> dict | None:
    """xi1, xi2, xi1', xi2' of the difference and its parts."""
    if found.parts is None:
        return None
    rows = {name: getattr(found.parts, name) for name in ("total", *PARTS)}
    return {
        "time": found.parts.time.tolist(),
        **{name: [[_known(value) for value in row] for row in values.tolist()] for name, values in rows.items()},
    }


def _physical(found: Comparison, units: Units) -> dict:
    """Settings and both motions in the units of an FE input file."""
    penalty = found.runs.penalty
    return {
        "settings": units.settings(penalty.eta, penalty.method),
        "reference": motion_in(units, found.reference),
        "penalty": motion_in(units, found.penalty),
    }


def _physical_lines(found: Comparison, units: Units) -> list[str]:
    penalty = found.runs.penalty
    lines = ["", f"{'physical':22}{settings_text(units, penalty.eta, penalty.method)}"]
    for name, motion in (("reference", found.reference), ("penalty", found.penalty)):
        lines.append(f"{'  ' + name:22}{motion_text(units, motion) or 'nothing known'}")
    return lines


def as_text(found: Comparison, told: Verdict, split: Regularisation | None) -> str:
    """The same for people."""
    lines = [f"{found.runs.penalty.method}", f"eta = {found.runs.penalty.eta:g}, against {found.runs.reference.method}"]
    lines += ["", *wrap(told.headline, 100), ""]
    lines += [_share("difference (rms)", found.total), _share("  time step", found.time_step)]
    lines += [_share("  regularisation", found.regularisation)]
    if split is not None and split.in_step:
        lines += [_share(f"    {name.replace('_', ' ')}", found.parts.relative(getattr(split, name))) for name in SPLIT]
    lines += [_share("  joint damping", found.joint_damping)]
    if not found.pointwise and found.statistics is not None:
        told_apart = found.statistics
        lines += [f"{'sections differ by':22}{_percent(told_apart.total)} (chance: {_percent(told_apart.floor)})"]
    for name, motion in (("reference", found.reference), ("penalty", found.penalty)):
        lines += [f"{name:22}{_motion(motion)}"]
    return "\n".join([*lines, "", *(line for text in told.details for line in wrap(text, 100, subsequent_indent="  "))])


def _motion(motion) -> str:
    period = f", period {motion.period}" if motion.period else ""
    rate = f", Lyapunov exponent {motion.lyapunov:+.3g} a period" if math.isfinite(motion.lyapunov) else ""
    return f"{motion.type}{period}{rate}"


def _share(name: str, share: float) -> str:
    return f"{name:22}{_percent(share)}"


def _percent(share: float) -> str:
    return f"{100 * share:.3g} %" if math.isfinite(share) else "not known: a run ended early"


def _known(value: float) -> float | None:
    return value if math.isfinite(value) else None
