"""``vibroscope export``: a deck for another code, with the system and the numbers that are set."""

import argparse
from pathlib import Path

from vibroscope.app.commands.options import (
    PENALTY_OPTIONS,
    SCHEME_OPTIONS,
    add_fields,
    add_initial_option,
    add_run_length,
    add_system_option,
    eta_of,
    kept_periods,
    method_of,
)
from vibroscope.app.commands.parser import Command, OneLineParser
from vibroscope.app.commands.physical_units import add_units_option, wanted_units
from vibroscope.app.commands.report import Report
from vibroscope.app.export.decks import DECKS, PERIODS, DeckProblem, deck, usual_length
from vibroscope.app.export.decks.problem import KEEP
from vibroscope.engine import CONTACT_STATUSES, Units


def add(command: OneLineParser) -> None:
    """Add the options."""
    add = command.add_argument
    add("--to", required=True, type=code_of_deck, metavar="CODE", help=f"one of {', '.join(DECKS)}")
    add_fields(command, "eta", *PENALTY_OPTIONS, *SCHEME_OPTIONS)
    usual = f"default {PERIODS}, calculix: as many as its table of loads has room for; where nothing drives the bodies "
    add_run_length(command, f"{usual}to their first contact, all of which are written", KEEP, "write")
    add_initial_option(command)
    add_system_option(command)
    add_units_option(command)
    add("--out", type=Path, metavar="FILE", help="where to write the deck (default: print it)")


def code_of_deck(text: str) -> str:
    """The name of a code that decks are written for."""
    if text not in DECKS:
        raise argparse.ArgumentTypeError(
            f"no decks are written for {text!r}: give one of {', '.join(DECKS)}; for the keywords of other codes see "
            "`vibroscope codes` and `vibroscope recommend --code`"
        )
    return text


def run(options: argparse.Namespace) -> Report | None:
    """Write the deck."""
    code = DECKS[options.to]
    if options.status == CONTACT_STATUSES[0]:
        raise ValueError(
            f"{code.NAME} cannot express status = {options.status!r}: it has {code.STATUS!r}; give that, or none"
        )
    method, own = method_of(options), options.file.units
    system, eta = options.file.system, eta_of(options)
    if options.periods is None:
        options.periods, keep = usual_length(options.to, system, eta, method.steps, options.initial)
        options.keep = keep if options.keep is None else options.keep
    problem = DeckProblem(
        system,
        eta,
        method,
        wanted_units(options) or (None if own == Units() else own),
        options.initial,
        options.periods,
        kept_periods(options, KEEP),
        options.out.stem if options.out else DeckProblem.name,
    )
    text = deck(options.to, problem)
    if not options.out:
        return Report(text.splitlines())
    options.out.write_text(text, encoding="utf-8")
    return None


COMMAND = Command(
    "write a deck for OpenSees, CalculiX, Abaqus, Ansys or Modelica",
    "Write the input of another code, with the system and the numbers that are set, ready to run. Its result comes "
    "back by `vibroscope compare --measured FILE.csv`; how is said in the deck. What the code cannot "
    "express is refused.",
    "Numbers are in physical units with --units, or where --system has units of its own; else without dimension, with "
    "omega1 = 1 rad/s.",
    add,
    run,
    defaults={"solver": "newmark", "every_step": False},
)
