"""Basins: which start leads to which motion, and from which starts the penalty model ends on another one."""

import math
from collections.abc import Mapping

import numpy as np
import panel as pn
from vibroscope.app.explorer.field_units import shown_field
from vibroscope.app.explorer.link import LINEAR, ViewChoice
from vibroscope.app.explorer.parameters import START_FIELDS
from vibroscope.app.explorer.state import SOLVERS, Setting
from vibroscope.app.export.formats import Figure, Series
from vibroscope.app.export.scripts import method_options, sweep_command, sweep_python
from vibroscope.app.page.shared.curves import AWAITED, Axis, CellsView, Plot, cells, mark, rounded_view, write_cells
from vibroscope.app.page.shared.figure import divisor, legend_above
from vibroscope.app.page.shared.seen import say
from vibroscope.app.page.study.tab import StudyView, free_obstacle
from vibroscope.app.page.tab import Move
from vibroscope.app.runtime.number_text import print_number
from vibroscope.app.studies.basin import (
    AT_WALL,
    COLOURS,
    FURTHER,
    PALETTE,
    PLANES,
    SAMPLE,
    TRANSIENT,
    BasinQuestion,
    PartialBasin,
    grow_basin,
)
from vibroscope.app.studies.cell_classes import DIVERGED, NO_NUMBER, SPECIAL
from vibroscope.engine import CONTACT_LAWS, COORDINATES, Method, System, percent
from vibroscope.engine.sweeps.basin_motions import PHASE

REACH = 8.0  # of the starts at first, in units of what drives the bodies
WHOLE = (0.0, 1.0)  # of a period
NAMES = {"reference": "Reference", "penalty": "Penalty model"}


def default_span(system: System, eta: float) -> tuple[float, float]:
    """How far starts reach at first: REACH times the largest amplitude or clearance of the system."""
    drive = system.excitation
    size = max(abs(value) for value in (drive.base_amplitude(eta), drive.force1, drive.force2, system.clearance)) or 1.0
    reach = float(f"{REACH * size:.2g}")
    return -reach, reach


def _basin(side: str) -> Plot:
    entries = {
        "cells": ("", [cells(f"basin_{side}_cells", PALETTE, hovered=True)]),
        "start": ("start that is set", [mark("basin_mark", "x", "y")]),
    }
    tips = {"motion": "@motion", "repeats after (periods)": "@period"}
    return Plot(AWAITED, "start_x", "start_y", entries, tips, legend=legend_above)


class BasinView(CellsView):
    """Two figures with the same axes and colours."""

    axes = dict.fromkeys(("start_x", "start_y"), Axis(*default_span(System(), 1.0), quantity="displacement"))
    plots = {f"basin_{side}": _basin(side) for side in SOLVERS}  # noqa: RUF012 - read only

    def hold(self, setting: Setting, axes: tuple[str, str]) -> None:
        """Set the axes to the range of starts that suits the system, and that of a phase to one period."""
        span = default_span(setting.system, setting.eta)
        for owned, axis in zip(self.ranges.values(), axes, strict=True):
            owned.put(*(WHOLE if axis == PHASE else span))

    @property
    def in_view(self) -> dict[str, tuple[float, float]]:
        """The parts of both axes that are in view."""
        return {name[-1]: rounded_view(owned.ends, *LINEAR) for name, owned in self.ranges.items()}

    def in_view_of(self, axes: tuple[str, str]) -> dict[str, tuple[float, float]]:
        """The parts of these axes that are in view; that of a phase is at most a period."""
        return {
            name: (within(span) if axis == PHASE else span)
            for (name, span), axis in zip(self.in_view.items(), axes, strict=True)
        }

    def update(self, setting: Setting, axes: tuple[str, str], result: PartialBasin | None) -> None:
        """Move the mark; draw the cells as far as they are known."""
        for name, axis in zip(self.ranges, axes, strict=True):
            if axis == PHASE:
                self.units[name].show("start phase / period", 1.0)
                continue
            field = shown_field(f"start_{axis}", setting)
            self.units[name].show(f"start {field.label} / {divisor(field.unit or field.natural)}", field.factor)
        self.write("basin_mark", {name: [at] for name, at in zip("xy", start_on(setting, axes), strict=True)})
        if result is None:
            return
        at = shown_field("eta", setting).words(result.question.eta)
        for side in SOLVERS:
            title = f"{NAMES[side]}{_method_words(side, result.question)}, {at}"
            say(self.figures[f"basin_{side}"], title, _seen(result, side))
            motion = result.shown(side)
            more = {"motion": np.where(motion >= 0, motion + 1, 0).astype(np.int32), "period": result.periods(side)}
            source = self.sources[f"basin_{side}_cells"]
            write_cells(source, result.image(side), result.question.x, result.question.y, **more)


