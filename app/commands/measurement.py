"""``vibroscope measurement``: an example of a measurement, as a CSV file."""

import argparse

from vibroscope.app.commands.numbers import count, number
from vibroscope.app.commands.options import add_fields, add_system_option
from vibroscope.app.commands.parser import Command, OneLineParser
from vibroscope.app.commands.report import Report
from vibroscope.engine import measurement_text, synthetic_measurement
from vibroscope.engine.arguments import whole

_ETA = 2.76  # of the paper's figures


def add(command: OneLineParser) -> None:
    """Add the options."""
    add, usual = command.add_argument, "(default %(default)s)"
    add_fields(command, "eta", eta={"help": f"excitation frequency (default: that of --system, or else {_ETA:g})"})
    add("--periods", type=count, default=4, metavar="N", help=f"excitation periods {usual}")
    add("--per-period", type=count, default=120, metavar="N", help=f"samples per period {usual}")
    add("--noise", type=number, default=0.02, metavar="F", help=f"standard deviation in units of length {usual}")
    add("--phase", type=number, default=0.7, metavar="F", help=f"tau of the first sample {usual}")
    add("--seed", type=count, default=1, metavar="N", help=f"the same seed gives the same noise {usual}")
    add_system_option(command)


def run(options: argparse.Namespace) -> Report:
    """Make the example."""
    options.seed = whole("seed", options.seed, 0, 2**63, "give a whole number")
    system, units = options.file.system, options.file.units
    if options.eta is None:
        options.eta = options.file.eta or _ETA
    names = ("periods", "per_period", "noise", "phase", "seed")
    example = synthetic_measurement(system, options.eta, **{name: getattr(options, name) for name in names})
    moves = system.excitation.base != 0
    length, lengths = ("base amplitude", "base amplitudes") if moves else ("unit of length", "units of length")
    comment = (
        "NOT MEASURED: the semi-analytical reference plus normal noise, made by `vibroscope measurement`\n"
        f"eta = {options.eta:g}, restitution = {system.restitution:g}, noise of {options.noise:g} {lengths}, "
        f"seed {options.seed}\n"
        f"omega1 = {units.omega1:g} 1/s, {length} {units.base_amplitude:g} mm; x1, x2 as a fixed sensor sees them"
    )
    return Report(measurement_text(example, units, comment).splitlines())


COMMAND = Command(
    "print an example of a measurement as CSV: made by the reference plus noise, not measured",
    "Print a CSV file as `vibroscope compare --measured` takes it, made by the reference plus noise.",
    add=add,
    run=run,
)
