"""``vibroscope transient``: both solutions under a pulse, a sweep or a record, from rest."""

import argparse
import math
from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import partial

import numpy as np
from vibroscope.app.commands.compare_measured import add_measured_options, measured_report, refuse_without_measurement
from vibroscope.app.commands.numbers import Measured, Read, list_of, measured, span
from vibroscope.app.commands.options import (
    PENALTY_OPTIONS,
    SCHEME_OPTIONS,
    add_fields,
    add_initial_option,
    add_system_option,
    law_of,
    note_unused,
    reference_of,
    refuse_missing,
    stepping_of,
)
from vibroscope.app.commands.parser import Command, OneLineParser
from vibroscope.app.commands.peaks import peaks_in_units, table_of_peaks
from vibroscope.app.commands.physical_units import add_units_option, unit_names, wanted_units
from vibroscope.app.commands.report import Line, Report, Row, rows, write_csv
from vibroscope.app.explorer.load_words import words_of_contact, words_of_difference, words_of_load, words_of_run
from vibroscope.app.export.tables import columns_in_units
from vibroscope.app.studies.peaks import impacts_note
from vibroscope.engine import (
    Difference,
    ExactPenalty,
    Load,
    Method,
    Transient,
    Units,
    absolute_accelerations,
    read_record,
    shock_response,
    spaced,
    transient,
    transient_difference,
)
from vibroscope.engine.energy.events import EnergyBalance
from vibroscope.engine.facts import Amount, Statement, joined, message_of, print_statement, stated
from vibroscope.engine.transients.run import CYCLE, FREE_CYCLES

# Of each pulse: the numbers after its size, their quantities, an example, and what it is.
PULSES = {
    "half-sine": (Load.half_sine, ("time",), "T", "half a sine of the duration T"),
    "trapezoid": (Load.trapezoid, ("time", "time"), "T[,R]", "a trapezoid of the duration T, which rises in R (T/10)"),
    "sawtooth": (Load.sawtooth, ("time",), "T", "a terminal-peak sawtooth of the duration T"),
    "sweep": (Load.sweep, ("frequency", "frequency", "time"), "F1,F2,T", "a sine from the frequency F1 to F2 in T"),
}
KINDS = {"base": ("acceleration", "acceleration of the base"), "force": ("force", "force on a body")}
MOTIONS = ("displacement", "velocity", "acceleration")
HISTORY = {"time": "time", **{f"{what}{body}": what for what in MOTIONS for body in (1, 2)}, "force": "force"}
_WITHOUT_STEP = "without a step"
_IN_HERTZ = "'5 Hz:500 Hz:100'"
_EXAMPLES = """\
examples:
  vibroscope transient --system box.toml --base-half-sine '30 g,11 ms' --units
  vibroscope transient --system box.toml --base-half-sine '30 g,11 ms' --K '1e6 N/m' --D '40 N s/m' --steps '0.1 ms'
  vibroscope transient --system pair.toml --base-record quake.csv --K '93 MN/m' --D '1 MN s/m' --history motion.csv
  vibroscope transient --system box.toml --base-sawtooth '50 g,6 ms' --shock-response '5 Hz:500 Hz:100' --write srs.csv
"""


def add(command: OneLineParser) -> None:
    """Add the options."""
    group = command.add_mutually_exclusive_group(required=True)
    for what, (quantity, shown) in KINDS.items():
        for name, (_, more, letters, words) in PULSES.items():
            read = partial(list_of, example=f"A,{letters}", quantities=(quantity, *more))
            words = f"{shown} of the peak A: {words}"
            group.add_argument(f"--{what}-{name}", type=read, metavar=f"A,{letters}", help=words)
        words = f"{shown} over time, linear between the samples of a file (.csv, or .AT2 of PEER)"
        group.add_argument(f"--{what}-record", metavar="FILE", help=words)
    add = command.add_argument
    add("--logarithmic", action="store_true", help="a sweep grows by equal factors in equal times, not linearly")
    add("--body", type=int, choices=(1, 2), help="the body that a force acts on (default 1)")
    words = f"time for which the run goes on after the load (default {FREE_CYCLES:g} natural periods of body 1)"
    add("--free", type=measured("time"), metavar="T", help=words)
    add_fields(command, *PENALTY_OPTIONS, *SCHEME_OPTIONS, "joint_damping", "threshold")
    command.set_defaults(eta=1.0)  # steps are those of a natural period of body 1
    add_initial_option(command)
    add_system_option(command)
    words = "also the energy balance of each run, in closed form (some seconds for a record of 100,000 samples)"
    add("--energy", action="store_true", help=words)
    add_measured_options(command)
    add("--history", metavar="FILE.csv", help="also write displacements, velocities, accelerations and force over time")
    add(
        "--shock-response",
        type=_frequencies,
        metavar="A:B:N",
        help="with --write: N natural frequencies of body 1 from A to B, by its spring; the largest motion of body 1 "
        "with the stop and alone. Its damping ratio, the clearances, K, D, the time step and body 2 stay. Beside a "
        f"system in physical units give {_IN_HERTZ}, else multiples of omega1, as 0.1:10:41",
    )
    add("--write", metavar="FILE.csv", help="where --shock-response goes")
    add_units_option(command)


