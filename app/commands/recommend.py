"""``vibroscope recommend``: K, D and steps that meet a tolerance."""

import argparse
import json
import math
from collections.abc import Sequence

from vibroscope.app.commands.numbers import count, measured, number, span
from vibroscope.app.commands.options import (
    ETA,
    add_integrator_options,
    add_joint_damping_option,
    add_system_option,
    eta_of,
    note_held,
    reference_of,
    stepping_of,
    system_of,
)
from vibroscope.app.commands.output import note, progress_line
from vibroscope.app.commands.physical_units import add_units_option, settings_text, unit_names, wanted_units
from vibroscope.app.commands.recommend_schemes import ALL, find_and_print, for_codes, is_asked
from vibroscope.app.explorer.method_words import scheme_as_dict
from vibroscope.app.explorer.suggestion_words import contact_words, force_words, range_words, verified_words
from vibroscope.engine import (
    Limits,
    Newmark,
    Recommendation,
    Served,
    SettingQuestion,
    Statement,
    TimeStepping,
    Tolerances,
    Units,
    design_curve,
    end_text,
    finite_or_none,
    percent,
    print_statement,
    recommend,
    with_located_steps,
    written,
)
from vibroscope.engine.recommendation.contacts import Contacts
from vibroscope.engine.recommendation.limits import STIFFEST

ETAS_LIMIT = 1000
OFF = "off"  # a tolerance that is not asked for


def add(commands) -> None:
    """Describe ``vibroscope recommend``."""
    command = commands.add_parser(
        "recommend",
        allow_abbrev=False,
        help="find K, D and steps that meet a tolerance at the least cost",
        description="Find the contact stiffness K, the contact damping D and the steps per period with which Newmark's "
        "method, or what is chosen in its place, keeps to the reference with hardly more than the least number of "
        "steps. The error is the rms difference of the displacements over 50 periods, relative to the reference. The "
        "contacts must deliver the restitution, and the peak force that the same K, D and law have without a time "
        "step. What is recommended lies in the middle of where all this is met, and was run from rest, with half the "
        "step, and with 120 neighbours with other n (2 %), K and D (1 %).",
        epilog="A tolerance that nothing meets is a result, with the reason; the exit status is 2 only for bad input.",
    )
    add = command.add_argument
    where = command.add_mutually_exclusive_group()
    where.add_argument("--eta", **ETA)
    where.add_argument("--eta-range", type=eta_range, metavar="A:B:N", help="N frequencies from A to B: a design curve")
    add(
        "--one-setting",
        action="store_true",
        help="with --eta-range: one K, D and time step for all of them and between them, and what limits the range",
    )
    _add_tolerances(command)
    add("--located", action="store_true", help="steps cut at contact changes only; the least solves per period")
    add_integrator_options(command, ALL)
    add(
        "--code",
        metavar="NAME",
        help="search with the integrators, the contact status and the law of this code of `vibroscope codes`; the "
        "answer has the keywords of its input",
    )
    add(
        "--contact-area",
        type=measured,
        metavar="F",
        help="with --code: the contact area, by which K and D are divided for keywords of a pressure, as '120 mm2'",
    )
    add_joint_damping_option(command)
    _add_limits(command)
    add_units_option(command)
    add_system_option(command)
    add(
        "--json",
        action="store_true",
        help="print one JSON object (a list of them for --eta-range without --one-setting)",
    )
    command.set_defaults(run=run)


def _add_tolerances(command: argparse.ArgumentParser) -> None:
    """Add an option for each of `Tolerances`."""
    error = "largest relative error (default %(default)s)"
    command.add_argument("--tolerance", type=number, default=Tolerances.displacement, metavar="F", help=error)
    for name, usual, what in (
        ("restitution", Tolerances.restitution, "restitution that the contacts deliver may be off"),
        ("force", Tolerances.force, "peak force may be from that without a time step, relative to it"),
    ):
        words = f"how far the {what}, or {OFF} (default %(default)s)"
        option = {"type": switchable, "default": usual, "metavar": f"F|{OFF}", "help": words}
        command.add_argument(f"--{name}-tolerance", **option)


