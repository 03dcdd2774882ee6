"""``vibroscope recommend``: K, D and steps that meet a tolerance.

``vibroscope recommend`` with ``--integrator all``, ``--law all`` or ``--code NAME``: many searches, a table of them.

The best comes first.
"""

import argparse
import copy
from collections.abc import Callable, Iterator, Sequence
from dataclasses import fields, replace
from functools import partial
from itertools import chain

from vibroscope.app.commands.codes import code_alone
from vibroscope.app.commands.numbers import count, measured, of_field, share, span
from vibroscope.app.commands.options import (
    INTEGRATOR_NUMBERS,
    LAW_OPTIONS,
    SCHEME_OPTIONS,
    add_fields,
    add_system_option,
    eta_of,
    note_held,
    note_unused,
    reference_of,
    scheme_of,
)
from vibroscope.app.commands.parser import Command, OneLineParser
from vibroscope.app.commands.physical_units import add_units_option, wanted_units
from vibroscope.app.commands.recommendation_text import (
    CONSTANT,
    CUT,
    as_json,
    curve_lines,
    lines_of,
    met_words,
    range_json,
    range_lines,
)
from vibroscope.app.commands.report import Line, Report, Row, note, progress_line, rows
from vibroscope.app.explorer.parameters import FIELDS
from vibroscope.engine import (
    CONTACT_LAWS,
    INTEGRATORS,
    Limits,
    Newmark,
    Recommendation,
    SettingQuestion,
    TimeStepping,
    Tolerances,
    Units,
    counted,
    design_curve,
    end_text,
    percent,
    recommend,
    recommend_schemes,
    spaced,
    with_located_steps,
    written,
)
from vibroscope.engine.law_table import NEEDED, numbers_of
from vibroscope.engine.recommendation.question import STIFFEST

ALL = "all"
LAW_NUMBERS = set(LAW_OPTIONS) - {"law"}
_COLUMNS = "{:<40} {:<8} {:>9} {:>9} {:>7} {:>7} {:>8} {:>8}  {}"


def is_asked(options: argparse.Namespace) -> bool:
    """Whether several integrators, or several laws, are searched."""
    return options.code is not None or ALL in (options.integrator, options.law)


def find_schemes(
    options: argparse.Namespace, question_of: Callable, progress: Callable | None, units: Units | None
) -> Report:
    """Search for each integrator or law; ``question_of`` makes the question of an η and a method."""
    if options.eta_range or options.one_setting:
        what = "--code" if options.code is not None else f"--{_searched(options)} {ALL}"
        raise ValueError(f"{what} searches at one frequency: give --eta in place of --eta-range and --one-setting")
    code = None if options.code is None else code_alone(options)
    searched, leaves_out = _searched(options), code.leaves_out if code else ""
    every = {"integrator": _every_scheme, "law": _every_law}[searched]
    schemes = code.schemes() if code else every(options)
    system, eta = options.file.system, eta_of(options)
    note(f"searching with {counted(len(schemes), 'method')}: some take a minute")
    found = recommend_schemes(question_of(eta, schemes[0]), schemes, progress=progress)
    best = found[0]
    words = code.words_for(system, eta, best.method, units, options.contact_area) if code and best.best else ()
    data = {
        "eta": best.eta,
        "tolerance": best.tolerance,
        "code": code and code.key,
        "found": [as_json(each, units) | {"integrator_numbers": _numbers(each.scheme)} for each in found],
        "input": list(words),
        "leaves_out": leaves_out,
    }
    head = f"{code.name} ({code.key}): what it has" if code else f"every {searched}"
    lines: list[Line] = [f"{head}; eta = {best.eta:g}, tolerance {percent(best.tolerance)}"]
    lines.append(_COLUMNS.format(searched, "status", "K", "D", "steps", "solves", "error", "robust", "met").rstrip())
    lines += [_row(each, searched) for each in found]
    if len({each.scheme.located for each in found}) == 2:
        lines.append(f"located           for {CUT}; the other rows are for {CONSTANT}")
    lines += ["", *lines_of(best, units)]
    lines += [Row("" if i else "what to set", line) for i, line in enumerate(words)]
    lines += rows({"not computed here": leaves_out})
    return Report(lines, data, units and units.of_contact(best.scheme))


def _searched(options: argparse.Namespace) -> str:
    """The option in which the rows of the table differ, "integrator" or "law"; raises ValueError if it is both."""
    if options.law != ALL:
        return "integrator"
    if options.integrator == ALL:
        raise ValueError(f"--integrator {ALL} with --law {ALL} is some hundred searches: name one integrator or law")
    return "law"