def _seen(result: PartialBasin, side: str) -> str:
    """The share of the starts that leads to each motion."""
    shares = {each.name: each.shares[side] for each in result.motions if side in each.shares}
    return ", ".join(f"{name} {percent(share)}" for name, share in shares.items())


def start_on(setting: Setting, axes: tuple[str, str]) -> tuple[float, float]:
    """The numbers of the start that is set that belong to the axes; its phase is 0."""
    numbers = dict(zip(COORDINATES, setting.initial, strict=True)) | {PHASE: 0.0}
    return numbers[axes[0]], numbers[axes[1]]


def within(span: tuple[float, float]) -> tuple[float, float]:
    """The part of a view that lies within a period; all of the period if none does."""
    low, high = max(span[0], WHOLE[0]), min(span[1], WHOLE[1])
    return (low, high) if low < high else WHOLE


def _method_words(side: str, question: BasinQuestion) -> str:
    if side == "reference":
        return ""
    return f", T/{question.penalty.steps}" if question.penalty.has_step else " without a time step"


_PLANE_NAMES = {
    "xi2-v2": "state of body 2",
    "xi1-v1": "state of body 1",
    "v1-v2": "both velocities",
    "xi1-xi2": "both displacements",
    "phase-xi1": "phase and displacement 1",
    "phase-v1": "phase and velocity 1",
    "phase-xi2": "phase and displacement 2",
    "phase-v2": "phase and velocity 2",
}
PHASE_FIELDS = ("base_phase", "force1_phase", "force2_phase")
_MODELS = {"exact": "without a time step", "set": "as set under Solver"}


