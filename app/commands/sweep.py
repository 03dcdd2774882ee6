"""``vibroscope sweep``: diagram, K-D plane, time-step study, basins of attraction; stored, resumed when killed.

The summaries that ``vibroscope sweep basin`` and ``vibroscope sweep basin-difference`` print.
"""

import argparse
import contextlib
import math
import sys
import time
from collections.abc import Callable
from dataclasses import replace
from functools import partial

from vibroscope.app.commands.numbers import STATE, count, end_of_range, number, span, step_numbers
from vibroscope.app.commands.options import (
    NEEDED,
    PENALTY_OPTIONS,
    REFERENCE_OPTIONS,
    SCHEME_OPTIONS,
    SOLVERS,
    STEP_SCALE,
    add_fields,
    add_initial_option,
    add_solver,
    add_system_option,
    default_of,
    eta_of,
    law_of,
    method_of,
    note_held,
    note_unused,
    refuse_missing,
    scheme_of,
    stepping_of,
    system_of_solver,
)
from vibroscope.app.commands.parser import Command, OneLineParser
from vibroscope.app.commands.report import Report, watch_interrupt
from vibroscope.app.explorer.parameters import FIELDS
from vibroscope.engine import (
    COORDINATES,
    DIRECTIONS,
    OVER,
    BasinStudy,
    Cancelled,
    EtaStudy,
    ExactPenalty,
    Method,
    NoSolutionStudy,
    PlaneStudy,
    Progress,
    StepStudy,
    basin_difference,
    is_compiled,
    spaced,
)
from vibroscope.engine.sweeps import AXES, KIND_FLAGS, Partial, RunOptions, Study, check_store, grow


def summary(whole: Partial) -> tuple[dict, list[str]]:
    """The motions and the boundary, as numbers and as lines of text."""
    found = whole.dataset()
    motions = _motions_of(found)
    names = ("boundary_dimension", "boundary_dimension_error")
    numbers = {name: float(found[name]) for name in names}
    lines = [_motion_text(motion) for motion in motions]
    if math.isfinite(numbers["boundary_dimension"]):
        lines.append("dimension of the boundary: {:.3f} ± {:.3f}".format(*numbers.values()))
    return {"motions": motions} | numbers, lines


def _motions_of(found) -> list[dict]:
    kinds = {number: name for name, number in KIND_FLAGS.items()}
    columns = {
        "kind": [kinds[int(kind)] for kind in found["motion_kind"]],
        "period": [int(period) for period in found["motion_period"]],
        "share": [float(share) for share in found["motion_share"]],
        "share_error": [float(error) for error in found["motion_share_error"]],
        "start": list(found["motion_start"].values),
    }
    return [dict(zip(columns, row, strict=True)) for row in zip(*columns.values(), strict=True)]


def _motion_text(motion: dict) -> str:
    name = f"period {motion['period']}" if motion["period"] else motion["kind"]
    return f"{name}: {100 * motion['share']:.2f} ± {100 * motion['share_error']:.2f} % of the starts"


def difference(options: argparse.Namespace) -> Report:
    """The share in which two basins differ, and which motions of both are the same."""
    import xarray

    for path in (options.first, options.second):
        check_store(path)  # raises a ValueError in words where there is no result
    first, second = (xarray.open_zarr(path) for path in (options.first, options.second))
    found = basin_difference(first, second)
    lines = [f"{100 * found.share:.2f} ± {100 * found.error:.2f} % of the starts lead to different motions"]
    for path, each, alike in ((options.first, first, found.same.any(1)), (options.second, second, found.same.any(0))):
        for motion, in_both in zip(_motions_of(each), alike, strict=True):
            lines.append(f"{path}: {_motion_text(motion)}, {'in both' if in_both else 'not in the other'}")
    return Report(lines, {"share": found.share, "error": found.error, "same": found.same})


_REDRAW_SECONDS = 0.2  # between two lines of progress


def _study(
    kind: type[Study],
    text: str,
    make: Callable[..., Study],
    add: Callable[[OneLineParser], None],
    concluded: Callable[[Partial], tuple[dict, list[str]]] = lambda whole: ({}, []),
    **defaults: object,
) -> Command:
    """A command that runs a study.

    ``make`` makes the study of the options, ``add`` adds those of its own, and ``concluded`` gives what follows from
    the result, as a part of the JSON object and as lines.
    """

    def add_all(command: OneLineParser) -> None:
        option = command.add_argument
        option("--transient", type=count, metavar="N", help="periods before the sample (default %(default)s)")
        option(
            "--sample", type=count, metavar="N", help="periods of the sample, which are described (default %(default)s)"
        )
        option("--out", required=True, metavar="PATH", help="a folder, or a URL that fsspec knows (s3://bucket/name)")
        option("--scheduler", metavar="ADDRESS", help="run on the Dask cluster of this scheduler (extra `cluster`)")
        option("--threads", type=int, metavar="N", help="solver threads on this machine, or for a chunk on the cluster")
        add_system_option(command)
        add(command)

    usual = {name: default_of(kind, name) for name in ("transient", "sample")}
    return Command(
        text,
        add=add_all,
        run=lambda options: _run(options, make, concluded),
        json="one JSON object",
        defaults=usual | defaults,
    )


