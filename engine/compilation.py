"""Compilation of all kernels ahead of their first use: in what order, how far it is, and whether it has been done.

A kernel is compiled when it is first called, once for each processor and each version of the sources; the machine code
is kept in the cache folder. All of them together take some eight minutes on two cores, most of it in a few kernels,
into which everything is inlined that they call. So progress is counted in compiled functions, not in kernels. The loops
over a motion are compiled a second time for a wall, which takes a part of the time and is not counted again.
"""

from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from .batch import run_cells
from .cells import Cells
from .divergence.compare import compare
from .divergence.verdict import verdict
from .drivers import orbit_steps, settle
from .drivers.code_cache import CompileListener, compilable_functions, complete_mark
from .drivers.event_driven import hybrid_state
from .drivers.orbit import PART, numbers_of
from .drivers.orbit_equations import Followed, equations_of
from .methods import ExactPenalty, Newmark, Reference, TimeStepping
from .model import System
from .motions.lyapunov import lyapunov
from .motions.steady import steady
from .simulate import simulate
from .sweeps.plane_study import PlaneStudy


class CompileProgress(NamedTuple):
    """How far the compilation is.

    Attributes
    ----------
    share : float
        0 to 1; of the functions that may have to be compiled.
    what : str
        Which solver is being compiled.
    opens : bool
        Whether all is compiled by which the explorer shows and explains the motions that it opens with: two bodies,
        Newmark's method with constant steps.
    """

    share: float
    what: str
    opens: bool = False


_NEWMARK = Newmark(2500.0, 8.0, 2000)
_RUNS = {  # what is called, by what it solves
    "reference": Reference(),
    "Newmark": _NEWMARK,
    "exact penalty": ExactPenalty(2500.0, 8.0),
    "other contact laws": ExactPenalty(2500.0, 8.0, "cut"),
    "Newmark, located": replace(_NEWMARK, located=True),
    "Newmark, every step": replace(_NEWMARK, every_step=True),
    "Newmark, located, every step": replace(_NEWMARK, located=True, every_step=True),
    "other integrators": TimeStepping(2500.0, 8.0, 2000),
    "other integrators, every step": TimeStepping(2500.0, 8.0, 2000, every_step=True),
    "other contact laws, located": TimeStepping(2500.0, 8.0, 2000, status="located", law="cut"),
    "other contact laws, located, every step": TimeStepping(
        2500.0, 8.0, 2000, status="located", law="cut", every_step=True
    ),
}
_EXPLAINED = "differences"  # the last that the explorer opens with: runs and their parts, as it explains them
_OPENING = (
    "reference",
    "Newmark",
    "Newmark, every step",  # of few steps all are taken
    "exact penalty",
    "other contact laws",
    "Newmark, located",
    "other integrators",  # which a verdict tries
    _EXPLAINED,
)
_SCENES = (1.08, 100.0, 50.0), (1.08, 2500.0, 8.0), (1.70, 12000.0, 18.0), (2.76, 12000.0, 18.0)  # η, K and D
_SYSTEMS = System(), System(wall=True)  # each with machine code of its own
_AT_WALL = (  # which have kernels of their own for a wall
    "reference",
    "Newmark",
    "Newmark, every step",
    "Newmark, located",
    "other contact laws, located",
)
_BATCHES = ("reference", "Newmark", "exact penalty")


def is_compiled() -> bool:
    """Whether `compile_kernels` has been through with these sources, on this processor and with this Numba."""
    return complete_mark().exists()


def compile_kernels(progress: Callable[[CompileProgress], None] | None = None) -> None:
    """Compile every kernel, or load it from the cache; ``progress`` is called whenever a function is ready."""
    functions, ready, solver, opens = compilable_functions(), set(), "", False

    def count(function: str | None) -> None:
        ready.update(functions & {function})
        if progress is not None:
            progress(CompileProgress(len(ready) / len(functions), solver, opens))

    with CompileListener(count):
        for system in _SYSTEMS:
            for name, call in calls(system):
                solver, opens = f"{name}, at a wall" if system.wall else name, opens or name not in _OPENING
                count(None)
                call()
    if progress is not None:
        progress(CompileProgress(1.0, solver, True))
    mark = complete_mark()
    if mark.parent.exists():
        mark.touch()