class Basins(StudyView):
    """Two basins over a plane of starts, at any η."""

    key = "basin"
    title = "Basins and coexisting motions"
    starts = True
    grow = staticmethod(grow_basin)
    drawn, place = BasinView, "tall"
    tapped = keyed = ("basin_reference", "basin_penalty")
    zoomed = "basin_reference"
    head = "Basins of attraction"
    choices = (
        ViewChoice(
            "plane", "Starts over", "xi2-v2", _PLANE_NAMES, of_body_2=tuple(p for p in PLANES if p not in AT_WALL)
        ),
        ViewChoice("model", "Penalty model", "exact", _MODELS),
    )
    hint = (
        "A click starts Explore there; so do the fields of Start, which move the mark, and Shift + 1. The numbers of "
        "the start that are not on an axis are those that are set. A start at another phase is opened with what drives "
        "the bodies ahead by as much. A zoom is computed anew."
    )
    pictures = (
        Figure("basin_reference", "Basins of the reference", "The motion that each start of the reference leads to."),
        Figure("basin_penalty", "Basins of the penalty model", "The same of the penalty model, in the same colours."),
    )

    def show(self, move: Move) -> None:
        """See `StudyView`; at a wall the starts are those of body 1, and what is chosen says so."""
        if move.setting.bodies == "wall" and self.panel.chosen["plane"] not in AT_WALL:
            self.panel.chosen = self.panel.chosen | {"plane": AT_WALL[0]}
        super().show(move)

    def refresh(self) -> None:
        """See `StudyView`; the axes reach as far as the system suggests, and those of another plane may differ."""
        if self._move is not None:
            with pn.io.hold(self.host.doc):
                self.view.hold(self._move.setting, self._plane(self._move.setting))
        super().refresh()

    def obstacle(self, setting: Setting) -> str:
        """Why there is no study: every start of free bodies leads to rest; some laws need a time step."""
        if words := free_obstacle(setting, "each start", "leads to rest"):
            return words
        if self.panel.chosen["model"] == "exact" and _limit(setting) is None:
            return 'This contact law has no solution without a time step: choose "as set under Solver" here.'
        penalty = self._penalty(setting)
        closed = not penalty.has_step and penalty.linear
        if PHASE in self._plane(setting) and not closed:
            return (
                "Starts at another phase need a solver in closed form: choose the penalty model without a time step "
                f"and the contact law {CONTACT_LAWS[0]}, or a plane without the phase."
            )
        return ""

    def _penalty(self, setting: Setting) -> Method:
        return (_limit(setting) if self.panel.chosen["model"] == "exact" else None) or setting.penalty

    def question(self, setting: Setting) -> BasinQuestion:
        """All but the numbers of the start that are on the axes."""
        axes = self._plane(setting)
        start = dict(zip(COORDINATES, setting.initial, strict=True))
        start |= {name: 0.0 for name in axes if name in COORDINATES}
        if setting.bodies == "wall":
            start |= {"xi2": 0.0, "v2": 0.0}
        spans = self.view.in_view_of(axes)
        methods = setting.reference, self._penalty(setting)
        return BasinQuestion(setting.system, setting.eta, *methods, axes, spans["x"], spans["y"], tuple(start.values()))

    def _plane(self, setting: Setting) -> tuple[str, str]:
        """The axes; at a wall those of body 1."""
        chosen = self.panel.chosen["plane"]
        return PLANES[AT_WALL[0] if setting.bodies == "wall" and chosen not in AT_WALL else chosen]

    def draw(self, setting: Setting, result: PartialBasin | None) -> None:
        """Both pictures and the key."""
        if result is not None and result.question.axes != self._plane(setting):
            result = None  # of other axes
        self.view.update(setting, self._plane(setting), result)
        self.panel.key_title = "Motion"
        self.panel.key = [] if result is None else _key(result)

    def describe(self, setting: Setting, result: PartialBasin) -> list[list[str]]:
        """The start that is set, and both basins."""
        return statements(setting, result)

    def table(self, name: str) -> list[Series]:
        """A row for each cell that is known."""
        side = name.removeprefix("basin_")
        return [Series(NAMES[side], self.result.columns(side))]

    def python(self, setting: Setting) -> str:
        """`BasinStudy` of both, and the share in which they differ."""
        question = self.script_question(setting)
        values = (f"np.linspace({a!r}, {b!r}, {question.count})" for a, b in map(question.ends, "xy"))
        axes = ", ".join(f'"{name}": {each}' for name, each in zip(question.axes, values, strict=True))
        how = f"start={question.start}, transient={TRANSIENT}, sample={SAMPLE}"
        problems = {side: f"system, {question.method(side)!r}, {question.eta!r}" for side in SOLVERS}
        calls = {
            side: f"sweep(BasinStudy.over(\n    {problem},\n    {{{axes}}},\n    {how},\n))"
            for side, problem in problems.items()
        }
        calls["difference"] = f"basin_difference({', '.join(SOLVERS)})"
        return sweep_python(calls, question.system)

    def command(self, setting: Setting) -> str:
        """``vibroscope sweep basin`` of both, and the share in which they differ."""
        question = self.script_question(setting)
        given = f" --eta {print_number(question.eta)}"
        for name, axis in zip("xy", question.axes, strict=True):
            given += f" --{name}={axis}:{':'.join(map(repr, question.ends(name)))}:{question.count}"
        given += f" --start={','.join(map(print_number, question.start))}"
        given += f" --transient {TRANSIENT} --sample {SAMPLE}"
        both = sweep_command(
            "basin", question.system, *(given + method_options(question.method(side)) for side in SOLVERS)
        )
        return f"{both}vibroscope sweep basin-difference basin1.zarr basin2.zarr\n"

    def take_over(self, name: str, x: float, y: float) -> None:
        """Start Explore at a point of the plane; at another phase, what drives the bodies is ahead by as much."""
        setting = self._move.setting
        at = {axis: float(f"{each:.4g}") for axis, each in zip(self._plane(setting), (x, y), strict=True)}
        numbers = dict(zip(COORDINATES, setting.initial, strict=True))
        numbers |= {name: at[name] for name in at if name in COORDINATES}
        texts = dict(zip(START_FIELDS, map(print_number, numbers.values()), strict=True))
        if phase := at.get(PHASE, 0.0):
            ahead = {name: (getattr(setting, name) + 2 * math.pi * phase) % (2 * math.pi) for name in PHASE_FIELDS}
            texts |= {name: print_number(angle) for name, angle in ahead.items()}
        self.host.visit("explore", {"zero_start": "zero", **texts})


