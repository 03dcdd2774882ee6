"""The parts of the difference over K, the damping giving the restitution of the reference."""

import matplotlib.pyplot as plt
import numpy as np
from style import EXACT, PENALTY, SPARE
from vibroscope.engine import Newmark, System, compare, equal_restitution_damping

SYSTEM, ETA, STEPS = System(), 2.76, (2000, 32000)
K = np.geomspace(100, 1e6, 25)
shares = {}
for n in STEPS:
    found = [compare(SYSTEM, ETA, Newmark(k, equal_restitution_damping(SYSTEM, k), n)) for k in K]
    kept = [(c.time_step, c.regularisation) if c.pointwise else (np.nan, np.nan) for c in found]
    shares[n] = 100 * np.transpose(kept)

figure, axes = plt.subplots(figsize=(7, 3.6))
axes.loglog(K, shares[STEPS[-1]][1], color=EXACT, label="K and D")
for n, colour in zip(STEPS, (PENALTY, SPARE), strict=True):
    axes.loglog(K, shares[n][0], marker=".", color=colour, label=f"time step, T/{n}")
axes.set(xlabel="penalty stiffness K, in units of k₁", ylabel="part of the difference, %")
axes.set_ylim(top=2000)  # room for the legend above the curves
axes.legend(loc="upper right")
