"""``vibroscope sweep``: diagram, K-D plane, time-step study, basins of attraction; stored, resumed when killed."""

import argparse
import contextlib
import json
import sys
import time
from collections.abc import Callable
from dataclasses import replace

from vibroscope.app.commands import basins
from vibroscope.app.commands.interrupt import watch_interrupt
from vibroscope.app.commands.numbers import count, measured, measured_count, number, span, state_numbers, step_numbers
from vibroscope.app.commands.options import (
    ETA,
    OF_SOLVERS,
    SOLVER_OPTIONS,
    add_integrator_options,
    add_stiffness_option,
    add_system_option,
    default_of,
    eta_of,
    law_of,
    note_held,
    note_unused,
    reference_of,
    refuse_missing,
    stepping_of,
    stiffness_of,
    system_of,
)
from vibroscope.app.commands.output import note
from vibroscope.engine import (
    COORDINATES,
    DIRECTIONS,
    LAWS_BY_RESTITUTION,
    OVER,
    BasinStudy,
    Cancelled,
    EtaStudy,
    ExactPenalty,
    Method,
    Newmark,
    NoSolutionStudy,
    PlaneStudy,
    Progress,
    Reference,
    StepStudy,
    System,
    TimeStepping,
    is_compiled,
    spaced,
    sweep,
)
from vibroscope.engine.sweeps import AXES, Study

_REDRAW_SECONDS = 0.2  # between two lines of progress


def add(commands) -> None:
    """``vibroscope sweep eta|plane|step|no-solution|basin``, and what looks at results."""
    command = commands.add_parser(
        "sweep",
        allow_abbrev=False,
        help="many runs: bifurcation diagram, K-D plane, time-step study, basins, kept and resumable",
        description="Run a study and keep it as a Zarr result at --out, which xarray.open_zarr reads. A study that was "
        "stopped or killed goes on where it was when the same command is given again.",
    )
    studies = command.add_subparsers(dest="study", required=True, metavar="STUDY")
    _add_eta(studies)
    _add_plane(studies)
    _add_step(studies)
    _add_no_solution(studies)
    _add_basin(studies)
    _add_difference(studies)
    _add_check(studies)


def _study(
    studies, name: str, make: Callable, kind: type[Study], text: str, concluded: Callable | None = None
) -> argparse.ArgumentParser:
    command = studies.add_parser(name, allow_abbrev=False, help=text, description=text)
    add = command.add_argument
    add("--transient", type=count, metavar="N", help="periods before the sample (default %(default)s)")
    add("--sample", type=count, metavar="N", help="periods of the sample, which are described (default %(default)s)")
    add("--out", required=True, metavar="PATH", help="a folder, or a URL that fsspec knows (s3://bucket/name)")
    add("--scheduler", metavar="ADDRESS", help="run on the Dask cluster of this scheduler (extra `cluster`)")
    add("--threads", type=int, metavar="N", help="solver threads on this machine, or for a chunk on the cluster")
    add("--json", action="store_true", help="print one JSON object")
    add_system_option(command)
    defaults = {name: default_of(kind, name) for name in ("transient", "sample")}
    command.set_defaults(run=lambda options: _run(options, make, concluded), **defaults)
    return command


def _add_solver(command: argparse.ArgumentParser, *, follows: bool) -> None:
    """The solver and its numbers; ``follows``: whether K can follow the step."""
    add = command.add_argument
    add("--solver", required=True, choices=tuple(SOLVER_OPTIONS), help="as in `vibroscope simulate`")
    newmark = OF_SOLVERS["newmark"]
    add_stiffness_option(command, "exact, newmark: contact stiffness", follows=follows, newmark=newmark)
    add("--D", type=measured, metavar="F", help="exact, newmark: contact damping")
    add("--steps", type=measured_count, metavar="N", help="newmark: steps per excitation period")
    add("--located", action="store_true", help="newmark: cut the steps at each contact change")
    add_integrator_options(command, **OF_SOLVERS)
    usual = Reference()
    add("--joint-damping", choices=("table", "derived"), help=f"reference (default {usual.joint_damping})")
    add("--threshold", type=measured, metavar="F", help=f"reference (default {usual.threshold:g})")
    add("--restitution", type=number, metavar="F", help="reference (default: the system's)")