def _add_limits(command: argparse.ArgumentParser) -> None:
    """Add an option for each of `Limits`."""
    add, largest = command.add_argument, f"{end_text(STIFFEST)} times the stiffer spring"
    add("--K", type=measured, metavar="F", help="hold K and look for the rest")
    add("--D", type=measured, metavar="F", help="hold D and look for the rest")
    add("--K-max", type=measured, metavar="F", help=f"largest K to try (default {largest})")
    steps, most = Limits.steps_max, "most steps per period to try (default %(default)s)"
    add("--steps-max", type=count, default=steps, metavar="N", help=most)


def switchable(text: str) -> float | str:
    """A tolerance, or the word that switches it off."""
    return OFF if text.strip().lower() == OFF else number(text)


def eta_range(text: str) -> tuple:
    """``A:B:N``: two frequencies, each with a unit or without, and how many values the range has."""
    low, high, n = span(text, "A:B:N, as 2.6:2.9:7 for seven frequencies")
    if not (2 <= n <= ETAS_LIMIT and n == int(n)):
        limits = f"is not in 2 … {ETAS_LIMIT}, or not whole"
        raise argparse.ArgumentTypeError(f"N = {n:g} {limits}: give the number of frequencies")
    return low, high, int(n)


def etas_of(low: float, high: float, n: int) -> list[float]:
    """N frequencies from the lowest to the highest."""
    return [low + (high - low) * i / (n - 1) for i in range(n)]


def run(options: argparse.Namespace) -> None:
    """Search and print."""
    if options.K is not None and options.K_max is not None:
        note("--K-max has no effect where --K is held")
    units, progress = wanted_units(options), progress_line(lambda share: f"searching {100 * share:3.0f} %", 1)
    if is_asked(options):
        find_and_print(options, question_of, progress, units, as_json, as_text)
        return
    scheme = stepping_of(options, K=1.0, D=0.0, steps=1000)
    if options.one_setting and not options.eta_range:
        raise ValueError("--one-setting needs a range: give --eta-range 2.6:2.8:5")
    if not options.eta_range:
        chosen = scheme not in (Newmark(1.0, 0.0, 1000), Newmark(1.0, 0.0, 1000, located=True))
        both = not (chosen or options.located or options.status is not None or options.json)
        for each in (scheme, with_located_steps(scheme)) if both else (scheme,):
            found = recommend(question_of(options, eta_of(options), each), progress=progress)
            print(
                json.dumps(as_json(found, units), allow_nan=False) if options.json else as_text(found, units),
                flush=True,
            )
        return
    note_held(options)
    etas = etas_of(*options.eta_range)
    if options.one_setting:
        found = recommend(question_of(options, etas, scheme), progress=progress)
        print(json.dumps(range_json(found, units), allow_nan=False) if options.json else range_text(found, units))
        return
    curve = design_curve(question_of(options, etas[0], scheme), etas, progress=progress)
    rows = [as_json(found, units) for found in curve]
    print(json.dumps(rows, allow_nan=False) if options.json else _curve_text(curve))


def question_of(
    options: argparse.Namespace, etas: float | Sequence[float], scheme: Newmark | TimeStepping
) -> SettingQuestion:
    """What the options ask for at these η, with this method."""
    restitution, force = (
        None if given == OFF else given for given in (options.restitution_tolerance, options.force_tolerance)
    )
    return SettingQuestion(
        system_of(options),
        etas,
        Tolerances(options.tolerance, restitution, force),
        Limits(options.K_max, options.steps_max, options.K, options.D),
        scheme,
        reference_of(options),
    )


def as_json(found: Recommendation, units: Units | None = None) -> dict:
    """A recommendation as JSON for scripts; None for numbers that do not exist."""
    best = found.best
    report = {
        "eta": found.eta,
        **_setting_json(found),
        "error": best and best.error,
        "robust": best and best.robust,
        "solves": best and found.solves,
        "met": found.met,
        "front": [_front_row(trial) for trial in found.front],
        "front_solves": [trial.cost * found.scheme.stages for trial in found.front],
        "joint_damping": None if math.isnan(found.joint_damping) else found.joint_damping,
        "compensated": found.compensated,
        "kind": found.kind,
        "reason": found.reason,
    }
    if units is not None and best:
        report["physical"] = _physical(units, found, found.method)
    return report


