"""``vibroscope simulate``: run one solver and print its motion."""

import argparse
from collections.abc import Iterator, Sequence
from contextlib import suppress
from itertools import chain

import numpy as np
from vibroscope import engine
from vibroscope.app.commands.options import add_run_length, add_solver_options, default_of, kept_periods, problem_of
from vibroscope.app.commands.parser import Command, OneLineParser
from vibroscope.app.commands.physical_units import (
    add_units_option,
    physical_part,
    physical_run,
    settings_text,
    wanted_units,
)
from vibroscope.app.commands.report import Line, Report, Row, record, rows
from vibroscope.app.explorer.method_words import full_words
from vibroscope.engine import Method, Response, System, counted, free_length, simulate

_KEEP = default_of(simulate, "keep")
_LAST = 4  # kept periods, by which a free vibration is seen to rest
STILL = 1e-9  # of the way from its start, below which a free vibration has come to rest


def add(command: OneLineParser) -> None:
    """Add the options."""
    add_solver_options(command)
    usual = (
        f"default {default_of(simulate, 'periods')}; where nothing drives the bodies {_KEEP}, or more until they meet"
    )
    add_run_length(command, usual, _KEEP)
    command.add_argument(
        "--steady",
        action="store_true",
        help="reference, exact: find the steady motion without its transient (Newton's method on the Poincare map); "
        "if there is none, the usual run; --periods and --keep have no effect",
    )
    add_units_option(command)


def run(options: argparse.Namespace) -> Report:
    """Simulate."""
    problem = problem_of(options)
    if options.steady:
        found = engine.steady(*problem, initial=options.initial)
        response, data, lines = found.response, steady_json(found, options.solver), steady_lines(found, options.initial)
    else:
        response = simulate(*problem, **_length(options, *problem), initial=options.initial)
        data, lines = as_json(response, options.solver), run_lines(response, options.initial)
    units = wanted_units(options)
    if units:
        data |= physical_part(units, response.eta, response.method, **physical_run(units, response))
        lines = chain(lines, [Row("physical", settings_text(units, response.eta, response.method))])
    return Report(lines, data)


def _length(options: argparse.Namespace, system: System, eta: float, _: Method) -> dict[str, int]:
    """Periods to run and to keep: of a free vibration from its start, at least to the first contact."""
    if options.periods is None and not system.excitation.drives:
        options.periods = max(_KEEP, free_length(system, eta, options.initial, contacts=1)["periods"])
    if options.periods is None:
        options.periods = default_of(simulate, "periods")
    return {"periods": options.periods, "keep": kept_periods(options, _KEEP)}


def as_json(response: Response, solver: str) -> dict:
    """A run as JSON for scripts."""
    impacts = response.impacts
    return {
        "solver": solver,
        **record(response, "eta", "periods", "keep"),
        "status": str(response.status),
        **record(response, "message", "section"),
        "impacts": np.column_stack([impacts.time, impacts.closing_speed]),
        **record(response, "contacts", seconds="cost.seconds"),
        **record(response, "steps_without_solution", "steps_with_two"),
    }


def steady_json(found: "engine.Steady", solver: str) -> dict:
    """A steady motion as JSON: a run whose section holds one cycle, or the usual run where no cycle was found."""
    report = as_json(found.response, solver)
    return report | {
        "message": report["message"] or found.message,
        **record(found, "periodic", "period", "multipliers"),
        "residual": found.residual if found.periodic else None,
        "periods_run": found.periods,
    }