def _every_law(options: argparse.Namespace) -> list[TimeStepping]:
    """The method of the options with each contact law whose numbers are given; a note on stderr names the others."""
    schemes = []
    for law in CONTACT_LAWS:
        own, numbers = copy.copy(options), numbers_of(law)
        own.law = law
        for name in LAW_NUMBERS - numbers.keys():
            setattr(own, name, None)
        if missing := [f"--{name}" for name in numbers if numbers[name] is NEEDED and getattr(own, name) is None]:
            note(f"law {law} is left out: it needs {' and '.join(missing)}")
            continue
        schemes.append(scheme_of(own))
    if not options.located and options.status is None:
        schemes.append(with_located_steps(schemes[0]))  # of one law: each takes a search of its own
    return schemes


def _every_scheme(options: argparse.Namespace) -> list[TimeStepping]:
    """The method of the options with each integrator; if no status is given, also with steps cut at contact changes."""
    given = {name: getattr(options, name) for name in INTEGRATOR_NUMBERS if getattr(options, name) is not None}
    schemes = []
    for name, kind in INTEGRATORS.items():
        own = copy.copy(options)
        own.integrator = name
        for option in given.keys() - {each.name for each in fields(kind)}:
            setattr(own, option, None)
        if kind.explicit and options.status == "end":
            note(f"{name} knows the gap before the force: its status is that at the start")
            own.status = own.without_solution = None
        schemes.append(scheme_of(own))
    if not options.located and options.status is None:
        schemes += [with_located_steps(each) for each in schemes]
    return schemes


def _numbers(scheme: TimeStepping) -> dict[str, float]:
    return {each.name: getattr(scheme.integrator, each.name) for each in fields(scheme.integrator)}


def _row(found: Recommendation, searched: str) -> str:
    scheme = found.scheme
    if searched == "law":
        numbers = {name: getattr(scheme, name) for name in numbers_of(scheme.law)}
        name = scheme.law
    else:
        numbers, name = _numbers(scheme), scheme.integrator.name
    name = " ".join([name, *(f"{symbol}={value:.4g}" for symbol, value in numbers.items())])
    if found.best is None:
        return f"{name:<40} {scheme.status:<8} {found.reason}"
    (k, d, n), best = found.best.setting, found.best
    error, robust = (percent(value, beside=found.tolerance) for value in (best.error, best.robust))
    numbers = written(k, 4), written(d, 4), n, f"{found.solves:.0f}", error, robust, met_words(found)
    return _COLUMNS.format(name, scheme.status, *numbers).rstrip()


ETAS_LIMIT = 1000
OFF = "off"  # a tolerance that is not asked for
_FREE = (
    "which a free vibration does not have; find K, D and the step of its contacts with vibroscope impact --system FILE "
    "--initial x1,v1,x2,v2"
)


def add(command: OneLineParser) -> None:
    """Add the options."""
    add = command.add_argument
    where = command.add_mutually_exclusive_group()
    add_fields(where, "eta")
    where.add_argument("--eta-range", type=eta_range, metavar="A:B:N", help="N frequencies from A to B: a design curve")
    add(
        "--one-setting",
        action="store_true",
        help="with --eta-range: one K, D and time step for all of them and between them, and what limits the range",
    )
    error = "largest relative error, as 0.05 or 5 %% (default %(default)s)"
    add("--tolerance", type=share, default=Tolerances.displacement, metavar="F", help=error)
    for name, usual, what in (
        ("restitution", Tolerances.restitution, "restitution that the contacts deliver may be off"),
        ("force", Tolerances.force, "peak force may be from that without a time step, relative to it"),
    ):
        words = f"how far the {what}, or {OFF} (default %(default)s)"
        add(f"--{name}-tolerance", type=switchable, default=usual, metavar=f"F|{OFF}", help=words)
    add("--located", action="store_true", help="steps cut at contact changes only; the least solves per period")
    searched = {name: {"choices": (*FIELDS[name].choices, ALL)} for name in ("law", "integrator")}
    add_fields(command, *SCHEME_OPTIONS, **searched)
    add(
        "--code",
        metavar="NAME",
        help="search with the integrators, the contact status and the law of this code of `vibroscope codes`; the "
        "answer has the keywords of its input",
    )
    add(
        "--contact-area",
        type=measured("area"),
        metavar="F",
        help="with --code: the contact area, by which K and D are divided for keywords of a pressure, as '120 mm2'",
    )
    held = {name: {"help": f"hold {name} and look for the rest"} for name in ("K", "D")}
    add_fields(command, "joint_damping", "K", "D", **held)
    largest = f"largest K to try (default {end_text(STIFFEST)} times the stiffer spring)"
    add("--K-max", type=of_field("K"), metavar="F", help=largest)
    most = "most steps per period to try (default %(default)s)"
    add("--steps-max", type=count, default=Limits.steps_max, metavar="N", help=most)
    add_units_option(command)
    add_system_option(command)
    command.not_here["--initial"] = f"a search is for the steady motion of driven bodies, {_FREE}"