def range_json(found: Recommendation, units: Units | None = None) -> dict:
    """One setting for a range as JSON for scripts; None for numbers that do not exist."""
    best = found.best
    report = {
        **_setting_json(found),
        "eta_of_steps": found.eta if best else None,
        "time_step": found.time_step if best else None,
        "error": best and best.error,
        "robust": best and best.robust,
        "met": found.met,
        "etas": [_served_json(served) for served in found.served],
        "left_out": list(found.left_out),
        "front": [_front_row(trial) for trial in found.front],
        "limit": found.limit,
        "kind": found.kind,
        "reason": found.reason,
    }
    if units is not None and best:
        report["physical"] = _physical(units, found, found.method)
    return report


def _setting_json(found: Recommendation) -> dict:
    """The options of the search, and K, D and n of the best setting."""
    k, d, n = found.best.setting if found.best else (None, None, None)
    asked = {
        "tolerance": found.tolerance,
        "restitution_tolerance": found.tolerances.restitution,
        "force_tolerance": found.tolerances.force,
        "located": found.question.located,
        **scheme_as_dict(found.scheme),
    }
    ranges = {f"{symbol}_range": found.ranges.get(name) for symbol, name in (("K", "stiffness"), ("D", "damping"))}
    return {**asked, "K": k, "D": d, "steps": n, **ranges, **_contacts_json(found.best and found.best.contacts)}


def _contacts_json(contacts: Contacts | None) -> dict:
    """What the contacts of a setting do; None for numbers that do not exist."""
    numbers = {
        "restitution": "restitution",
        "peak_force": "peak_force",
        "peak_force_without_step": "without_step",
        "steps_per_contact": "steps",
    }
    return {name: contacts and finite_or_none(getattr(contacts, each)) for name, each in numbers.items()}


def _served_json(served: Served) -> dict:
    numbers = {name: getattr(served, name) for name in ("eta", "steps", "error", "robust")}
    return numbers | _contacts_json(served.contacts)


def _physical(units: Units, found: Recommendation, method: Newmark | TimeStepping) -> dict:
    """Setting and front in the units of an FE input file."""
    contact = units.of_contact(method)
    front = [
        [n, error, contact.physical("contact_stiffness", k), contact.physical("contact_damping", d)]
        for n, error, k, d in map(_front_row, found.front)
    ]
    return {"units": unit_names(units, method), **units.settings(found.eta, method), "front": front}


def _front_row(trial) -> list[float]:
    k, d, n = trial.setting
    return [n, trial.error, k, d]


def as_text(found: Recommendation, units: Units | None = None) -> str:
    """A recommendation as text: the setting, its error and cost, and the front."""
    lines = _asked_lines(found, f"eta = {found.eta:g}", units)
    if found.best is None:
        return "\n".join(lines)
    lines += [
        f"{_setting_text(found)}, {found.best.setting.steps} steps per period",
        f"error             {_beside(found, found.best.error)}; "
        f"{_beside(found, found.best.robust)} is kept to with half the step "
        "and by 9 in 10 neighbours",
        *_contact_lines(found, units),
    ]
    if found.question.located or found.scheme.stages > 1:
        lines.append(f"cost              {found.solves:.1f} solves per period")
    if found.kind:
        lines.append(f"mind              another kind of motion: {_printed(found.kind, found, units)}")
    if found.compensated:
        part = percent(found.joint_damping)
        lines.append(
            f"mind              the joint damping alone makes {part}: errors cancel here, and need not elsewhere"
        )
    if units is not None:
        lines.append(f"physical          {settings_text(units, found.eta, found.method)}")
    return "\n".join([*lines, *_front_lines(found, units)])


def _contact_lines(found: Recommendation, units: Units | None) -> list[str]:
    """The ranges, the contacts, and what was verified."""
    force = written if units is None else lambda value: units.text("force", value)
    rows = {
        "range": _printed(range_words(found), found, units),
        "contacts": contact_words(found),
        "peak force": force_words(found, force),
        "verified for": verified_words(found),
    }
    return [f"{name:18s}{text}" for name, text in rows.items() if text]


def _printed(text: str | Statement, found: Recommendation, units: Units | None) -> str:
    """A statement in units of the contact law that was searched over."""
    return print_statement(text, units and units.of_contact(found.scheme))


