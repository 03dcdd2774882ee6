"""``vibroscope compare --measured FILE.csv``, and ``transient``: both solutions beside measured motion."""

import argparse
import math
from collections.abc import Iterator

from vibroscope.app.commands.options import reference_of, refuse_missing, stepping_of
from vibroscope.app.commands.physical_units import wanted_units
from vibroscope.app.commands.report import Report, record
from vibroscope.engine import (
    FITTED,
    Fit,
    MeasuredComparison,
    Measurement,
    Solved,
    System,
    Units,
    UnknownColumns,
    compare_measured,
    fit,
    measured_verdict,
    read_measurement,
)
from vibroscope.engine.facts import joined

_WHY = "; --measured lays the penalty solution over the measurement, too, also where --fit is of the reference alone"
_COLUMNS = 28, 20, 20, 20  # characters, at least


def add_measured_options(command: argparse.ArgumentParser) -> None:
    """Add ``--measured``, ``--columns`` and ``--fit``, for :func:`measured_report`."""
    command.add_argument(
        "--measured",
        metavar="FILE.csv",
        help="compare with a measurement instead: columns time [s], x1 [mm], x2 [mm] (or x1 alone) and perhaps contact "
        "(0 or 1) or force, or xi1, xi2 relative to the base; [-] or no unit: without dimension; or what LabVIEW, "
        "PicoScope, OpenSees or CalculiX write, perhaps packed by gzip",
    )
    command.add_argument(
        "--columns",
        type=column_names,
        metavar="NAMES",
        help="with --measured: which column is what, by its number or its text in the header, perhaps with a unit, as "
        '"time=1 [s], xi1=Disp [mm]" (default: the header says so)',
    )
    command.add_argument(
        "--fit",
        nargs="?",
        const=True,
        type=fit_names,
        metavar="NAMES",
        help=f"with --measured: fit these to it first, of {','.join(FITTED)} (default: all that the system has but K "
        "and D, of the penalty solution, and the scale of the sensors)",
    )


def refuse_without_measurement(options: argparse.Namespace) -> None:
    """Refuse options that belong to ``--measured``, where it is not given."""
    for name in ("fit", "columns"):
        if getattr(options, name) is not None:
            raise ValueError(f"--{name} needs a measurement: give --measured FILE.csv")


def fit_names(text: str) -> tuple[str, ...]:
    """Comma-separated names of constants to fit."""
    names = tuple(part.strip() for part in text.split(","))
    wrong = [name for name in names if name not in FITTED]
    if wrong or len(set(names)) < len(names):
        raise argparse.ArgumentTypeError(f"{text!r} cannot be fitted: give some of {','.join(FITTED)}, each once")
    return names


def column_names(text: str) -> dict[str, str]:
    """Comma-separated pairs NAME=COLUMN of ``--columns``."""
    pairs = [part.partition("=") for part in text.split(",")]
    if not all(sign and column.strip() for _, sign, column in pairs):
        raise argparse.ArgumentTypeError(f'{text!r} is no list of columns: write it as "time=1 [s], xi1=Disp [mm]"')
    return {name.strip(): column.strip() for name, _, column in pairs}


def _read(options: argparse.Namespace) -> Measurement:
    """The file; where its header does not say which column is what, the error names the option that does."""
    try:
        file = options.file
        return read_measurement(options.measured, file.units, options.columns, options.eta, file.has_units)
    except UnknownColumns as problem:
        second = ", xi2=3 [mm]" if len(problem.header) > 2 else ""
        raise ValueError(f'{problem}: --columns "time=1 [s], xi1=2 [mm]{second}"') from None


def measured_report(options: argparse.Namespace, system: System, **how: int) -> Report:
    """Align both solutions of a system with the measurement; with ``--fit``, solutions of the fitted system.

    ``how``: more arguments of :func:`engine.compare_measured`.
    """
    refuse_missing(options, "newmark", _WHY)
    measurement, penalty, fitted = _read(options), stepping_of(options), None
    if options.fit:
        names = None if options.fit is True else options.fit
        method = penalty.limit if names and {"K", "D"} & {*names} else None
        fitted = fit(system, options.eta, measurement, names=names, method=method, initial=options.initial)
        system, penalty, measurement = fitted.system, fitted.applied(penalty), fitted.corrected(measurement)
    how |= {"reference": reference_of(options), "initial": options.initial}
    comparison = compare_measured(system, options.eta, measurement, penalty, **how)
    units = wanted_units(options)
    units = units and units.of_contact(penalty)
    return Report(lines_of(comparison, fitted, units), as_json(comparison, fitted), units)


def as_json(comparison: MeasuredComparison, fitted: Fit | None = None) -> dict:
    """The comparison as JSON for scripts; None for what is not known."""
    recurrence = comparison.recurrence
    found = record(recurrence, "period", "noise", "strongest", possible_periods="possible")
    found |= record(recurrence if recurrence.period else None, "eta", "eta_error")
    found |= record(recurrence.sensor, closings_per_period="per_period", contact_share="share")
    return {
        "eta": comparison.reference.response.eta,
        "measured": {
            "samples": len(comparison.measurement),
            **record(comparison, "periods", frame="measurement.frame", left_out="measurement.left_out"),
            **found,
        },
        "reference": _solution_json(comparison.reference),
        "penalty": _solution_json(comparison.penalty),
        "fit": fitted and _fit_json(fitted),
        "verdict": measured_verdict(comparison),
    }


def _solution_json(solution: Solved) -> dict:
    return {
        "status": str(solution.response.status),
        **record(solution, "period", "impacts_per_period", "contact_share"),
        **record(solution.alignment, "rms", "phase", "offset", "closing_error"),
        **record(solution.alignment, closings_seen_per_period="sensor.per_period", contact_share_seen="sensor.share"),
    }


def _fit_json(fitted: Fit) -> dict:
    names = [name for name, error in fitted.errors.items() if math.isfinite(error)]
    return {
        "correlation": {"names": names, "matrix": fitted.correlation},
        **record(fitted, "values", "errors", "deviation", "noise", "starts", "agreeing", "remarks"),
    }


def lines_of(comparison: MeasuredComparison, fitted: Fit | None, scale: Units | None) -> Iterator[str]:
    """The comparison as text, times and lengths in these units."""
    # here, so that a comparison without a measurement need not wait for it
    from vibroscope.app.explorer.measured import comparison_rows, fit_rows, headline

    yield headline(comparison)
    if fitted:
        yield from _table(fit_rows(fitted, scale))
        yield from (joined("", ("note: ", remark)) for remark in fitted.remarks)
        if {"K", "D"} & fitted.values.keys() and comparison.penalty.response.method.has_step:
            yield "note: K and D are fitted to the solution without a step; that of the table below has one"
    yield from _table(comparison_rows(comparison, scale))
    yield measured_verdict(comparison)


def _table(rows: list[list[str]]) -> Iterator[str]:
    """The rows of a table, each column as wide as its longest cell."""
    widths = [max(least, *(len(str(row[i])) + 2 for row in rows)) for i, least in enumerate(_COLUMNS[: len(rows[0])])]
    for row in rows:
        yield "".join(f"{cell:{width}}" for cell, width in zip(row, widths, strict=True)).rstrip()
