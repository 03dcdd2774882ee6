"""Figures 11 and 12: which K and D give a motion without bifurcations, and which of them a sudden impact.

The ranges of the paper's planes are lost with its figures. Ours has steps of a third of an octave around the set that
the paper recommends in the end, K = 12000 and D = 18, which is one of the cells. Each cell is run twice, with T/2000 as
in the paper and without a time step; the difference is the effect of the time step.
"""

from functools import cache
from typing import NamedTuple

import numpy as np
from vibroscope.app.explorer.presets import scenes
from vibroscope.app.explorer.state import Setting
from vibroscope.app.paper.claims import SYSTEM, VISIBLE_SCATTER, Claim, Finding, is_cancelled, percent, section_size
from vibroscope.app.paper.penalty_claims import SUDDEN_STEPS
from vibroscope.app.paper.pictures import CellMap
from vibroscope.engine import CellResults, Cells, run_cells

_THIRD = 2 ** (1 / 3)
_BELOW, _ABOVE = {"K": 15, "D": 12}, {"K": 6, "D": 6}  # cells on either side of the recommended set
_TRANSIENT, _SAMPLE = 2000, 50
_OTHERS = "The ranges of the paper's plane are lost; this one is centred on its recommended set."


class PlaneCells(NamedTuple):
    """The numbers of every cell: axes (m,) and (n,), and arrays (n, m) with K along the rows."""

    stiffness: np.ndarray
    damping: np.ndarray
    regular: np.ndarray  # one visible point in the section, without a time step
    quiet: np.ndarray  # the same with the paper's step
    steps: np.ndarray  # that the longest contact lasts


@cache
def plane_cells() -> PlaneCells:
    """Both runs of every cell; computed once in each process. Raises `engine.Cancelled` if the check is cancelled."""
    scene = scenes()["14A"].setting
    K, D = (_axis(name, getattr(scene, name)) for name in ("K", "D"))
    grid = {"damping": np.repeat(D, len(K)), "stiffness": np.tile(K, len(D))}
    eta, shape = np.full(len(K) * len(D), scene.eta), (len(D), len(K))
    how = {"transient": _TRANSIENT, "sample": _SAMPLE, "threads": 1}  # leaves the other processors to other sessions
    how["cancelled"] = is_cancelled.get()
    free, stepped = (
        run_cells(Cells(SYSTEM, eta, method, **grid), **how) for method in (scene.penalty.limit, scene.penalty)
    )
    columns = _looks_periodic(free), _looks_periodic(stepped), stepped.longest_contact_steps
    return PlaneCells(K, D, *(column.reshape(shape) for column in columns))


def _axis(name: str, middle: float) -> np.ndarray:
    """Values of K or D around the recommended one."""
    return middle * _THIRD ** np.arange(-_BELOW[name], _ABOVE[name] + 1)


def _looks_periodic(cells: CellResults) -> np.ndarray:
    """Cells whose section looks like one point in a phase plot."""
    with np.errstate(invalid="ignore"):  # a cell that ended early holds nan, and gives False
        return cells.spread <= VISIBLE_SCATTER * section_size(cells.section)


def _check_regions(scene: Setting) -> Finding:
    """Figure 11: bifurcated and non-bifurcated regions."""
    plane = plane_cells()
    scattered = plane.regular & ~plane.quiet
    kind = np.where(~plane.regular, 0, np.where(scattered, 1, 2))
    shares = {name: ok.mean() for name, ok in (("free", plane.regular), ("stepped", plane.quiet))}
    least = [plane.damping[plane.regular[:, column]].min(initial=np.inf) for column in (0, -1)]
    return Finding(
        all(0.05 < share < 0.95 for share in shares.values()),
        f"Of {kind.size} cells, {percent(shares['free'])} are not bifurcated without a time step, and "
        f"{percent(shares['stepped'])} with T/{scene.steps}. The least D that does it rises from {least[0]:.2g} at "
        f"K = {plane.stiffness[0]:.0f} to {least[1]:.2g} at K = {plane.stiffness[-1]:.0f}.",
        CellMap(
            plane.stiffness, plane.damping, kind, ("bifurcated", "blurred by the step", "one period"), _point(scene)
        ),
        f"Two regions, as in the paper, but for {percent(scattered.mean())} of the cells: there the motion has one "
        f"period, and T/{scene.steps} blurs it by more than {percent(VISIBLE_SCATTER)} of its size. {_OTHERS}",
    )


def _check_sudden_region(scene: Setting) -> Finding:
    """Figure 12: short contacts leave a smaller region."""
    plane = plane_cells()
    sudden = plane.steps < SUDDEN_STEPS
    kind = np.where(~plane.regular, 0, np.where(sudden, 2, 1))
    left, before = plane.regular & sudden, plane.regular
    row, column = (
        np.abs(axis - value).argmin() for axis, value in ((plane.damping, scene.D), (plane.stiffness, scene.K))
    )
    softest = plane.stiffness[left.any(axis=0)].min(initial=np.inf)
    both = left & plane.quiet
    here = "is" if plane.quiet[row, column] else "is not"
    return Finding(
        0 < left.sum() < before.sum() and left[row, column],
        f"Fewer than {SUDDEN_STEPS} steps of contact leave {left.sum()} of {before.sum()} cells, all with "
        f"K ≥ {softest:.0f}. K = {scene.K:g}, D = {scene.D:g} is among them, with {plane.steps[row, column]:.0f} "
        "steps.",
        CellMap(plane.stiffness, plane.damping, kind, ("bifurcated", "longer contact", "sudden impact"), _point(scene)),
        f"Judged by the motion without a time step. Were a blur by T/{scene.steps} forbidden as well, {both.sum()} "
        f"cells would be left, and the recommended set {here} one of them. {_OTHERS}",
    )


def _point(scene: Setting) -> tuple[float, float]:
    return scene.K, scene.D


PLANE_CLAIMS = [
    Claim(
        "11",
        "section 4.2",
        "At η = 2.76 with T/2000 the K–D plane falls into bifurcated and non-bifurcated regions.",
        "10B",
        _check_regions,
        view="plane",
    ),
    Claim(
        "12",
        "section 4.2",
        "To ask for contacts of fewer than 30 steps, “sudden” impacts, diminishes the region of possible K and D.",
        "14A",
        _check_sudden_region,
        view="plane",
    ),
]
