"""``vibroscope branch``: periodic motions followed over a number, with the points at which they bifurcate.

``vibroscope branch --from-basin``: the motions that a study of basins found, and which of them are on no branch.

The place of ``vibroscope branch --out``: a Zarr group of the branches so far, and what the search goes on with.
"""

import argparse
import contextlib
import json
import math
import shutil
from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import chain
from pathlib import Path
from typing import NamedTuple

import numpy as np
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
from vibroscope.app.commands.parser import Command, OneLineParser
from vibroscope.app.commands.report import Report, note, progress_line, record, watch_interrupt
from vibroscope.engine import (
    FOLLOWED_KINDS,
    PARAMETERS,
    Branch,
    BranchQuestion,
    Cancelled,
    Point,
    PointCurve,
    PointCurves,
    branches_dataset,
    continue_branch,
    search_branches,
)
from vibroscope.engine.arguments import Poll
from vibroscope.engine.sweeps import KIND_FLAGS, check_store
from vibroscope.engine.sweeps.store_location import StoreLocation

BESIDE = 0.1  # of the distance of two neighbouring orbits: so far from the chord between them one may lie
SAME = 1e-6  # of the size of a motion: closer is equal


class BasinSeeds(NamedTuple):
    """The periodic motions of a study of basins.

    Attributes
    ----------
    target : str
        Where it is.
    eta : float
    numbers : dict
        Those of the system and of the method, by name.
    sections : tuple of (p, 4) ndarray
        ξ₁, ξ₁′, ξ₂, ξ₂′ of each motion at τ = 0, T, … (p − 1)T.
    """

    target: str
    eta: float
    numbers: dict[str, dict]
    sections: tuple[np.ndarray, ...]

    def check(self, question: BranchQuestion) -> None:
        """Raise a ValueError if the study is of another system, η or method, or lies outside the range."""
        of_method = {name: getattr(question.method, name, None) for name in self.numbers["method"]}
        ours = {"eta": question.eta} | question.system.as_dict() | of_method
        theirs = {"eta": self.eta} | self.numbers["system"] | self.numbers["method"]
        for name, value in theirs.items():
            if ours.get(name) != value:
                raise ValueError(
                    f"{self.target} is of {name} = {value}, and here it is {ours.get(name)}: branches begin at the "
                    "motions of the same problem; give its numbers"
                )
        low, value, high = question.low, question.value, question.high
        if not low <= value <= high:
            raise ValueError(
                f"{question.over} = {value:g} of {self.target} lies outside {low:g} … {high:g}: take it in"
            )

    def unknown(self, question: BranchQuestion, found: list[Branch], cancelled: Poll) -> Iterator[Branch]:
        """Follow each motion that lies on no branch found so far."""
        for rows in self.sections:
            known = any(passes(branch, question.value, rows) for branch in found)
            if len(rows) <= question.max_period and not known:
                yield continue_branch(replace(question, initial=rows[0]), cancelled=cancelled)


def read_basin(target: str) -> BasinSeeds:
    """The motions of a result of ``vibroscope sweep basin``.

    Raises
    ------
    ValueError
        If it is none, or not complete.
    """
    import xarray

    check_store(target)  # raises a ValueError in words where there is no result
    found = xarray.open_zarr(target)
    if "motion_section" not in found:
        raise ValueError(f"{target} is no complete result of `vibroscope sweep basin`")
    numbers = {name: json.loads(found.attrs[name]) for name in ("system", "method")}
    names = ("motion_kind", "motion_period", "motion_section")
    kinds, periods, sections = (found[name].values for name in names)
    periodic = KIND_FLAGS["periodic"]
    motions = (rows[:period] for kind, period, rows in zip(kinds, periods, sections, strict=True) if kind == periodic)
    return BasinSeeds(target, float(found.attrs["eta"]), numbers, tuple(motions))