def _frequencies(text: str) -> tuple[Read, Read, float, bool]:
    """``A:B:N``, and whether an end has a unit."""
    low, high, count = span(text, "frequency", f"A:B:N, as {_IN_HERTZ}, or 0.1:10:41 in multiples of omega1")
    return low, high, count, any(isinstance(end, Measured) for end in (low, high))


def load_of(options: argparse.Namespace) -> Load:
    """The load that the options describe."""
    for what in KINDS:
        on = what if what == "base" else f"{what}{options.body or 1}"
        path = getattr(options, f"{what}_record")
        if path is not None:
            return read_record(path, options.file.units, on, options.file.has_units)
        for name, (make, *_) in PULSES.items():
            numbers = getattr(options, f"{what}_{name.replace('-', '_')}")
            if numbers is not None:
                more = {"logarithmic": options.logarithmic} if name == "sweep" else {}
                wanted = len(PULSES[name][1]) + 1
                if not (len(numbers) == wanted or (name == "trapezoid" and len(numbers) == wanted - 1)):
                    raise ValueError(f"--{what}-{name} has {len(numbers)} numbers: give A,{PULSES[name][2]}")
                return make(*numbers, **more, on=on)
    raise ValueError("give a load, as --base-half-sine A,T")


def penalty_of(options: argparse.Namespace) -> Method | None:
    """The penalty solution: with steps, or without a step where none are given; None without K."""
    if options.K is None:
        return None
    refuse_missing(options, "exact")  # without steps it is the solution without a step
    if options.steps is not None:
        return stepping_of(options)
    return ExactPenalty(options.K, options.D, **law_of(options))


def run(options: argparse.Namespace) -> Report:
    """Run the reference, the penalty solution if K is given, and what else is asked for."""
    if (options.shock_response is None) != (options.write is None):
        raise ValueError(f"--shock-response and --write go together: give frequencies, as {_IN_HERTZ}, and a file")
    system, load, penalty, units = options.file.system, load_of(options), penalty_of(options), wanted_units(options)
    if load.on == "base":
        note_unused(options, ["body"], "on a motion of the base, which moves every body")
    if options.base_sweep is None and options.force_sweep is None:
        note_unused(options, ["logarithmic"], "on a load that is no sweep")
    if options.measured is not None:
        note_unused(options, ["free", "energy", "history", "shock_response", "write"], "with --measured")
        return measured_report(options, replace(system, excitation=replace(system.excitation, load=load)))
    refuse_without_measurement(options)
    reference = reference_of(options)
    given = {"free": FREE_CYCLES * CYCLE if options.free is None else options.free, "initial": options.initial}
    if options.shock_response is not None:
        _write_shock_response(options, load, penalty or reference)
    runs, parts, exact = {"reference": transient(system, load, reference, **given)}, None, None
    if penalty is not None:
        runs["penalty"] = transient(system, load, penalty, **given)
        if all(each.ok for each in runs.values()):
            found = transient_difference(system, load, penalty, reference, **given)
            parts, exact = found.difference, found.exact if penalty.has_step else None
    if options.history:
        _write_history(options.history, runs, units)
    energies = {name: each.energy for name, each in runs.items() if options.energy and each.ok}
    data = {"load": _load_json(load)} | {name: _json(each, energies.get(name)) for name, each in runs.items()}
    data["without_step"] = exact and exact.peaks
    data["difference"] = parts and {"total": parts.total, "parts": parts.parts}
    if units:
        physical = {name: peaks_in_units(each.peaks, units) for name, each in runs.items() if each.ok}
        physical["without_step"] = exact and peaks_in_units(exact.peaks, units)
        data["physical"] = {"units": unit_names(units, penalty or reference), **physical}
    return Report(_lines(runs, load, energies, parts, exact, units), data, units)


def _load_json(load: Load) -> dict[str, object]:
    return {"words": load.words, "on": load.on, "peak": load.peak, "end": load.end}