def _add_solver(command: OneLineParser, *penalty: str) -> None:
    """The solver and its numbers; ``penalty``: those of K, D and the step."""
    add_solver(command, help="as in `vibroscope simulate`")
    add_fields(command, *penalty, *SCHEME_OPTIONS, *REFERENCE_OPTIONS, solvers=SOLVERS)


def _add_eta(command: OneLineParser) -> None:
    add = command.add_argument
    add("--from", required=True, type=end_of_range, metavar="F", dest="low", help="smallest value")
    add("--to", required=True, type=end_of_range, metavar="F", dest="high", help="largest value")
    add("--count", required=True, type=count, metavar="N", help="how many values, evenly spaced")
    add("--logarithmic", action="store_true", help="evenly spaced in the logarithm")
    add("--over", choices=OVER, default="eta", help="the parameter that is swept (default eta)")
    add_fields(command, "eta", eta={"help": f"where another parameter is swept: {FIELDS['eta'].words}"})
    _add_solver(command, "K", "D", "steps", "located")
    add("--direction", choices=DIRECTIONS, default="rest", help="each value from rest, or from its neighbour's end")
    add_initial_option(command)
    add("--coordinates", default="xi1,xi2", metavar="A,B", help=f"of {','.join(COORDINATES)} (default %(default)s)")
    add("--refine", type=count, default=0, metavar="N", help="halve intervals in which the motion changes, N times")
    add("--lyapunov", type=count, default=0, metavar="N", help="average the Lyapunov exponent over N periods")


def _range_of(name: str) -> dict[str, object]:
    """How a range of a field is given: its ends and how many values it has."""
    what = FIELDS[name].words.replace(",", ";").partition(";")[0]
    reader = partial(span, quantity=FIELDS[name].quantity)
    return {"type": reader, "metavar": "a:b:n", "help": f"{what}, n values from a to b"}


def _add_plane(command: OneLineParser) -> None:
    add_fields(command, "eta")
    add_fields(command, "K", "D", required=("K", "D"), K=_range_of("K"), D=_range_of("D"))
    words = "with or without a time step (default %(default)s)"
    add_solver(command, required=False, choices=("newmark", "exact"), default="newmark", help=words)
    add_fields(command, "steps", "located", *SCHEME_OPTIONS, solvers=SOLVERS)
    words = "without error, its parts and the exact penalty model beside: faster"
    command.add_argument("--no-error", action="store_true", help=words)


def _add_step(command: OneLineParser) -> None:
    steps = {"type": step_numbers, "metavar": "2000,4000,...", "help": "steps per period, ascending"}
    add_fields(command, "eta", "K", STEP_SCALE, "D", "steps", required=("K", "steps"), steps=steps)
    add_initial_option(command)
    add_fields(command, *SCHEME_OPTIONS)


def _add_no_solution(command: OneLineParser) -> None:
    ranges = {name: _range_of(name) for name in ("K", "steps")}
    add_fields(command, "eta", "K", "D", "steps", required=("K", "D", "steps"), **ranges)
    add_fields(command, *SCHEME_OPTIONS)


def _add_basin(command: OneLineParser) -> None:
    add = command.add_argument
    add_fields(command, "eta")
    axis = "of xi1, v1, xi2, v2, and phase: the share of the excitation period at which a run begins"
    add("--x", required=True, type=_start_axis, metavar="name:a:b:n", help=f"first axis, n values from a to b; {axis}")
    add("--y", required=True, type=_start_axis, metavar="name:a:b:n", help="second axis, as the first")
    add_initial_option(command, "start", "; of the numbers that are on no axis")
    add("--phase", type=number, default=0.0, metavar="F", help="where it is on no axis (default %(default)g)")
    _add_solver(command, *PENALTY_OPTIONS)


def _reader(run: Callable, text: str, more: str, **results: str) -> Command:
    """A command that reads results; ``results``: where their places are kept, and their names in the help."""

    def add(command: OneLineParser) -> None:
        for place, metavar in results.items():
            command.add_argument(place, metavar=metavar, help="a folder, or a URL that fsspec knows")

    return Command(text, f"{text.capitalize()}{more}", add=add, run=run, json="one JSON object")


def _check(options: argparse.Namespace) -> Report:
    """What is damaged; the status is 1 if anything is."""
    damaged, finished = check_store(options.out)
    data = {"path": options.out, "damaged": damaged, "finished": finished}
    return Report(_check_lines(options.out, damaged, finished), data, status=1 if damaged else 0)


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
    return name, span(ends, STATE.get(name, ""))


