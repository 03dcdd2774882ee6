"""``vibroscope branch``: periodic motions followed over a number, with the points at which they bifurcate."""

import argparse
import math
from itertools import chain

from vibroscope.app.commands.basin_seeds import read_basin
from vibroscope.app.commands.kept_branches import KeptBranches
from vibroscope.app.commands.numbers import count, end_of_range
from vibroscope.app.commands.options import (
    NEEDED,
    REFERENCE_OPTIONS,
    add_fields,
    add_initial_option,
    add_solver,
    add_system_option,
    default_of,
    note_held,
    note_unused,
    problem_of,
)
from vibroscope.app.commands.output import note, progress_line, watch_interrupt
from vibroscope.app.commands.parser import Command, OneLineParser
from vibroscope.app.commands.report import Report
from vibroscope.engine import (
    FOLLOWED_KINDS,
    PARAMETERS,
    Branch,
    BranchQuestion,
    Cancelled,
    Point,
    PointCurve,
    PointCurves,
    search_branches,
)

_LONGEST, _MOST_ORBITS = (default_of(BranchQuestion, name) for name in ("max_period", "most_orbits"))
_FOLLOWED = "period doubling"
_SHOWN = "  {:<24} {:<18} {:<10} {}"


def add(command: OneLineParser) -> None:
    """Add the options."""
    add = command.add_argument
    add_solver(
        command,
        required=False,
        default="reference",
        type=_without_step,
        choices=("reference", "exact"),
        help="semi-analytical reference; penalty model without a time step, its contact a spring and a damper (default "
        "%(default)s)",
    )
    add_fields(command, "eta", "K", "D", *REFERENCE_OPTIONS, solvers=("reference", "exact"))
    add_initial_option(command)
    add_system_option(command)
    add("--over", choices=PARAMETERS, default="eta", help="the number that varies (default eta)")
    add("--from", dest="low", type=end_of_range, required=True, metavar="F", help="its smallest value")
    add("--to", dest="high", type=end_of_range, required=True, metavar="F", help="its largest value")
    words = f"longest cycle, in excitation periods (default {_LONGEST})"
    add("--max-period", type=count, default=_LONGEST, metavar="N", help=words)
    add("--unstable", action="store_true", help="follow also what begins where an unstable motion bifurcates: many")
    words = f"orbits after which a branch is given up, in each direction (default {_MOST_ORBITS})"
    add("--most-orbits", type=count, default=_MOST_ORBITS, metavar="N", help=words)
    add(
        "--from-basin",
        metavar="FILE.zarr",
        help="follow also the motions of this result of `vibroscope sweep basin`, of the same problem, that lie on no "
        "branch the search finds: isolated ones may",
    )
    add("--along", choices=PARAMETERS, help="a second number, along which the points of --point are followed")
    add("--along-from", type=end_of_range, metavar="F", help="its smallest value")
    add("--along-to", type=end_of_range, metavar="F", help="its largest value")
    add("--point", choices=FOLLOWED_KINDS, default=_FOLLOWED, help=f"kind of points to follow (default {_FOLLOWED})")
    words = "keep all orbits, multipliers and points, after each branch (xarray.open_zarr reads them)"
    add("--out", metavar="FILE.zarr", help=words)


def _without_step(solver: str) -> str:
    """A solver that has branches."""
    if solver == "newmark":
        raise argparse.ArgumentTypeError(
            f"{solver!r} has a time step, and so no branches: give 'reference', or 'exact', to which it tends with "
            "smaller steps"
        )
    return solver


def run(options: argparse.Namespace) -> Report:
    """Follow the branches."""
    if not options.out:
        return _run(options, None)
    with KeptBranches(options.out).held() as kept:
        return _run(options, kept)


def _run(options: argparse.Namespace, kept: KeptBranches | None) -> Report:
    if options.over == "eta":
        if options.initial is None and options.from_basin is None:
            note_unused(options, ["eta"], "where eta varies, unless --initial or --from-basin begins there")
        note_held(options)
    seeds = read_basin(options.from_basin) if options.from_basin is not None else None
    if seeds is not None and options.eta is None:
        options.eta = seeds.eta
    question, found, code = _question(options), [], 0
    if seeds is not None:
        seeds.check(question)
    curves, notes, lost = [], [], []
    progress = progress_line(lambda count: f"{count} branches", float("inf"))
    with watch_interrupt() as cancelled:
        along = _along(options, question, cancelled)
        try:
            how = {"note": notes.append, "keep": kept and kept.search_folder, "cancelled": cancelled}
            search = search_branches(question, **how)
            more = () if seeds is None else seeds.unknown(question, found, cancelled)
            for branch in chain(search, more):
                found.append(branch)
                if kept is not None:
                    kept.write(found, options.over, complete=False)
                if progress is not None:
                    progress(len(found))
            for point in _points(options, found) if along else ():
                _follow(along, point, curves, lost)
        except Cancelled:
            again = "goes on from there" if kept and kept.search_folder else "begins anew"
            note(f"stopped after {len(found)} branches; the same command {again}")
            code = 130
    for each in notes:
        note(each)
    if kept and code == 0:
        kept.write(found, options.over, complete=True)
    data = {"over": options.over, "solver": options.solver, "branches": list(map(_plain, found)), "notes": notes}
    if options.along:
        data["curves"] = list(map(_plain_curve, curves))
        data["not_followed"] = [{"kind": p.kind, options.over: p.value, "reason": why} for p, why in lost]
    lines = [line for branch in found for line in _lines(branch)] or ["no branches"]
    lines += [line for curve in curves for line in _curve_lines(curve)]
    lines += [f"{p.kind} at {options.over} {p.value:.8g} is not followed: {why}" for p, why in lost]
    return Report(lines, data, status=code)