def _asked_lines(found: Recommendation, where: str, units: Units | None) -> list[str]:
    """What was asked, which codes it is for, and why nothing meets the tolerance."""
    lines = [f"{where}, {_kind_of_steps(found)}, tolerance {percent(found.tolerance)}"]
    lines.append(f"for               {for_codes(found.scheme)}")
    return lines if found.met else [*lines, f"not met           {_printed(found.reason, found, units)}"]


def _setting_text(found: Recommendation) -> str:
    """K and D of the best setting."""
    k, d, _ = found.best.setting
    return f"{'set' if found.met else 'best found':18s}K = {written(k, 6)}, D = {written(d, 6)}"


def _kind_of_steps(found: Recommendation) -> str:
    """The kind of steps that the settings were tried with, in words."""
    steps, scheme = "steps cut at contact changes" if found.question.located else "constant step", found.scheme
    if not scheme.has_choices:
        return steps if scheme.linear else f"{steps}, law {scheme.law}"
    contact = "" if found.question.located else f" contact at the {scheme.status} of steps,"
    return f"{steps}, {scheme.integrator},{contact} law {scheme.law}"


def range_text(found: Recommendation, units: Units | None = None) -> str:
    """One setting for a range as text: the setting, what it does at each eta, what limits it, and the front."""
    lines = _asked_lines(found, "one setting for a range of eta", units)
    if found.left_out:
        etas = ", ".join(f"{eta:.4g}" for eta in found.left_out)
        lines.append(f"left out          eta = {etas}: the reference does not repeat itself, or nothing touches there")
    if found.best is None:
        return "\n".join(lines)
    steps = f"{found.best.setting.steps} steps per period at eta = {found.eta:g}"
    lines += [
        f"{_setting_text(found)}, time step {written(found.time_step)} ({steps})",
        f"limit             {_printed(found.limit, found, units)}",
        *_contact_lines(found, units),
    ]
    if found.kind:
        lines.append(f"mind              another kind of motion: {_printed(found.kind, found, units)}")
    if units is not None:
        lines.append(f"physical          {settings_text(units, found.eta, found.method)}")
    lines.append("eta               steps     error    robust")
    for one in found.served:
        error, robust = _beside(found, one.error), _beside(found, one.robust)
        lines.append(f"{one.eta:<10.6g}{one.steps:13d} {error:>9s} {robust:>9s}")
    return "\n".join([*lines, *_front_lines(found, units)])


def _beside(found: Recommendation, error: float) -> str:
    return percent(error, beside=found.tolerance)


def _front_lines(found: Recommendation, units: Units | None) -> list[str]:
    """The front as a table, with spring and damper in units where they are asked for."""
    heads = ["K", "D"]
    units = units and units.of_contact(found.scheme)
    if units is not None:
        names = (units.unit(quantity).replace("·", ".") for quantity in ("contact_stiffness", "contact_damping"))
        heads = [f"{head} / {name}" for head, name in zip(("K", "2D"), names, strict=True)]
    wide = max(9, *map(len, heads))
    lines = ["front             steps  solves     error    robust " + " ".join(f"{head:>{wide}s}" for head in heads)]
    for trial in found.front:
        k, d, n = trial.setting
        if units is not None:
            k, d = units.physical("contact_stiffness", k), units.physical("contact_damping", d)
        error, robust = _beside(found, trial.error), _beside(found, trial.robust)
        lines.append(f"{n:23d} {trial.cost:7.0f} {error:>9s} {robust:>9s} {written(k):>{wide}} {written(d):>{wide}}")
    return lines


def _curve_text(curve: list[Recommendation]) -> str:
    """A design curve as text, one line an η."""
    lines = ["    eta         K         D   steps  solves     error    robust  met"]
    for found in curve:
        if found.best is None:
            lines.append(f"{found.eta:7.4f}  {found.reason.head}")
            continue
        (k, d, n), best = found.best.setting, found.best
        error, robust = _beside(found, best.error), _beside(found, best.robust)
        met = ("yes, of another kind" if found.kind else "yes") if found.met else f"no: {found.reason.head}"
        cells = [f"{found.eta:7.4f} {written(k, 6):>9} {written(d, 6):>9} {n:7d} {best.cost:7.0f}"]
        lines.append(" ".join([*cells, f"{error:>9s} {robust:>9s}  {met}"]))
    return "\n".join(lines)
