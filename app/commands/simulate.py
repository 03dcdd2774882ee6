"""``vibroscope simulate``: run one solver and print its motion."""

from __future__ import annotations

import argparse
import json
from collections.abc import Sequence
from contextlib import suppress

import numpy as np
from vibroscope import engine
from vibroscope.app.commands.numbers import count
from vibroscope.app.commands.options import (
    OF_SOLVERS,
    add_integrator_options,
    add_solver_options,
    default_of,
    problem_of,
)
from vibroscope.app.commands.physical_units import add_units_option, physical_run, settings_text, wanted_units
from vibroscope.engine import Response, simulate

_KEEP = default_of(simulate, "keep")
STILL = 1e-9  # of the way from its start, below which a free vibration has come to rest


def add(commands) -> None:
    """Describe ``vibroscope simulate``."""
    command = commands.add_parser(
        "simulate",
        allow_abbrev=False,
        help="run one solver and print its motion",
        description="Run one solver from rest (or --initial) and report the last --keep periods. All numbers are "
        "non-dimensional: time is counted in 1/omega1, lengths in base amplitudes.",
        epilog="A run that blows up prints its status and the step; the exit status is 2 only for bad input.",
    )
    add_solver_options(command)
    add = command.add_argument
    add_integrator_options(command, **OF_SOLVERS)
    add("--periods", type=count, metavar="N", help="excitation periods to run (default %(default)s)")
    add("--keep", type=count, metavar="N", help=f"last periods to report (default {_KEEP}, or all if fewer are run)")
    add(
        "--steady",
        action="store_true",
        help="reference, exact: find the steady motion without its transient (Newton's method on the Poincare map); "
        "if there is none, the usual run; --periods and --keep have no effect",
    )
    add_units_option(command)
    add("--json", action="store_true", help="print one JSON object")
    command.set_defaults(run=run, periods=default_of(simulate, "periods"))


def run(options: argparse.Namespace) -> None:
    """Simulate and print."""
    problem = problem_of(options)
    keep = min(_KEEP, options.periods) if options.keep is None else options.keep
    if options.steady:
        found = engine.steady(*problem, initial=options.initial)
        response, to_json, to_text = found.response, steady_json, steady_text
    else:
        found = response = simulate(*problem, periods=options.periods, keep=keep, initial=options.initial)
        to_json, to_text = as_json, as_text
    units = wanted_units(options)
    if options.json:
        physical = {"physical": physical_run(units, response)} if units else {}
        print(json.dumps(to_json(found, options.solver) | physical, allow_nan=False))
    else:
        print(to_text(found, options.initial))
        if units:
            print(f"physical          {settings_text(units, response.eta, response.method)}")


def as_json(response: Response, solver: str) -> dict:
    """A run as JSON for scripts."""
    impacts = response.impacts
    return {
        "solver": solver,
        "eta": response.eta,
        "periods": response.periods,
        "keep": response.keep,
        "status": str(response.status),
        "message": response.message,
        "section": response.section.tolist(),
        "impacts": [list(pair) for pair in zip(impacts.time.tolist(), impacts.closing_speed.tolist(), strict=True)],
        "contacts": response.contacts.tolist(),
        "seconds": response.cost.seconds,
        "steps_without_solution": response.steps_without_solution,
        "steps_with_two": response.steps_with_two,
    }


def steady_json(found: engine.Steady, solver: str) -> dict:
    """A steady motion as JSON: a run whose section holds one cycle, or the usual run where no cycle was found."""
    report = as_json(found.response, solver)
    return report | {
        "message": report["message"] or found.message,
        "periodic": found.periodic,
        "period": found.period,
        "multipliers": [[value.real, value.imag] for value in found.multipliers.tolist()],
        "residual": found.residual if found.periodic else None,
        "periods_run": found.periods,
    }


def steady_text(found: engine.Steady, initial: Sequence[float] | None = None) -> str:
    """A steady motion as text."""
    if not found.periodic:
        return f"{as_text(found.response, initial)}\n{found.message}"
    response, p = found.response, found.period
    begin, end = response.window
    spans = response.contacts.clip(begin, end)
    share = (spans[:, 1] - spans[:, 0]).sum() / (end - begin)
    begun = (response.contacts[:, 0] > begin).sum()
    multipliers = ", ".join(
        f"{value:.6g}" if value.imag else f"{value.real:.6g}" for value in found.multipliers.tolist()
    )
    state = ", ".join(f"{value:.6g}" for value in found.state)
    return "\n".join(
        [
            _head(response),
            f"eta = {response.eta:g}, steady motion found by running {found.periods} periods",
            f"motion            repeats every {'period' if p == 1 else f'{p} periods'}, to {found.residual:.2g}",
            f"multipliers       {multipliers}, {'stable' if found.stable else 'unstable'}",
            f"impacts           {len(response.impacts) / p:g} per period",
            f"contacts          {begun / p:g} per period, {100 * share:.2f} % of the time",
            f"section           xi1, xi1', xi2, xi2' = {state}",
        ]
    )


def _head(response: Response) -> str:
    """What was run, in words."""
    from vibroscope.app.explorer.method_words import full_words  # for people: scripts need not wait for it

    return full_words(response.method, wall=response.system.wall)


def as_text(response: Response, initial: Sequence[float] | None = None) -> str:
    """A run as text; ``initial``: where it began."""
    lines = [
        _head(response),
        f"eta = {response.eta:g}, {response.periods} periods, the last {response.keep} kept",
        f"solved in {response.cost.seconds * 1e3:.2f} ms",
    ]
    if not response.ok:
        return "\n".join([*lines, f"{response.status}: {response.message}"])
    found = engine.motion(response)
    last = ", ".join(f"{value + 0.0:.6g}" for value in response.section[-1])  # -0 is 0
    lines += [
        f"motion            {_motion_text(response, found, initial)}",
        f"impacts           {found.impacts_per_period:g} per period",
        f"contacts          {found.contacts_per_period:g} per period, {100 * found.contact_share:.2f} % of the time",
        f"section at end    xi1, xi1', xi2, xi2' = {last}",
    ]
    if response.method.counts_solutions:
        none, two = response.steps_without_solution, response.steps_with_two
        lines.append(f"status at the end  {none} steps without a solution, {two} with two")
    fact = engine.touching(found)
    return "\n".join([*lines, f"result            {fact}"] if fact else lines)


def _is_at_rest(response: Response, initial: Sequence[float] | None) -> bool:
    """Whether a free vibration moves by less than STILL of the way from its start in the kept periods."""
    start = np.array(response.system.rest if initial is None else initial, dtype=float)
    end = response.section[-1]
    moved = np.abs(response.section[:, [0, 2]] - end[[0, 2]]).max()
    return bool(max(moved, np.abs(end[[1, 3]]).max()) <= STILL * np.abs(start - end).max())


def _motion_text(response: Response, found: engine.Motion, initial: Sequence[float] | None) -> str:
    """The kind of motion; the section alone does not show it where a time step may have blurred it."""
    method = response.method
    if not response.system.excitation.drives:  # T is then no time of the motion, which cannot repeat in it
        return f"free vibration, {'come to rest' if _is_at_rest(response, initial) else 'still moving'}"
    if method.has_step and found.period != 1 and response.keep >= _KEEP:
        with suppress(ValueError):  # the engine does not judge such a motion
            return engine.repetition(engine.motion(response.system, response.eta, method, initial=initial))
    if not found.near_period and response.keep < 4:
        return f"{response.keep} kept periods are too few to show a cycle"
    return f"{engine.repetition(found)}{'' if found.near_period else f' within {response.keep // 2} periods'}"