def switchable(text: str) -> float | str:
    """A tolerance, or the word that switches it off."""
    return OFF if text.strip().lower() == OFF else share(text)


def eta_range(text: str) -> tuple:
    """``A:B:N``: two frequencies, each with a unit or without, and how many values the range has."""
    low, high, n = span(text, "frequency", "A:B:N, as 2.6:2.9:7 for seven frequencies")
    if not (2 <= n <= ETAS_LIMIT and n == int(n)):
        limits = f"is not in 2 … {ETAS_LIMIT}, or not whole"
        raise argparse.ArgumentTypeError(f"N = {n:g} {limits}: give the number of frequencies")
    return low, high, int(n)


def run(options: argparse.Namespace) -> Report:
    """Search."""
    if not options.file.system.excitation.drives:
        raise ValueError(
            "nothing drives the bodies: give what drives them in --system, since a search is for their steady motion, "
            f"{_FREE}"
        )
    if options.K is not None:
        note_unused(options, ["K_max"], "where --K is held")
    units, progress = wanted_units(options), progress_line(lambda share: f"searching {100 * share:3.0f} %", 1)
    if is_asked(options):
        return find_schemes(options, partial(question_of, options), progress, units)
    scheme = scheme_of(options)
    contact = units and units.of_contact(scheme)
    if options.one_setting and not options.eta_range:
        raise ValueError("--one-setting needs a range: give --eta-range 2.6:2.8:5")
    if not options.eta_range:
        question = question_of(options, eta_of(options), scheme)
        found = recommend(question, progress=progress)
        lines = chain(lines_of(found, units), _located_lines(options, question, progress, units))
        return Report(lines, as_json(found, units), contact)
    note_held(options)
    etas = spaced("eta", *options.eta_range).tolist()
    if options.one_setting:
        found = recommend(question_of(options, etas, scheme), progress=progress)
        return Report(range_lines(found, units), range_json(found, units), contact)
    curve = design_curve(question_of(options, etas[0], scheme), etas, progress=progress)
    return Report(curve_lines(curve), [as_json(found, units) for found in curve])


def _located_lines(
    options: argparse.Namespace, question: SettingQuestion, progress: Callable, units: Units | None
) -> Iterator[Line]:
    """The same search with steps that are cut at contact changes, where no method is asked for."""
    usual = question.scheme in (Newmark(1.0, 0.0, 1000), Newmark(1.0, 0.0, 1000, located=True))
    if usual and not options.located and options.status is None:
        located = replace(question, scheme=with_located_steps(question.scheme))
        yield from lines_of(recommend(located, progress=progress), units)


def question_of(options: argparse.Namespace, etas: float | Sequence[float], scheme: TimeStepping) -> SettingQuestion:
    """What the options ask for at these η, with this method."""
    restitution, force = (
        None if given == OFF else given for given in (options.restitution_tolerance, options.force_tolerance)
    )
    return SettingQuestion(
        options.file.system,
        etas,
        Tolerances(options.tolerance, restitution, force),
        Limits(options.K_max, options.steps_max, options.K, options.D),
        scheme,
        reference_of(options),
    )


COMMAND = Command(
    "find K, D and steps that meet a tolerance at the least cost",
    "Find the contact stiffness K, the contact damping D and the steps per period with which Newmark's method, or what "
    "is chosen in its place, keeps to the reference with hardly more than the least number of steps. The error is the "
    "rms difference of the displacements over 50 periods, relative to the reference. The contacts must deliver the "
    "restitution, and the peak force that the same K, D and law have without a time step. What is recommended lies in "
    "the middle of where all this is met, and was run from rest, with half the step, and with 120 neighbours with "
    "other n (2 %), K and D (1 %).",
    "A tolerance that nothing meets is a result, with the reason; the exit status is 2 only for bad input.",
    add,
    run,
    "one JSON object (a list of them for --eta-range without --one-setting)",
)
