"""``vibroscope compare --measured FILE.csv`` and ``vibroscope measurement``: solutions beside measured motion."""

import argparse
import json

from vibroscope.app.commands.options import add_system_option, reference_of, system_of, units_of
from vibroscope.engine import (
    FITTED,
    Fit,
    MeasuredComparison,
    Newmark,
    Solved,
    compare_measured,
    fit,
    measured_verdict,
    measurement_text,
    read_measurement,
    synthetic_measurement,
)


def add(commands) -> None:
    """``vibroscope measurement``."""
    command = commands.add_parser(
        "measurement",
        allow_abbrev=False,
        help="print an example of a measurement as CSV: made by the reference plus noise, not measured",
        description="Print a CSV file as `vibroscope compare --measured` takes it, made by the reference plus noise.",
    )
    add_option = command.add_argument
    add_option("--eta", type=float, default=2.76, metavar="F", help="excitation frequency (default %(default)s)")
    add_option("--periods", type=int, default=4, metavar="N", help="excitation periods (default %(default)s)")
    add_option("--per-period", type=int, default=120, metavar="N", help="samples of each (default %(default)s)")
    add_option(
        "--noise",
        type=float,
        default=0.02,
        metavar="F",
        help="standard deviation in base amplitudes (default %(default)s)",
    )
    add_option("--phase", type=float, default=0.7, metavar="F", help="tau at which it begins (default %(default)s)")
    add_option(
        "--seed", type=int, default=1, metavar="N", help="the same seed gives the same noise (default %(default)s)"
    )
    add_system_option(command)
    command.set_defaults(run=write)


def write(options: argparse.Namespace) -> None:
    """Make and print the example."""
    if options.seed < 0:
        raise ValueError(f"seed = {options.seed} is outside [0, inf): give a whole number")
    system, units = system_of(options), units_of(options)
    made = synthetic_measurement(
        system,
        options.eta,
        periods=options.periods,
        per_period=options.per_period,
        noise=options.noise,
        phase=options.phase,
        seed=options.seed,
    )
    comment = (
        "NOT MEASURED: the semi-analytical reference plus normal noise, made by `vibroscope measurement`\n"
        f"eta = {options.eta:g}, restitution = {system.restitution:g}, noise of {options.noise:g} base amplitudes, "
        f"seed {options.seed}\n"
        f"omega1 = {units.omega1:g} 1/s, base amplitude {units.base_amplitude:g} mm; x1, x2 as a fixed sensor sees them"
    )
    print(measurement_text(made, units, comment), end="")


def add_measured_options(command: argparse.ArgumentParser) -> None:
    """``--measured`` and ``--fit``, for :func:`run`."""
    command.add_argument(
        "--measured",
        metavar="FILE.csv",
        help="compare with a measurement instead: columns time [s], x1 [mm], x2 [mm] and perhaps contact (0 or 1), "
        "or xi1, xi2 relative to the base; [-] or no unit: without dimension",
    )
    command.add_argument(
        "--fit",
        nargs="?",
        const=",".join(FITTED),
        type=fitted,
        metavar="NAMES",
        help=f"with --measured: fit these to it first (default {','.join(FITTED)})",
    )


def fitted(text: str) -> tuple[str, ...]:
    """Names of constants, parted by commas."""
    names = tuple(part.strip() for part in text.split(","))
    wrong = [name for name in names if name not in FITTED]
    if wrong or len(set(names)) < len(names):
        raise argparse.ArgumentTypeError(f"{text!r} cannot be fitted: give some of {','.join(FITTED)}, each once")
    return names


def run(options: argparse.Namespace) -> None:
    """Lay both solutions over the measurement and print; after ``--fit``, those of the fitted system."""
    measurement = read_measurement(options.measured, units_of(options))
    system = system_of(options)
    found = None
    if options.fit:
        found = fit(system, options.eta, measurement, names=options.fit)
        system = found.system
    compared = compare_measured(
        system,
        options.eta,
        measurement,
        Newmark(options.K, options.D, options.steps, located=options.located),
        reference=reference_of(options),
        periods=options.periods,
    )
    if options.json:
        print(json.dumps(as_json(compared, found), allow_nan=False))
    else:
        print(as_text(compared, found))