def _add_eta(studies) -> None:
    text = "bifurcation diagram: sections over eta, or over another parameter"
    command = _study(studies, "eta", _eta, EtaStudy, text)
    add = command.add_argument
    add("--from", required=True, type=measured, metavar="F", dest="low", help="smallest value")
    add("--to", required=True, type=measured, metavar="F", dest="high", help="largest value")
    add("--count", required=True, type=count, metavar="N", help="how many values, evenly spaced")
    add("--logarithmic", action="store_true", help="evenly spaced in the logarithm")
    add("--over", choices=OVER, default="eta", help="the parameter that is swept (default eta)")
    add("--eta", **ETA | {"help": f"where another parameter is swept: {ETA['help']}"})
    _add_solver(command, follows=False)
    add("--direction", choices=DIRECTIONS, default="rest", help="each value from rest, or from its neighbour's end")
    add("--initial", type=state_numbers, metavar="x1,v1,x2,v2", help="where each value starts, in place of rest")
    add("--coordinates", default="xi1,xi2", metavar="A,B", help=f"of {','.join(COORDINATES)} (default %(default)s)")
    add("--refine", type=count, default=0, metavar="N", help="halve intervals in which the motion changes, N times")
    add("--lyapunov", type=count, default=0, metavar="N", help="average the Lyapunov exponent over N periods")


def _add_plane(studies) -> None:
    text = "K-D plane of the penalty model at one eta, with logarithmic axes"
    command = _study(studies, "plane", _plane, PlaneStudy, text)
    add = command.add_argument
    add("--eta", **ETA)
    add("--K", required=True, type=span, metavar="a:b:n", help="contact stiffness, n values from a to b")
    add("--D", required=True, type=span, metavar="a:b:n", help="contact damping, n values from a to b")
    add("--steps", type=measured_count, metavar="N", help="newmark: steps per excitation period")
    add(
        "--solver",
        choices=("newmark", "exact"),
        default="newmark",
        help="with or without a time step (default %(default)s)",
    )
    add("--located", action="store_true", help="newmark: cut the steps at each contact change")
    add_integrator_options(command, **OF_SOLVERS)
    add("--no-error", action="store_true", help="without error, its parts and the exact penalty model beside: faster")


def _add_step(studies) -> None:
    text = "time-step study at one eta, K and D, fixed and located step, by any integrator, status and law"
    command = _study(studies, "step", _step, StepStudy, text)
    command.set_defaults(located=False)
    add = command.add_argument
    add("--eta", **ETA)
    add_stiffness_option(command, "contact stiffness", required=True)
    add("--D", type=measured, metavar="F", help="contact damping; some laws need none: --law")
    add("--steps", required=True, type=step_numbers, metavar="2000,4000,...", help="steps per period, ascending")
    add("--initial", type=state_numbers, metavar="x1,v1,x2,v2", help="where each run starts, in place of rest")
    add_integrator_options(command)


def _add_no_solution(studies) -> None:
    text = "plane of steps without a solution over K and steps per period, contact at the end of steps"
    command = _study(studies, "no-solution", _no_solution, NoSolutionStudy, text)
    command.set_defaults(located=False)
    add = command.add_argument
    add("--eta", **ETA)
    add("--K", required=True, type=span, metavar="a:b:n", help="contact stiffness, n values from a to b")
    add("--D", required=True, type=measured, metavar="F", help="contact damping")
    add("--steps", required=True, type=span, metavar="a:b:n", help="steps per period, n values from a to b")
    add_integrator_options(command)


def _add_basin(studies) -> None:
    text = "basins of attraction: which motion each start of a plane leads to, at one eta"
    command = _study(studies, "basin", _basin, BasinStudy, text, basins.summary)
    command.set_defaults(over=None)
    add = command.add_argument
    add("--eta", **ETA)
    axis = "of xi1, v1, xi2, v2, and phase: the share of the excitation period at which a run begins"
    add("--x", required=True, type=_start_axis, metavar="name:a:b:n", help=f"first axis, n values from a to b; {axis}")
    add("--y", required=True, type=_start_axis, metavar="name:a:b:n", help="second axis, as the first")
    add("--start", type=state_numbers, metavar="x1,v1,x2,v2", help="the numbers that are on no axis (default: rest)")
    add("--phase", type=number, default=0.0, metavar="F", help="where it is on no axis (default %(default)g)")
    _add_solver(command, follows=True)