def _eta(options: argparse.Namespace, **periods: int) -> EtaStudy:
    if options.over == "eta":
        note_unused(options, ["eta"], "where eta is swept")
        note_held(options)
    values = spaced(options.over, options.low, options.high, options.count, logarithmic=options.logarithmic)
    return EtaStudy(
        system_of_solver(options),
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


def _basin(options: argparse.Namespace, **periods: int) -> BasinStudy:
    axes = {name: spaced(name, *span) for name, span in (options.x, options.y)}
    more = {"start": options.start, "phase": options.phase}
    return BasinStudy.over(system_of_solver(options), _method(options), eta_of(options), axes, **more, **periods)


def _method(options: argparse.Namespace) -> Method:
    """The solver; the number that is swept need not be given."""
    if options.over in ("eta", *NEEDED[options.solver]):
        setattr(options, options.over, options.low)
    return method_of(options)


def _plane(options: argparse.Namespace, **periods: int) -> PlaneStudy:
    exact = options.solver == "exact"
    if not exact and options.steps is None:
        raise ValueError("the newmark solver needs --steps; the paper takes --steps 2000")
    if exact:
        note_unused(options, ["steps"], "on the exact solver")
    if exact and options.located:
        raise ValueError("the exact penalty method has no step that could be located: leave --located out")
    axes = {name: spaced(name, *getattr(options, name), logarithmic=True) for name in ("K", "D")}
    method = ExactPenalty(1.0, 0.0, **law_of(options)) if exact else replace(scheme_of(options), steps=options.steps)
    return PlaneStudy(options.file.system, method, eta_of(options), **axes, parts=not options.no_error, **periods)


def _step(options: argparse.Namespace, **periods: int) -> StepStudy:
    refuse_missing(options, "newmark")
    method = stepping_of(options, K=1.0 if options.K is None else options.K, D=options.D, steps=options.steps[0])
    more = {"stiffness_of_step": options.stiffness_of_step, "initial": options.initial}
    return StepStudy(options.file.system, method, eta_of(options), steps=options.steps, **more, **periods)


def _no_solution(options: argparse.Namespace, **periods: int) -> NoSolutionStudy:
    options.status = options.status or "end"
    axes = {name: spaced(name, *getattr(options, name), logarithmic=True) for name in ("K", "steps")}
    method = replace(scheme_of(options), damping=options.D)
    return NoSolutionStudy(options.file.system, method, eta_of(options), **axes, **periods)


def _run(options: argparse.Namespace, make: Callable[..., Study], concluded: Callable) -> Report | int:
    """Run the study with a line of progress until it is done or interrupted."""
    bar = _ProgressLine() if sys.stderr.isatty() else None
    how = {name: getattr(options, name) for name in ("out", "scheduler", "threads")}
    with watch_interrupt() as cancelled, bar or contextlib.nullcontext():
        try:
            study = make(options, transient=options.transient, sample=options.sample)
            *_, whole = grow(study, RunOptions(**how, progress=bar, cancelled=cancelled))
        except Cancelled:
            print(
                f"\nvibroscope sweep: stopped. What is complete is kept in {options.out}; "
                "the same command goes on from there.",
                file=sys.stderr,
            )
            return 130
    # not as a labelled Dataset: what reads one takes half a second to import
    counts = {name: getattr(whole.progress, name) for name in ("computed", "reused", "failed")}
    cells = {"seconds": whole.progress.seconds, "cells": whole.progress.done}
    numbers = cells | counts | {"path": options.out}
    more, lines = concluded(whole)
    return Report([*lines, _CELLS.format_map(numbers), _STORED.format_map(numbers)], numbers | more)


_CELLS = "{cells} cells in {seconds:.2f} s: {computed} computed, {reused} reused, {failed} ended early"
_STORED = "{path} (xarray.open_zarr reads it)"


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


_STEP = "time-step study at one eta, K and D, fixed and located step, by any integrator, status and law"
STUDIES = {
    "eta": _study(EtaStudy, "bifurcation diagram: sections over eta, or over another parameter", _eta, _add_eta),
    "plane": _study(PlaneStudy, "K-D plane of the penalty model at one eta, with logarithmic axes", _plane, _add_plane),
    "step": _study(StepStudy, _STEP, _step, _add_step, located=False),
    "no-solution": _study(
        NoSolutionStudy,
        "plane of steps without a solution over K and steps per period, contact at the end of steps",
        _no_solution,
        _add_no_solution,
        located=False,
    ),
    "basin": _study(
        BasinStudy,
        "basins of attraction: which motion each start of a plane leads to, at one eta",
        _basin,
        _add_basin,
        summary,
        over=None,
    ),
    "basin-difference": _reader(
        difference,
        "share of the starts from which two solvers end on different motions",
        ", from two results of `vibroscope sweep basin` over the same cells.",
        first="FIRST",
        second="SECOND",
    ),
    "check": _reader(
        _check,
        "look through a result for files that are missing, damaged or not its own",
        ": one line for each. The command that made the result computes them anew.",
        out="PATH",
    ),
}
COMMAND = Command(
    "many runs: bifurcation diagram, K-D plane, time-step study, basins, kept and resumable",
    "Run a study and keep it as a Zarr result at --out, which xarray.open_zarr reads. A study that was stopped or "
    "killed goes on where it was when the same command is given again.",
    below=STUDIES,
)
