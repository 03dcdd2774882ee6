"""Figures of each entry of the gallery, reference and penalty solution over each other: phase plots, and over time."""

from collections.abc import Iterator
from functools import partial

import matplotlib.pyplot as plt
from gallery import settings
from matplotlib.figure import Figure
from style import PENALTY, REFERENCE
from vibroscope.app.explorer.compute import run_length
from vibroscope.app.explorer.state import Setting
from vibroscope.engine import Record, Trajectory, simulate


def runs(setting: Setting) -> Iterator[tuple[Trajectory, dict]]:
    """At most twelve periods of both solutions, and how their lines are drawn."""
    length = run_length(setting.system, setting.eta, setting.initial)
    record = Record(min(12, length.get("keep", 12)), 1000)
    how = {"initial": None if setting.from_rest else setting.initial, "record": record} | length
    for method, style in (
        (setting.reference, {"label": "reference", "color": REFERENCE, "linewidth": 3, "alpha": 0.6}),
        (setting.penalty, {"label": "penalty", "color": PENALTY, "linewidth": 1}),
    ):
        yield simulate(setting.system, setting.eta, method, **how).trajectory, style


def bodies(setting: Setting) -> tuple[int, ...]:
    """The bodies that move."""
    return (1,) if setting.system.wall else (1, 2)


def phases(setting: Setting) -> Figure:
    """Velocity over displacement of each body."""
    shown = bodies(setting)
    figure, row = plt.subplots(1, len(shown), figsize=(4 * len(shown), 3), squeeze=False)
    for path, style in runs(setting):
        for body, axes in zip(shown, row[0], strict=True):
            axes.plot(path.displacement[body - 1], path.velocity[body - 1], **style)
            axes.set(xlabel=f"displacement of body {body}", ylabel="velocity")
    row[0][0].legend()
    return figure


def histories(setting: Setting) -> Figure:
    """Displacements and contact force over time."""
    shown = bodies(setting)
    figure, column = plt.subplots(len(shown) + 1, 1, figsize=(8, 2 * len(shown) + 2), sharex=True)
    for path, style in runs(setting):
        time = path.time - path.time[0]
        for body, axes in zip(shown, column, strict=False):
            axes.plot(time, path.displacement[body - 1], **style)
            axes.set_ylabel(f"displacement {body}")
        column[-1].plot(time, path.force, **style)
    column[-1].set(xlabel="time τ", ylabel="contact force")
    column[0].legend(loc="upper right")
    return figure


globals().update({f"entry_{key}": partial(phases, setting) for key, setting in settings().items()})
