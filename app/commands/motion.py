"""``vibroscope motion``: the kind of motion, by name and with the evidence."""

import argparse
from collections.abc import Iterator, Sequence

from vibroscope.app.commands.numbers import count
from vibroscope.app.commands.options import add_solver_options, default_of, problem_of
from vibroscope.app.commands.parser import Command, OneLineParser
from vibroscope.app.commands.physical_units import (
    add_units_option,
    motion_text,
    physical_motion,
    physical_part,
    settings_text,
    wanted_units,
)
from vibroscope.app.commands.report import Line, Report, Row, note, progress_line, rows
from vibroscope.app.explorer.method_words import has_peak_force, plain_motion
from vibroscope.engine import Attractor, Motion, Statement, attractors, counted, motion, repetition, touching
from vibroscope.engine.facts import joined

_MOST_IMPACTS = 12  # that are listed
_SEARCH = {name: default_of(attractors, name) for name in ("starts", "seed")}


def add(command: OneLineParser) -> None:
    """Add the options."""
    add_solver_options(command)
    add = command.add_argument
    add("--attractors", action="store_true", help="look for other motions at the same parameters, from many starts")
    add("--starts", type=count, metavar="N", help=f"with --attractors: how many (default {_SEARCH['starts']})")
    add("--seed", type=int, metavar="N", help=f"with --attractors: of the random starts (default {_SEARCH['seed']})")
    add_units_option(command)


def run(options: argparse.Namespace) -> Report:
    """Find the motion."""
    problem, units = problem_of(options), wanted_units(options)
    _, eta, method = problem
    found = motion(*problem, initial=options.initial)
    others = _find_attractors(options, problem)
    data = {"solver": options.solver, "eta": eta, **plain_motion(found)}
    if options.attractors:
        data["attractors"] = [
            {"share": each.share, "start": each.start, **plain_motion(each.motion)} for each in others
        ]
    lines: list[Line] = [f"{method}, eta = {eta:g}", *_motion_lines(found, problem[0].excitation.drives)]
    if units:
        data |= physical_part(units, eta, method, **physical_motion(units, found))
        physical = [settings_text(units, eta, method), motion_text(units, eta, found, method)]
        if _has_impact_list(found):
            speeds = _speeds_text(units.physical("velocity", found.closing_speeds))
            physical.append(f"closing speeds {speeds} {units.unit('velocity')}")
        lines += [Row("physical", text) for text in physical if text]
    return Report([*lines, *map(_attractor_line, others)], data, units)


def _find_attractors(options: argparse.Namespace, problem: tuple) -> tuple[Attractor, ...]:
    """The motions from many starts; none where ``--attractors`` is not given."""
    given = {name: getattr(options, name) for name in _SEARCH if getattr(options, name) is not None}
    if not options.attractors:
        if given:
            note(f"{', '.join(f'--{name}' for name in given)} has no effect without --attractors")
        return ()
    search = _SEARCH | given
    progress = progress_line(lambda done: f"{done} of {search['starts']:g} starts", search["starts"])
    return attractors(*problem, **search, progress=progress)


def _motion_lines(found: Motion, drives: bool) -> Iterator[Line]:
    """A motion as text; of a free vibration the kept periods do not show what it has touched before."""
    yield Row("motion", _name(found))
    yield Row("", found.reason, width=100)
    if not found.impacts_per_period >= 0:  # not known: the run ended early
        return
    if drives:
        yield from rows({"": touching(found)}, width=100)
    yield from rows(
        {
            "impacts": f"{found.impacts_per_period:.4g} per period, over {counted(found.periods, 'period')}",
            "contacts": _rate_text(found.contacts_per_period, found.contact_share),
            "lasting contacts": _rate_text(found.permanent_per_period, found.permanent_share),
        }
    )
    if _has_impact_list(found):
        at = ", ".join(f"{phase:.4f}" for phase in found.impact_phases[:_MOST_IMPACTS])
        yield from rows({"impacts at": f"{at} periods", "closing speeds": _speeds_text(found.closing_speeds)})
    if found.impulse == found.impulse or found.energy_lost == found.energy_lost:
        yield Row("each period", f"impulse {_number(found.impulse)}, {_energy(found)}")
        yield Row("peak force", _peak_force(found))
    if len(found.multipliers):
        yield Row(
            "multipliers", ", ".join(f"{m:.5g}" if m.imag else f"{m.real:.5g}" for m in found.multipliers.tolist())
        )
        yield Row("nearest", f"{found.bifurcation}, {found.margin:.3g} off")
    if found.lyapunov == found.lyapunov:
        error = f" ± {found.lyapunov_error:.2g}" if found.lyapunov_error > 0 else ""
        yield Row("Lyapunov", f"{_number(found.lyapunov)}{error} per period")


def _has_impact_list(found: Motion) -> bool:
    """Whether the impacts of a cycle are those of every other one, so that they can be listed."""
    return bool(found.period and not found.step_noise and len(found.impact_phases))


def _speeds_text(speeds: Sequence[float]) -> str:
    return ", ".join(f"{speed:.3g}" for speed in speeds[:_MOST_IMPACTS])


def _attractor_line(found: Attractor) -> Statement:
    start = ",".join(f"{value:.10g}" for value in found.start)  # as --initial takes it
    impacts = f", {_number(found.motion.impacts_per_period)} impacts per period; first from {start}"
    return Statement(f"{100 * found.share:5.1f} % of starts  ", _name(found.motion), impacts)


def _name(found: Motion) -> str | Statement:
    """The kind of the motion, and how it repeats itself where it does."""
    repeats = found.near_period or found.own_period == found.own_period
    return joined(": ", (str(found.type), repetition(found))) if repeats else str(found.type)


def _rate_text(per_period: float, share: float) -> str:
    return f"{per_period:.4g} per period, {100 * share:.2f} % of the time"


def _peak_force(found: Motion) -> str:
    """The peak force, or why there is none."""
    if not has_peak_force(found):
        return "none: impacts have an impulse alone"
    return _number(found.peak_force) + (f", in {counted(found.sampled, 'period')}" if found.sampled else "")


def _energy(found: Motion) -> str:
    """The energy that is lost, and what of it the time step creates or what it removes beside."""
    lost, made = f"energy lost {_number(found.energy_lost)}", found.energy_created
    if made != made:
        return lost
    return f"{lost}, {'created' if made >= 0 else 'removed'} by the time step {_number(abs(made))}"


def _number(value: float) -> str:
    return f"{value:.4g}" if value == value else "not known"


COMMAND = Command(
    "name the motion: periodic, quasi-periodic or chaotic, with the evidence",
    "Find what a run from rest (or --initial) settles to: its period with Floquet multipliers and the bifurcation it "
    "is near, or its largest Lyapunov exponent. A Newmark band that shrinks with the time step is called an artefact. "
    "Without --units all numbers are non-dimensional.",
    "A motion whose kind is not certain is undecided, and a run that blows up is diverged; the exit status is 2 only "
    "for bad input.",
    add,
    run,
    "one JSON object",
)