def _json(found: Transient, energy: EnergyBalance | None) -> dict[str, object]:
    response = found.response
    data = {"status": str(response.status), "message": str(response.message), "end": response.window[1]}
    if not found.ok:
        return data
    terms = "gain", "work", "dampers", "contact", "impacts", "residual"
    return data | {
        "peaks": found.peaks,
        "impacts": len(response.impacts),
        "contacts": len(response.contacts),
        "residual": list(found.residual),
        "later_peaks": found.later_peaks.tolist(),
        "load_missed": found.load_missed,
        "in_contact": found.in_contact,
        "energy": energy and {name: getattr(energy, name).sum() for name in terms},
    }


def _lines(
    runs: dict[str, Transient],
    load: Load,
    energies: dict[str, EnergyBalance],
    parts: Difference | None,
    exact: Transient | None,
    units: Units | None,
) -> Iterator[Line]:
    whole = {name: each for name, each in runs.items() if each.ok}
    first = next(iter(runs.values())).response
    yield Row("load", words_of_load(load, first.window[1]))
    tabled = whole if exact is None else whole | {_WITHOUT_STEP: exact}
    yield from table_of_peaks({name: each.peaks for name, each in tabled.items()}, units, first.system)
    for name, each in whole.items():
        yield Row(name, words_of_run(each))
        if name not in energies:
            continue
        yield Row("", stated("energy: {}", _words_of_energy(energies[name])))
    if parts is not None:
        yield Row("difference", words_of_difference(parts), 110)
        yield from rows({"contact": words_of_contact(*runs.values())}, width=110)
    if exact is not None:
        yield f'What "penalty" has beyond "{_WITHOUT_STEP}" comes of its time step: K and D are the same.'
    yield "Displacements and velocities are relative to the base, accelerations absolute."
    if "reference" in whole:
        yield from filter(None, [impacts_note(whole["reference"].peaks)])
    yield from (stated("{}: {}", name, each.response.ending) for name, each in runs.items() if not each.ok)


def _words_of_energy(energy: EnergyBalance) -> Statement:
    """Where the work of the load has gone, as an equation."""

    def sum_of(sums: dict[str, np.ndarray]) -> Statement:
        terms = (stated("{} {}", label, Amount(float(value.sum()), "energy")) for label, value in sums.items())
        return joined(" + ", terms)

    brought = {"work of the load": energy.work, "not balanced": energy.residual}
    spent = {"dampers": energy.dampers, "contact": energy.contact + energy.impacts, "gain of the bodies": energy.gain}
    return stated("{} = {}", sum_of(brought), sum_of(spent))


def _write_history(path: str, runs: dict[str, Transient], units: Units | None) -> None:
    rows = []
    for name, each in runs.items():
        sampled = each.response.trajectory
        if sampled is None:
            raise ValueError(f"--history needs whole runs; {name}: {each.response.ending}")
        moved = *sampled.displacement, *sampled.velocity, *absolute_accelerations(each.response)
        columns = dict(zip(HISTORY, (sampled.time, *moved, sampled.force), strict=True))
        columns = columns_in_units(columns, units, HISTORY)
        rows += [[name, *row] for row in np.transpose(list(columns.values())).tolist()]
    write_csv(path, ["solution", *columns], _cells(rows))


def _write_shock_response(options: argparse.Namespace, load: Load, method: Method) -> None:
    low, high, count, in_units = options.shock_response
    if options.file.has_units and not in_units:
        raise ValueError(
            "--shock-response without a unit would count in multiples of omega1, and the system is in physical units: "
            f"give each end its unit, as {_IN_HERTZ}"
        )
    ratios, units = spaced("frequency", low, high, int(count), logarithmic=True), wanted_units(options)
    try:
        found = shock_response(options.file.system, load, ratios, method)
    except ValueError as error:
        raise ValueError(print_statement(message_of(error), units)) from None
    columns = dict(vars(found))
    if units is not None:
        columns = {"frequency" if name == "ratio" else name: values for name, values in columns.items()}
        quantities = {name: name.partition("_")[0] for name in columns}
        columns = columns_in_units(columns, units, quantities)
    write_csv(options.write, list(columns), _cells(np.transpose(list(columns.values())).tolist()))


def _cells(rows: Sequence[Sequence[object]]) -> Iterator[list[object]]:
    """Numbers with nine digits; nothing where there is none."""
    for row in rows:
        yield [x if not isinstance(x, float) else "" if math.isnan(x) else f"{x:.9g}" for x in row]


COMMAND = Command(
    "both solutions under a pulse, a sweep or a record, from rest",
    "Run the reference, and with --K the penalty solution, from rest under a load that is no harmonic: largest values, "
    "contacts, what is left of the motion, energy, and the parts of the difference. --steps are those in a natural "
    "period of body 1. With --measured both are compared with a measurement from the start.",
    _EXAMPLES,
    add,
    run,
    "one JSON object",
)