def steady_lines(found: "engine.Steady", initial: Sequence[float] | None = None) -> Iterator[Line]:
    """A steady motion as text."""
    response, p = found.response, found.period
    if not found.periodic:
        yield from run_lines(response, initial)
        yield found.message
        return
    begin, end = response.window
    spans = response.contacts.clip(begin, end)
    share = (spans[:, 1] - spans[:, 0]).sum() / (end - begin)
    begun = (response.contacts[:, 0] > begin).sum()
    multipliers = ", ".join(f"{m:.6g}" if m.imag else f"{m.real:.6g}" for m in found.multipliers.tolist())
    yield full_words(response.method, wall=response.system.wall)
    yield f"eta = {response.eta:g}, steady motion found by running {found.periods} periods"
    yield from rows(
        {
            "motion": f"repeats every {'period' if p == 1 else f'{p} periods'}, to {found.residual:.2g}",
            "multipliers": f"{multipliers}, {'stable' if found.stable else 'unstable'}",
            "impacts": f"{len(response.impacts) / p:g} per period",
            "contacts": f"{begun / p:g} per period, {100 * share:.2f} % of the time",
            "section": f"xi1, xi1', xi2, xi2' = {', '.join(f'{value:.6g}' for value in found.state)}",
        }
    )


def run_lines(response: Response, initial: Sequence[float] | None = None) -> Iterator[Line]:
    """A run as text; ``initial``: where it began."""
    yield full_words(response.method, wall=response.system.wall)
    yield f"eta = {response.eta:g}, {response.periods} periods, the last {response.keep} kept"
    yield f"solved in {response.cost.seconds * 1e3:.2f} ms"
    if not response.ok:
        yield f"{response.status}: {response.message}"
        return
    found = engine.motion(response)
    last = ", ".join(f"{value + 0.0:.6g}" for value in response.section[-1])  # -0 is 0
    yield from rows(
        {
            "motion": _motion_text(response, found, initial),
            "impacts": _often(found.impacts_per_period, response),
            "contacts": f"{_often(found.contacts_per_period, response)}, {100 * found.contact_share:.2f} % of the time",
            "section at end": f"xi1, xi1', xi2, xi2' = {last}",
        }
    )
    if response.method.counts_solutions:
        none, two = response.steps_without_solution, response.steps_with_two
        yield f"status at the end  {none} steps without a solution, {two} with two"
    if response.system.excitation.drives:
        yield from rows({"result": engine.touching(found)})


def _often(per_period: float, response: Response) -> str:
    """How often something happens: a period, or where none belongs to the motion in all that is kept."""
    if response.system.excitation.drives:
        return f"{per_period:g} per period"
    return f"{round(per_period * response.keep)} in {counted(response.keep, 'period')}"


def _is_at_rest(response: Response, initial: Sequence[float] | None) -> bool:
    """Whether a free vibration moves by less than STILL of the way from its start in the last kept periods."""
    start = np.array(response.system.rest if initial is None else initial, dtype=float)
    end = response.section[-1]
    moved = np.abs(response.section[-_LAST:, [0, 2]] - end[[0, 2]]).max()
    return bool(max(moved, np.abs(end[[1, 3]]).max()) <= STILL * np.abs(start - end).max())


def _motion_text(response: Response, found: "engine.Motion", initial: Sequence[float] | None) -> str:
    """The kind of motion; the section alone does not show it where a time step may have blurred it."""
    method = response.method
    if not response.system.excitation.drives:  # T is then no time of the motion, which cannot repeat in it
        return f"free vibration, {'come to rest' if _is_at_rest(response, initial) else 'still moving'}"
    if method.has_step and found.period != 1 and response.keep >= _KEEP:
        with suppress(ValueError):  # the engine does not judge such a motion
            return engine.repetition(engine.motion(response.system, response.eta, method, initial=initial))
    if not found.near_period and response.keep < 4:
        return f"{response.keep} kept periods are too few to show a cycle"
    from vibroscope.engine.motions.words import of_section  # for people: scripts need not wait for it

    within = "" if found.near_period else f" within {response.keep // 2} periods"
    return of_section(f"{engine.repetition(found)}{within}", found.period, method.has_step)


COMMAND = Command(
    "run one solver and print its motion",
    "Run one solver from rest (or --initial) and report the last --keep periods. All numbers are non-dimensional: time "
    "is counted in 1/omega1, lengths in base amplitudes.",
    "A run that blows up prints its status and the step; the exit status is 2 only for bad input.",
    add,
    run,
    "one JSON object",
)