def passes(branch: Branch, value: float, rows: np.ndarray) -> bool:
    """Whether a branch passes a motion (p, 4) where its number has a value, whichever period of the cycle is first."""
    if branch.period != len(rows):
        return False
    sides = branch.values - value
    for k in np.flatnonzero(sides[:-1] * sides[1:] <= 0):
        (low, high), ends = sides[[k, k + 1]], branch.sections[[k, k + 1]]
        share = 0.0 if low == high else low / (low - high)
        between, apart = ends[0] + share * (ends[1] - ends[0]), np.abs(ends[1] - ends[0]).max()
        away = min(np.abs(np.roll(rows, turn, axis=0) - between).max() for turn in range(len(rows)))
        if away <= BESIDE * apart + SAME * np.abs(rows).max():
            return True
    return False


_SEARCH = "search"  # the folder in that of the group which `search_branches` keeps its branches in


class KeptBranches:
    """Branches at a place, a folder or a URL; a search into a folder goes on where it was stopped or killed."""

    def __init__(self, target: str) -> None:
        self._location = StoreLocation(target)

    @property
    def search_folder(self) -> Path | None:
        """The folder in which the search keeps the branches that it has followed."""
        return self._location.folder and self._location.folder / _SEARCH

    @contextlib.contextmanager
    def held(self) -> Iterator["KeptBranches"]:
        """Hold the place for this process.

        Raises
        ------
        ValueError
            If there is something else.
        BlockingIOError
            If another process holds it.
        """
        folder = self._location.folder
        known = folder is None or not folder.exists() or self.search_folder.exists()
        if not known and (not folder.is_dir() or any(folder.iterdir())):
            raise ValueError(f"{folder} exists and is no result of such a search: give a new place")
        with self._location.lock():
            if folder is not None:
                import zarr

                zarr.open_group(self._location.root, path=_SEARCH, mode="a")  # Zarr warns of folders that are no groups
            yield self

    def write(self, found: Sequence[Branch], over: str, *, complete: bool) -> None:
        """Write the branches over a number in place of those before; there may be none."""
        with self._location.readable_errors():
            for path in self._location.folder.iterdir() if self._location.folder else ():
                if path.name != _SEARCH:
                    shutil.rmtree(path) if path.is_dir() else path.unlink()
            dataset = branches_dataset(found, over).assign_attrs(complete=int(complete))
            dataset.to_zarr(self._location.root, mode="a" if self._location.folder else "w", consolidated=False)


_LONGEST, _MOST_ORBITS = (default_of(BranchQuestion, name) for name in ("max_period", "most_orbits"))
_FOLLOWED = "period doubling"
_SHOWN = "  {:<26} {:<18} {:<10} {:<14} {}"


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
        "points": [record(point, "kind", "stop", "value", "multipliers", "state") for point in branch.points],
    }


def _lines(branch: Branch) -> list[str]:
    """A branch as text; ξ₁ distinguishes orbits of one period, as a motion between two stops and its mirror image."""
    parts = ", ".join(dict.fromkeys(f"{low:.6g} to {high:.6g}" for low, high in branch.stable_ranges)) or "nowhere"
    low, high = branch.values.min(), branch.values.max()
    ends = zip(branch.ends, branch.sections[[0, -1], 0], strict=True)
    lines = [
        f"period {branch.period}, {branch.over} from {low:.6g} to {high:.6g}; stable: {parts}",
        "  ends: " + "; ".join(f"{end} ({_where(state)})" for end, state in ends),
    ]
    for p in branch.points:
        kind, period = p.kind if p.stop == 1 else p.words, f"period {p.period}"
        lines.append(_SHOWN.format(kind, f"{p.value:.12g}", period, _where(p.state), _multiplier(p)))
    return lines


def _where(state: np.ndarray) -> str:
    """Where body 1 is at τ ≡ 0 mod pT."""
    return f"ξ₁ {state[0]:.6g}"


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
