"""``vibroscope motion``: what moves, by name and with the evidence."""

import argparse
import json
import sys
from textwrap import wrap

from vibroscope.app.commands.options import add_solver_options, default_of, problem_of
from vibroscope.app.commands.physical import add_units_option, motion_in, motion_text, settings_text, wanted_units
from vibroscope.engine import Attractor, Motion, attractors, motion

_INDENT = 18 * " "
_SEARCH = {name: default_of(attractors, name) for name in ("starts", "seed")}


def add(commands) -> None:
    """``vibroscope motion``."""
    command = commands.add_parser(
        "motion",
        allow_abbrev=False,
        help="say what moves: periodic, quasi-periodic or chaotic, with the evidence",
        description="Find what a run from rest (or --initial) settles to: its period with Floquet multipliers and the "
        "bifurcation it is near, or its largest Lyapunov exponent. A Newmark band that shrinks with the time step is "
        "called an artefact. All numbers are non-dimensional.",
        epilog="A motion that cannot be told is undecided, and a run that blows up diverged; the exit status is 2 only "
        "for bad input.",
    )
    add_solver_options(command)
    add = command.add_argument
    add("--attractors", action="store_true", help="look for other motions at the same parameters, from many starts")
    add("--starts", type=float, metavar="N", help=f"with --attractors: how many (default {_SEARCH['starts']})")
    add("--seed", type=int, metavar="N", help=f"with --attractors: of the random starts (default {_SEARCH['seed']})")
    add_units_option(command)
    add("--json", action="store_true", help="print one JSON object")
    command.set_defaults(run=run)


def run(options: argparse.Namespace) -> None:
    """Find, and print."""
    problem, units = problem_of(options), wanted_units(options)
    found = motion(*problem, initial=options.initial)
    others: tuple[Attractor, ...] = ()
    given = {name: getattr(options, name) for name in _SEARCH if getattr(options, name) is not None}
    if options.attractors:
        search = _SEARCH | given
        progress = _progress(search["starts"]) if sys.stderr.isatty() else None
        others = attractors(*problem, **search, progress=progress)
    elif given:
        named = ", ".join(f"--{name}" for name in given)
        print(f"vibroscope: {named} has no effect without --attractors", file=sys.stderr)
    if options.json:
        head = {"solver": options.solver, "eta": options.eta, **found.as_dict()}
        if options.attractors:
            head["attractors"] = [
                {"share": each.share, "start": each.start.tolist(), **each.motion.as_dict()} for each in others
            ]
        if units:
            head["physical"] = {"settings": units.settings(*problem[1:]), **motion_in(units, found)}
        print(json.dumps(head, allow_nan=False))
    else:
        lines = [f"{problem[2]}, eta = {options.eta:g}", *_lines(found)]
        if units:
            told = (settings_text(units, *problem[1:]), motion_text(units, found))
            lines += [f"physical          {line}" for line in told if line]
        print("\n".join([*lines, *_shares(others)]))


def _progress(starts: float):
    return lambda done: print(f"\r{done} of {starts:g} starts", end="\n" if done == starts else "", file=sys.stderr)


def _lines(found: Motion) -> list[str]:
    """A motion for people."""
    name = f"{found.type}, {_periods(found.period)}" if found.period else str(found.type)
    lines = [f"motion            {name}", *wrap(found.reason, 100, initial_indent=_INDENT, subsequent_indent=_INDENT)]
    if not found.impacts_per_period >= 0:
        return lines
    lines += [
        f"impacts           {found.impacts_per_period:.4g} per period",
        f"contacts          {_rate(found.contacts_per_period, found.contact_share)}",
        f"lasting contacts  {_rate(found.permanent_per_period, found.permanent_share)}",
    ]
    if found.period and not found.step_noise and len(found.impact_phases):
        at = ", ".join(f"{phase:.4f}" for phase in found.impact_phases[:12])
        speeds = ", ".join(f"{speed:.3g}" for speed in found.closing_speeds[:12])
        lines += [f"impacts at        {at} periods", f"closing speeds    {speeds}"]
    lines += [f"each period       impulse {_known(found.impulse)}, energy lost {_known(found.energy_lost)}"]
    lines += [f"peak force        {_known(found.peak_force)}"]
    if len(found.multipliers):
        values = ", ".join(f"{m:.5g}" if m.imag else f"{m.real:.5g}" for m in found.multipliers.tolist())
        lines += [f"multipliers       {values}", f"nearest           {found.bifurcation}, {found.margin:.3g} off"]
    error = f" ± {found.lyapunov_error:.2g}" if found.lyapunov_error > 0 else ""
    lines += [f"Lyapunov          {_known(found.lyapunov)}{error} per period"]
    return lines


def _rate(begun: float, share: float) -> str:
    return f"{begun:.4g} per period, {100 * share:.2f} % of the time"


def _shares(others: tuple[Attractor, ...]) -> list[str]:
    lines = []
    for each in others:
        moves = each.motion
        name = f"{moves.type}, {_periods(moves.period)}" if moves.period else str(moves.type)
        start = ", ".join(f"{value:.4g}" for value in each.start)
        lines.append(
            f"{100 * each.share:5.1f} % of starts  {name}, {_known(moves.impacts_per_period)} impacts per period; "
            f"first from {start}"
        )
    return lines


def _periods(count: int) -> str:
    return "1 period" if count == 1 else f"{count} periods"


def _known(value: float) -> str:
    return f"{value:.4g}" if value == value else "not known"