def as_json(compared: MeasuredComparison, found: Fit | None = None) -> dict:
    """The contract for scripts."""
    told = compared.recurrence
    return {
        "eta": compared.reference.response.eta,
        "measured": {
            "samples": len(compared.measurement),
            "periods": compared.periods,
            "frame": compared.measurement.frame,
            "period": told.period,
            "noise": told.noise,
            "eta": told.eta if told.period else None,
            "strongest": told.strongest,
            "closings_per_period": told.sensor and told.sensor.per_period,
            "contact_share": told.sensor and told.sensor.share,
        },
        "reference": _solved(compared.reference),
        "penalty": _solved(compared.penalty),
        "fit": found and _fit(found),
        "verdict": measured_verdict(compared),
    }


def _solved(solved: Solved) -> dict:
    aligned = solved.alignment
    return {
        "status": str(solved.response.status),
        "period": solved.period,
        "impacts_per_period": solved.impacts_per_period,
        "contact_share": solved.contact_share,
        "rms": aligned and aligned.rms,
        "phase": aligned and aligned.phase,
        "offset": aligned and aligned.offset.tolist(),
        "closings_seen_per_period": aligned and aligned.sensor.per_period,
        "contact_share_seen": aligned and aligned.sensor.share,
        "closing_error": aligned and aligned.closing_error,
    }


def _fit(found: Fit) -> dict:
    shown = [name for name, error in found.errors.items() if error < float("inf")]
    return {
        "values": found.values,
        "errors": {name: error if name in shown else None for name, error in found.errors.items()},
        "correlation": {"names": shown, "matrix": found.correlation.tolist()},
        "deviation": found.deviation,
        "noise": found.noise,
        "starts": found.starts,
        "agreeing": found.agreeing,
        "remarks": list(found.remarks),
    }


def as_text(compared: MeasuredComparison, found: Fit | None = None) -> str:
    """The same for people."""
    told = compared.recurrence
    lines = [
        f"eta = {compared.reference.response.eta:g}, {len(compared.measurement)} samples over {compared.periods:.3g} "
        f"periods, {compared.measurement.frame} displacements",
    ]
    if found is not None:
        lines += _fit_lines(found)
    sensor = told.sensor
    rows = [
        ("", "measured", "reference", "penalty"),
        ("repeats after", told.period, compared.reference.period, compared.penalty.period),
        ("rms off", f"{told.noise:.3g} noise", *_each(compared, lambda a: f"{a.rms:.2%}")),
        ("begins at tau", "", *_each(compared, lambda a: f"{a.phase:.4f}")),
        (
            "sensor closes",
            sensor and f"{sensor.per_period:.3g}",
            *_each(compared, lambda a: f"{a.sensor.per_period:.3g}"),
        ),
        ("sensor closed", sensor and f"{sensor.share:.2%}", *_each(compared, lambda a: f"{a.sensor.share:.2%}")),
        ("closings off", "", *_each(compared, lambda a: a.closing_error and f"{a.closing_error:.2%} of T")),
        ("mean off", "", *_each(compared, lambda a: ", ".join(f"{value:.2g}" for value in a.offset))),
    ]
    lines += ["".join(f"{'-' if cell is None else cell!s:20}" for cell in row).rstrip() for row in rows]
    return "\n".join([*lines, measured_verdict(compared)])


def _each(compared: MeasuredComparison, show) -> list[str | None]:
    both = compared.reference.alignment, compared.penalty.alignment
    return [None if aligned is None else show(aligned) for aligned in both]


def _fit_lines(found: Fit) -> list[str]:
    lines = []
    for name, value in found.values.items():
        error = found.errors[name]
        lines.append(
            f"{name:20}{value:.6g}" + (f" +- {error:.2g}" if error < float("inf") else ", not shown by the motion")
        )
    agreeing = f"{found.agreeing} of {found.starts} starts agree"
    lines.append(f"{'residual':20}{found.deviation:.3g}, noise {found.noise:.3g}; {agreeing}")
    return [*lines, *(f"note: {remark}" for remark in found.remarks)]