def _add_difference(studies) -> None:
    text = "share of the starts from which two solvers end on different motions"
    more = ", from two results of `vibroscope sweep basin` over the same cells."
    _reader(studies, "basin-difference", basins.difference, text, more, {"first": "FIRST", "second": "SECOND"})


def _add_check(studies) -> None:
    text = "look through a result for files that are missing, damaged or not its own"
    more = ": one line for each. The command that made the result computes them anew."
    _reader(studies, "check", _check, text, more, {"out": "PATH"})


def _reader(studies, name: str, run: Callable, text: str, more: str, results: dict[str, str]) -> None:
    """A command that reads results; ``results``: where their places are kept, and their names in the help."""
    command = studies.add_parser(name, allow_abbrev=False, help=text, description=f"{text.capitalize()}{more}")
    for place, metavar in results.items():
        command.add_argument(place, metavar=metavar, help="a folder, or a URL that fsspec knows")
    command.add_argument("--json", action="store_true", help="print one JSON object")
    command.set_defaults(run=run)


def _check(options: argparse.Namespace) -> int:
    """Print what is damaged; the status is 1 if anything is."""
    from vibroscope.engine.sweeps import check_store

    damaged, finished = check_store(options.out)
    if options.json:
        print(json.dumps({"path": options.out, "damaged": damaged, "finished": finished}))
    else:
        print("\n".join(_check_lines(options.out, damaged, finished)))
    return 1 if damaged else 0


def _check_lines(path: str, damaged: list[str], finished: bool) -> list[str]:
    if not damaged:
        rest = "" if finished else ", and not finished: the command that began it goes on from there"
        return [f"{path} is whole as far as it is computed{rest}" if rest else f"{path} is whole"]
    advice = "the command that made it computes them anew, and keeps the rest"
    return [*(f"{path}/{name}: missing, damaged, or of something else" for name in damaged), advice]


def _start_axis(text: str) -> tuple[str, tuple]:
    name, _, ends = text.partition(":")
    if name not in AXES:
        raise argparse.ArgumentTypeError(f"{text!r} is no axis: give one of {', '.join(AXES)}, as xi2:-8:8:64")
    return name, span(ends)


def _eta(options: argparse.Namespace, **periods: int) -> EtaStudy:
    system = _system(options)
    if options.over == "eta" and options.eta is not None:
        note("--eta has no effect where eta is swept")
    if options.over == "eta":
        note_held(options)
    values = spaced(options.over, options.low, options.high, options.count, logarithmic=options.logarithmic)
    return EtaStudy(
        system,
        _method(options),
        values=values,
        over=options.over,
        eta=None if options.over == "eta" else eta_of(options),
        direction=options.direction,
        coordinates=options.coordinates.split(","),
        refine=options.refine,
        lyapunov=options.lyapunov,
        initial=options.initial,
        **periods,
    )


def _system(options: argparse.Namespace) -> System:
    system = system_of(options)
    return system if options.restitution is None else replace(system, restitution=options.restitution)


def _basin(options: argparse.Namespace, **periods: int) -> BasinStudy:
    axes = {name: spaced(name, *span) for name, span in (options.x, options.y)}
    more = {"start": options.start, "phase": options.phase}
    return BasinStudy.over(_system(options), _method(options), eta_of(options), axes, **more, **periods)


def _method(options: argparse.Namespace) -> Method:
    """The solver; the number that is swept need not be given."""
    note_unused(options)
    if options.solver == "reference":
        return reference_of(options)
    names = ("K", "D", "steps") if options.solver == "newmark" else ("K", "D")
    values = vars(options) | ({"K": stiffness_of(options)} if options.solver == "newmark" else {})
    given = {name: options.low if name == options.over else values[name] for name in names}
    needed = [name for name in names if name != "D" or options.law not in LAWS_BY_RESTITUTION]
    refuse_missing(options.solver, [f"--{name}" for name in needed if given[name] is None])
    if options.solver == "exact":
        return ExactPenalty(given["K"], given["D"], **law_of(options))
    return stepping_of(options, **given)