def _settle(cells: Cells) -> None:
    traps = settle.Traps(np.zeros((0, 4)), np.zeros((0, 4, 4)))
    start = cells.starts(), np.zeros(len(cells))
    settle.settle(cells.method, cells.parameters(), *start, traps, periods=2, stride=1, threads=1)


def _errors(system: System) -> None:
    """Compare a cell with the reference."""
    PlaneStudy(system, _NEWMARK, 2.76, 1, 2, K=[2500.0], D=[8.0]).compute()


def _step(system: System, method: Followed) -> None:
    """Take a step of Newton's method to an orbit, and find what a branch needs at one."""
    equations, start, ones = equations_of(system, 1.08, method), np.zeros(4), np.ones(5)
    if isinstance(method, Reference):
        hybrid_state(system, 1.08, method, start)
    found = equations((), False, 1, start)
    equations.slope((system, 1.08, method), 1e-7, (), False, 1, start, found.residual)
    equations.state_later(PART, start, 0.0, 0.1)
    equations.solve((), False, 1, start.copy(), 1.0)
    scales = orbit_steps.scales_of(start, 1.0)
    x, slope, step = np.zeros(5), found.residual.copy(), np.zeros((5, 1))
    orbit_steps.step_in_plane((found.residual, found.jacobian), scales, (ones, 1.0), x, slope, step)
    tangent = orbit_steps.tangent_of(found.jacobian, slope, scales)
    orbit_steps.branch_point_indicator(found.jacobian, slope, tangent)
    orbit_steps.doubling_indicator(found.jacobian)
    orbit_steps.neimark_sacker_indicator(found.jacobian)
    orbit_steps.indicators_of(found.jacobian, slope, tangent)
    orbit_steps.interpolated(np.zeros(1), np.array([x]), np.array([ones]), ones, 0.1)
    orbit_steps.least_of_margins(found.facts, start[4:], 0.0, np.zeros((2, 1), dtype=np.int64))
    orbit_steps.margin_values(found.facts, start[4:], 0.0, np.zeros((2, 1), dtype=np.int64))
    orbit_steps.impact_that_may_stick(numbers_of((PART,)), found.facts, found.facts, 0.0, 0)
    orbit_steps.null_vector(np.eye(4, 5))


def calls(system: System) -> Iterator[tuple[str, Callable[[], object]]]:
    """Yield what is solved, in words, and a call that loads its kernels for this kind of system."""
    for name in _AT_WALL if system.wall else (*_OPENING, *(name for name in _RUNS if name not in _OPENING)):
        if name == _EXPLAINED:
            yield name, lambda: [verdict(compare(system, eta, Newmark(*contact, 2000))) for eta, *contact in _SCENES]
        else:
            yield name, lambda method=_RUNS[name]: simulate(system, 1.08, method, periods=2, keep=1)
    yield "steady motions", lambda: steady(system, 1.08, Reference())
    for name in _BATCHES:
        cells = Cells(system, [1.08], _RUNS[name])
        yield f"{name}, for studies", lambda cells=cells: run_cells(cells, transient=1, sample=2)
    yield "Lyapunov exponents", lambda: lyapunov(system, 1.08, Reference(), periods=256)
    if not system.wall:
        yield "errors of studies", lambda: _errors(system)
    for name in ("reference",) if system.wall else ("reference", "other contact laws", "Newmark, located"):
        yield "branches", lambda method=_RUNS[name]: _step(system, method)
    yield "basins of attraction", lambda: _settle(Cells(system, [1.08], Reference()))