def _limit(setting: Setting) -> Method | None:
    """The penalty model without a time step; None where its law has none."""
    try:
        return setting.penalty.limit
    except ValueError:
        return None


def _key(result: PartialBasin) -> list[list[str]]:
    """Colour, name and pattern of each motion."""
    rows = [[COLOURS[k] if k < len(COLOURS) else FURTHER, each.name, ""] for k, each in enumerate(result.motions)]
    shown = [result.image(side) for side in SOLVERS]
    inside = "body would be in the wall" if result.question.system.wall else "bodies would overlap"
    rows += [[SPECIAL[NO_NUMBER], inside, "missing"]] if any((s == NO_NUMBER).any() for s in shown) else []
    return rows + ([[SPECIAL[DIVERGED], "ended early", "paper"]] if any((s == DIVERGED).any() for s in shown) else [])


def statements(setting: Setting, result: PartialBasin) -> list[list[str]]:
    """Head and text: where both end on different motions, the start that is set, and each basin."""
    so_far = "" if result.share >= 1 else " so far"
    lines, difference = [], result.difference
    if math.isfinite(difference.share):
        text = (
            f"From {_share(difference.share, difference.error)} of the starts the penalty model ends on another motion "
            "than the reference."
        )
        lines.append([f"Different motions{so_far}", text])
    return [*lines, *_here(setting, result), *([f"{NAMES[side]}{so_far}", _basins(result, side)] for side in SOLVERS)]


def _here(setting: Setting, result: PartialBasin) -> list[list[str]]:
    """The motions to which the cell of the present start leads, once both solvers have computed it."""
    question = result.question
    place = result.cell(*start_on(setting, question.axes))
    if place is None or not all(result.known[side][place] for side in SOLVERS):
        return []
    centre = zip(question.axes, (question.axis("x")[place[1]], question.axis("y")[place[0]]), strict=True)
    at = ", ".join(_number_words(setting, axis, float(f"{value:.3g}")) for axis, value in centre)
    found = {side: int(result.cells[side][place]) for side in SOLVERS}
    words = {side: result.motions[k].name if k >= 0 else "no motion" for side, k in found.items()}
    text = f"The reference leads to {words['reference']}, the penalty model to {words['penalty']}."
    if found["reference"] == found["penalty"] >= 0:
        text = f"Both lead to the same motion: {words['reference']}."
    return [[f"Cell of the start that is set, {at}", text]]


def _number_words(setting: Setting, axis: str, value: float) -> str:
    return f"phase {value:g}" if axis == PHASE else shown_field(f"start_{axis}", setting).words(value)


def _basins(result: PartialBasin, side: str) -> str:
    """Shares of the motions of a side, and the dimension of the boundary."""
    shares: Mapping[str, tuple[float, float]] = {
        each.name: (each.shares[side], each.errors[side]) for each in result.motions if side in each.shares
    }
    if not shares:
        return "nothing computed yet."
    text = "; ".join(f"{name} from {_share(*pair)} of the starts" for name, pair in shares.items())
    found = result.concluded[side]
    dimension, error = float(found["boundary_dimension"]), float(found["boundary_dimension_error"])
    if result.share < 1 or not (math.isfinite(dimension) and math.isfinite(error)):
        return f"{text}."
    return f"{text}. The boundary between them has the dimension {dimension:.2f} ± {error:.2f}."


def _share(share: float, error: float) -> str:
    """A share with its standard error where that is more than nothing."""
    return f"{100 * share:.1f} ± {100 * error:.1f} %" if error > 0 else percent(share)
