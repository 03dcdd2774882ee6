"""The K–D plane at one frequency: Newmark's periods beside those of the exact penalty solution."""

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.colors import BoundaryNorm, ListedColormap
from style import EXACT, GREY, PENALTY, REFERENCE, SPARE
from vibroscope.engine import System, sweep_plane

K, D = np.geomspace(100, 1e5, 80), np.geomspace(1, 100, 60)
COLOURS = ListedColormap([GREY, REFERENCE, EXACT, PENALTY, SPARE])

figure, row = plt.subplots(1, 2, figsize=(9, 3.4), sharey=True)
for axes, steps in zip(row, (2000, None), strict=True):
    plane = sweep_plane(System(), 2.76, K, D, steps=steps, parts=False)
    name = "Newmark, T/2000" if steps else "exact penalty: no time step"
    period = np.minimum(plane["period"].T, 4)
    drawn = axes.pcolormesh(K, D, period, cmap=COLOURS, norm=BoundaryNorm(np.arange(6) - 0.5, 5))
    axes.set(xscale="log", yscale="log", title=name, xlabel="K")
row[0].set_ylabel("D")
bar = figure.colorbar(drawn, ax=row, ticks=range(5), label="period of the motion, in T")
bar.set_ticklabels(["does not repeat", "1", "2", "3", "4 or more"])
