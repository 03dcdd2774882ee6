"""``vibroscope peaks``: what an analyst reads off both solutions, their spectra, and the transmissibility over η."""

import argparse
from collections.abc import Iterator, Sequence

import numpy as np
from vibroscope.app.commands.options import add_both_solutions, eta_of, reference_of, refuse_missing, stepping_of
from vibroscope.app.commands.parser import Command, OneLineParser
from vibroscope.app.commands.physical_units import add_units_option, physical_part, wanted_units
from vibroscope.app.commands.recommend import eta_range
from vibroscope.app.commands.report import Line, Report, write_csv
from vibroscope.app.studies.peaks import (
    FEW,
    Read,
    difference_text,
    has_impacts,
    impacts_note,
    kept_text,
    read_off,
    sampled,
)
from vibroscope.engine import PEAKS, Method, System, Units, spaced, transmissibility, written

LABEL, COLUMN = 16, 16  # characters


def add(command: OneLineParser) -> None:
    """Add the options."""
    add_both_solutions(command)
    add = command.add_argument
    add("--spectrum", metavar="FILE.csv", help="also write the amplitudes, without dimension, over orders of eta")
    add("--transmissibility", metavar="FILE.csv", help="also write the transmissibility over --eta-range")
    add("--eta-range", type=eta_range, metavar="A:B:N", help="with --transmissibility: N frequencies from A to B")
    add_units_option(command)


def run(options: argparse.Namespace) -> Report:
    """Run both solutions."""
    refuse_missing(options, "newmark")
    system, eta, units = options.file.system, eta_of(options), wanted_units(options)
    methods = {"reference": reference_of(options), "penalty": stepping_of(options)}
    if (options.transmissibility is None) != (options.eta_range is None):
        raise ValueError("--transmissibility and --eta-range go together: give a file and frequencies, as 0.5:3:200")
    if options.transmissibility and not system.excitation.base:
        raise ValueError("--transmissibility is relative to the base, which does not move: give it a motion")
    runs = {name: sampled(system, eta, method, options.initial) for name, method in methods.items()}
    read = {name: read_off(run) for name, run in runs.items()}
    found = {name: each.peaks for name, each in read.items()}
    ended = [f"{name}: {run.ending}" for name, run in runs.items() if not run.ok]
    if options.spectrum:
        if ended:
            raise ValueError(f"--spectrum needs both solutions: {ended[0]}")
        _write_spectra(options.spectrum, read)
    if options.transmissibility:
        _write_transmissibility(options.transmissibility, system, methods, spaced("eta", *options.eta_range).tolist())
    data = {"eta": eta} | {name: {"status": str(runs[name].status)} | values for name, values in found.items()}
    if units:
        physical = {name: peaks_in_units(values, units) for name, values in found.items()}
        data |= physical_part(units, eta, methods["penalty"], **physical)
    return Report(_lines(found, units, ended, system, kept_text(system, eta, options.initial)), data)


def peaks_in_units(values: dict[str, float], units: Units) -> dict[str, float]:
    """Peaks in physical units."""
    return {name: units.physical(PEAKS[name], value) for name, value in values.items()}


def table_of_peaks(found: dict[str, dict[str, float]], units: Units | None, system: System) -> Iterator[Line]:
    """A table: each peak of each solution, and how far the second, the penalty solution, is off the first."""
    both = ("difference",) if len(found) > 1 else ()
    yield f"{'largest':{LABEL}}" + "".join(f"{name:>{COLUMN}}" for name in (*found, *both))
    struck = both and has_impacts(next(iter(found.values())))
    columns = [peaks_in_units(values, units) if units else values for values in found.values()]
    for name in PEAKS:
        if system.wall and name.endswith("2"):
            continue
        values = [column[name] for column in columns]
        label = name.replace("_", " ").replace("1", " 1").replace("2", " 2")
        cells = "".join(f"{written(value) if np.isfinite(value) else '-':>{COLUMN}}" for value in values)
        off = f" {difference_text(name, values[:2], struck) or '-':>{COLUMN - 1}}" if both else ""
        yield f"{label:{LABEL}}{cells}{off}" + (f"  {units.unit(PEAKS[name])}" if units else "")


def _lines(
    found: dict[str, dict[str, float]], units: Units | None, ended: Sequence[str], system: System, over: str
) -> Iterator[Line]:
    """The table, ``over`` which periods it is, and which run ended."""
    yield from table_of_peaks(found, units, system)
    yield f"Over {over}; displacements and velocities relative to the base, accelerations absolute."
    yield from filter(None, [impacts_note(found["reference"])])
    yield from ended


def _write_spectra(path: str, found: dict[str, Read]) -> None:
    columns = {}
    for name, each in found.items():
        columns |= {head if head == "order" else f"{name}_{head}": column for head, column in each.amplitudes.items()}
    write_csv(path, list(columns), np.transpose(list(columns.values())).tolist())


def _write_transmissibility(path: str, system: System, methods: dict[str, Method], etas: Sequence[float]) -> None:
    rows = []
    for eta in etas:
        runs = [sampled(system, eta, method, samples=FEW) for method in methods.values()]
        rows.append(
            [eta, *(ratio for run in runs for ratio in (transmissibility(run).tolist() if run.ok else [np.nan] * 2))]
        )
    write_csv(path, ["eta", *(f"{name}_body{body}" for name in methods for body in (1, 2))], rows)


COMMAND = Command(
    "largest displacements, accelerations, forces and contact times of both solutions",
    "Run the reference and the penalty solution and print the largest values of each, and how far they differ.",
    "",
    add,
    run,
    "one JSON object",
)