def _question(options: argparse.Namespace) -> BranchQuestion:
    """What is searched for; the number that is followed need not be given."""
    own = ("eta", *NEEDED[options.solver], *(("threshold",) if options.solver == "reference" else ()))
    if options.over in own and getattr(options, options.over) is None:
        setattr(options, options.over, options.low)
    names = ("over", "low", "high", "max_period", "unstable", "most_orbits", "initial")
    return BranchQuestion(*problem_of(options), **{name: getattr(options, name) for name in names})


def _along(options: argparse.Namespace, question: BranchQuestion, cancelled) -> PointCurves | None:
    """The plane of both numbers, if a second one is asked for."""
    if not options.along:
        note_unused(options, ["along_from", "along_to"], "without --along")
        return None
    if options.along_from is None or options.along_to is None:
        raise ValueError(f"--along {options.along} needs --along-from and --along-to, the ends of its range")
    along = {"along": options.along, "along_low": options.along_from, "along_high": options.along_to}
    return PointCurves(question, **along, cancelled=cancelled)


def _points(options: argparse.Namespace, found: list[Branch]) -> list[Point]:
    """The points of the kind that is followed."""
    return [point for branch in found for point in branch.points if point.kind == options.point]


def _follow(along: PointCurves, point: Point, curves: list[PointCurve], lost: list[tuple[Point, str]]) -> None:
    """Add the curve of a point, or why there is none; nothing if it lies on a curve that there is."""
    try:
        curve = along.follow(point)
    except ValueError as error:
        lost.append((point, str(error)))
        return
    if curve is not None:
        curves.append(curve)


def _plain_curve(curve: PointCurve) -> dict:
    """A curve of points as JSON takes it."""
    return {
        "kind": curve.kind,
        "period": curve.period,
        curve.over: curve.values[:, 0],
        curve.along: curve.values[:, 1],
        "meetings": [{"kind": kind, curve.over: value, curve.along: along} for kind, value, along in curve.meetings],
        "ends": curve.ends,
    }


def _curve_lines(curve: PointCurve) -> list[str]:
    """A curve of points as text."""
    (first, begin), (last, end) = curve.values[0], curve.values[-1]
    lines = [
        f"{curve.kind} of period {curve.period}: {curve.over} {first:.8g} at {curve.along} {begin:.6g} to "
        f"{last:.8g} at {end:.6g}, {len(curve.values)} points",
        f"  ends: {curve.ends[0]}; {curve.ends[1]}",
    ]
    meetings = (
        f"  {kind} at {curve.over} {value:.8g}, {curve.along} {along:.6g}" for kind, value, along in curve.meetings
    )
    return [*lines, *meetings]


def _plain(branch: Branch) -> dict:
    """A branch as JSON takes it."""
    return {
        "period": branch.period,
        "from": branch.values.min(),
        "to": branch.values.max(),
        "orbits": len(branch.values),
        "stable": branch.stable_ranges,
        "ends": branch.ends,
        "points": [
            {name: getattr(point, name) for name in ("kind", "stop", "value", "multipliers", "state")}
            for point in branch.points
        ],
    }


def _lines(branch: Branch) -> list[str]:
    """A branch as text."""
    parts = ", ".join(f"{low:.6g} to {high:.6g}" for low, high in branch.stable_ranges) or "nowhere"
    low, high = branch.values.min(), branch.values.max()
    lines = [
        f"period {branch.period}, {branch.over} from {low:.6g} to {high:.6g}; stable: {parts}",
        f"  ends: {branch.ends[0]}; {branch.ends[1]}",
    ]
    return lines + [
        _SHOWN.format(p.kind if p.stop == 1 else p.words, f"{p.value:.12g}", f"period {p.period}", _multiplier(p))
        for p in branch.points
    ]


def _multiplier(point) -> str:
    value, which = point.critical_multiplier, "critical" if point.is_crossing else "largest"
    if not math.isfinite(abs(value)):
        return f"{which} multiplier infinite"
    return f"{which} multiplier {value:.5g}" if value.imag else f"{which} multiplier {value.real:.5g}"


COMMAND = Command(
    "follow periodic motions, stable and unstable, over a number, and locate their bifurcations",
    "Follow every branch of periodic motions of the reference or the exact penalty solution through a range of one "
    "number, from all motions that coexist at some of its values, and locate folds, period doublings, Neimark-Sacker "
    "points, branch points, losses of symmetry, grazing, and where sticking begins or ends, to 1e-10 of the range. "
    "Methods with a time step have no branches: the exact penalty solution is what they tend to with smaller steps.",
    "Ctrl-C ends the search; what was found is printed. With --out each branch is kept once it is followed: after a "
    "stop or a kill the same command reads what is kept, and goes on from there.",
    add,
    run,
    "one JSON object",
)
