"""Phase plots of both bodies for each entry of the gallery: reference and penalty solution over each other."""

from functools import partial

import matplotlib.pyplot as plt
from gallery import settings
from style import PENALTY, REFERENCE
from vibroscope.app.explorer.compute import run_length
from vibroscope.engine import Record, simulate


def draw(setting):
    """Draw at most twelve periods."""
    bodies = (1,) if setting.system.wall else (1, 2)
    _, row = plt.subplots(1, len(bodies), figsize=(4 * len(bodies), 3), squeeze=False)
    record = Record(min(12, run_length(setting.system).get("keep", 12)), 1000)
    how = {"initial": None if setting.from_rest else setting.initial, "record": record} | run_length(setting.system)
    for name, method, style in (
        ("reference", setting.reference, {"color": REFERENCE, "linewidth": 3, "alpha": 0.6}),
        ("penalty", setting.penalty, {"color": PENALTY, "linewidth": 1}),
    ):
        path = simulate(setting.system, setting.eta, method, **how).trajectory
        for body, axes in zip(bodies, row[0], strict=True):
            axes.plot(path.displacement[body - 1], path.velocity[body - 1], label=name, **style)
            axes.set(xlabel=f"displacement of body {body}", ylabel="velocity")
    row[0][0].legend()


globals().update({f"entry_{key}": partial(draw, setting) for key, setting in settings().items()})
