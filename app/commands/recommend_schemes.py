"""``vibroscope recommend`` with ``--integrator all``, ``--law all`` or ``--code NAME``: many searches, a table of them.

The best comes first.
"""

import argparse
import copy
from collections.abc import Callable
from dataclasses import fields

from vibroscope.app.codes.catalogue import Code
from vibroscope.app.commands.codes import code_alone
from vibroscope.app.commands.options import INTEGRATOR_NUMBERS, LAW_OPTIONS, eta_of, stepping_of, system_of
from vibroscope.app.commands.output import note
from vibroscope.app.commands.recommendation_text import CONSTANT, CUT, as_json, lines_of, met_words
from vibroscope.app.commands.report import Line, Report, Row, rows
from vibroscope.engine import (
    CONTACT_LAWS,
    INTEGRATORS,
    Recommendation,
    TimeStepping,
    Units,
    counted,
    percent,
    recommend_schemes,
    with_located_steps,
    written,
)
from vibroscope.engine.law_table import NEEDED, numbers_of

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
    searched = _searched(options)
    every = {"integrator": _every_scheme, "law": _every_law}[searched]
    schemes = code.schemes() if code else every(options)
    system, eta = system_of(options), eta_of(options)
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
        "leaves_out": _leaves_out(code),
    }
    head = f"{code.name} ({code.key}): what it has" if code else f"every {searched}"
    lines: list[Line] = [f"{head}; eta = {best.eta:g}, tolerance {percent(best.tolerance)}"]
    lines.append(_COLUMNS.format(searched, "status", "K", "D", "steps", "solves", "error", "robust", "met").rstrip())
    lines += [_row(each, searched) for each in found]
    if len({each.scheme.located for each in found}) == 2:
        lines.append(f"located           for {CUT}; the other rows are for {CONSTANT}")
    lines += ["", *lines_of(best, units)]
    lines += [Row("" if i else "what to set", line) for i, line in enumerate(words)]
    lines += rows({"not computed here": _leaves_out(code)})
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
        schemes.append(stepping_of(own, K=1.0, D=0.0, steps=1000))
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
        for number in given.keys() - {each.name for each in fields(kind)}:
            setattr(own, number, None)
        if kind.explicit and options.status == "end":
            note(f"{name} knows the gap before the force: its status is that at the start")
            own.status = own.without_solution = None
        schemes.append(stepping_of(own, K=1.0, D=0.0, steps=1000))
    if not options.located and options.status is None:
        schemes += [with_located_steps(each) for each in schemes]
    return schemes


def _numbers(scheme: TimeStepping) -> dict[str, float]:
    return {each.name: getattr(scheme.integrator, each.name) for each in fields(scheme.integrator)}


def _leaves_out(code: Code | None) -> str:
    return "" if code is None else code.leaves_out


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
