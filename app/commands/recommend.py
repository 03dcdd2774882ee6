"""``vibroscope recommend``: K, D and steps that meet a tolerance."""

import argparse
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from functools import partial
from itertools import chain

from vibroscope.app.commands.numbers import count, measured, number, of_field, span
from vibroscope.app.commands.options import (
    SCHEME_OPTIONS,
    add_fields,
    add_system_option,
    eta_of,
    note_held,
    note_unused,
    reference_of,
    stepping_of,
    system_of,
)
from vibroscope.app.commands.output import progress_line
from vibroscope.app.commands.parser import Command, OneLineParser
from vibroscope.app.commands.physical_units import add_units_option, wanted_units
from vibroscope.app.commands.recommend_schemes import ALL, find_schemes, is_asked
from vibroscope.app.commands.recommendation_text import as_json, curve_lines, lines_of, range_json, range_lines
from vibroscope.app.commands.report import Line, Report
from vibroscope.app.explorer.parameters import FIELDS
from vibroscope.engine import (
    Limits,
    Newmark,
    SettingQuestion,
    TimeStepping,
    Tolerances,
    Units,
    design_curve,
    end_text,
    recommend,
    with_located_steps,
)
from vibroscope.engine.recommendation.limits import STIFFEST

ETAS_LIMIT = 1000
OFF = "off"  # a tolerance that is not asked for


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
    error = "largest relative error (default %(default)s)"
    add("--tolerance", type=number, default=Tolerances.displacement, metavar="F", help=error)
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


def switchable(text: str) -> float | str:
    """A tolerance, or the word that switches it off."""
    return OFF if text.strip().lower() == OFF else number(text)


def eta_range(text: str) -> tuple:
    """``A:B:N``: two frequencies, each with a unit or without, and how many values the range has."""
    low, high, n = span(text, "frequency", "A:B:N, as 2.6:2.9:7 for seven frequencies")
    if not (2 <= n <= ETAS_LIMIT and n == int(n)):
        limits = f"is not in 2 … {ETAS_LIMIT}, or not whole"
        raise argparse.ArgumentTypeError(f"N = {n:g} {limits}: give the number of frequencies")
    return low, high, int(n)


def etas_of(low: float, high: float, n: int) -> list[float]:
    """N frequencies from the lowest to the highest."""
    return [low + (high - low) * i / (n - 1) for i in range(n)]


def run(options: argparse.Namespace) -> Report:
    """Search."""
    if options.K is not None:
        note_unused(options, ["K_max"], "where --K is held")
    units, progress = wanted_units(options), progress_line(lambda share: f"searching {100 * share:3.0f} %", 1)
    if is_asked(options):
        return find_schemes(options, partial(question_of, options), progress, units)
    scheme = stepping_of(options, K=1.0, D=0.0, steps=1000)
    contact = units and units.of_contact(scheme)
    if options.one_setting and not options.eta_range:
        raise ValueError("--one-setting needs a range: give --eta-range 2.6:2.8:5")
    if not options.eta_range:
        question = question_of(options, eta_of(options), scheme)
        found = recommend(question, progress=progress)
        lines = chain(lines_of(found, units), _located_lines(options, question, progress, units))
        return Report(lines, as_json(found, units), contact)
    note_held(options)
    etas = etas_of(*options.eta_range)
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
        system_of(options),
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