def _plane(options: argparse.Namespace, **periods: int) -> PlaneStudy:
    exact = options.solver == "exact"
    if not exact and options.steps is None:
        raise ValueError("the newmark solver needs --steps; the paper takes --steps 2000")
    if exact and options.steps is not None:
        note("--steps has no effect on the exact solver")
    if exact and options.located:
        raise ValueError("the exact penalty method has no step that could be located: leave --located out")
    axes = {name: spaced(name, *getattr(options, name), logarithmic=True) for name in ("K", "D")}
    method = ExactPenalty(1.0, 0.0, **law_of(options)) if exact else replace(_scheme(options), steps=options.steps)
    return PlaneStudy(system_of(options), method, eta_of(options), **axes, parts=not options.no_error, **periods)


def _step(options: argparse.Namespace, **periods: int) -> StepStudy:
    method = stepping_of(options, K=1.0 if options.K is None else options.K, D=options.D, steps=options.steps[0])
    more = {"stiffness_of_step": options.stiffness_of_step, "initial": options.initial}
    return StepStudy(system_of(options), method, eta_of(options), steps=options.steps, **more, **periods)


def _no_solution(options: argparse.Namespace, **periods: int) -> NoSolutionStudy:
    options.status = options.status or "end"
    axes = {name: spaced(name, *getattr(options, name), logarithmic=True) for name in ("K", "steps")}
    method = replace(_scheme(options), damping=options.D)
    return NoSolutionStudy(system_of(options), method, eta_of(options), **axes, **periods)


def _scheme(options: argparse.Namespace) -> Newmark | TimeStepping:
    """The method of the cells, without its numbers."""
    return stepping_of(options, K=1.0, D=0.0, steps=1000)


def _run(options: argparse.Namespace, make: Callable[..., Study], concluded: Callable | None = None) -> int:
    """Run the study with a line of progress until it is done or interrupted; print the summary.

    ``concluded``: what follows from the result, as a part of the JSON object and as lines.
    """
    bar = _ProgressLine() if sys.stderr.isatty() else None
    with watch_interrupt() as cancelled, bar or contextlib.nullcontext():
        try:
            found = sweep(
                make(options, transient=options.transient, sample=options.sample),
                out=options.out,
                scheduler=options.scheduler,
                threads=options.threads,
                progress=bar,
                cancelled=cancelled,
            )
        except Cancelled:
            print(
                f"\nvibroscope sweep: stopped. What is complete is kept in {options.out}; "
                "the same command goes on from there.",
                file=sys.stderr,
            )
            return 130
    counts = {name: found.attrs[name] for name in ("computed", "reused", "failed")}
    cells = {"seconds": found.attrs["seconds"], "cells": counts["computed"] + counts["reused"]}
    summary = cells | counts | {"path": options.out}
    more, lines = concluded(found) if concluded else ({}, [])
    print(json.dumps(summary | more) if options.json else "\n".join([*lines, _as_text(summary)]))
    return 0


def _as_text(summary: dict) -> str:
    return (
        "{cells} cells in {seconds:.2f} s: {computed} computed, {reused} reused, {failed} ended early\n"
        "{path} (xarray.open_zarr reads it)"
    ).format_map(summary)


class _ProgressLine:
    """One line of progress on the terminal, written over."""

    def __init__(self) -> None:
        self._written = 0.0

    def __enter__(self):
        return self

    def __exit__(self, *_):
        if self._written:
            print(file=sys.stderr)

    def __call__(self, now: Progress) -> None:
        if time.monotonic() < self._written + _REDRAW_SECONDS and now.done < now.total:
            return
        self._written = time.monotonic()
        if now.computed:
            left = f", {_duration(now.seconds_left)} left" if now.done < now.total else ""
            rate = f", {now.rate:.3g} a second{left}"
        else:  # what takes so long is said, since the first cell comes after it
            rate = f" after {_duration(now.seconds)}" + ("" if is_compiled() else "; the first run compiles its solver")
        line = f"{now.done} of {now.total} cells{rate}"
        print(f"\r{line:<78}", end="", file=sys.stderr, flush=True)


def _duration(seconds: float) -> str:
    if seconds < 100:
        return f"{seconds:.0f} s"
    return f"{seconds / 60:.0f} min" if seconds < 6000 else f"{seconds / 3600:.1f} h"
