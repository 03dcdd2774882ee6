"""Poincaré sections with smaller and smaller steps, and of the reference."""

import matplotlib.pyplot as plt
from style import PENALTY, REFERENCE
from vibroscope.engine import Newmark, Reference, System, simulate

SYSTEM, ETA = System(), 2.76
RUNS = {
    "T/2000": Newmark(12000, 18, 2000),
    "T/8000": Newmark(12000, 18, 8000),
    "T/32000": Newmark(12000, 18, 32000),
    "T/2000, located": Newmark(12000, 18, 2000, located=True),
}
reference = simulate(SYSTEM, ETA, Reference(), keep=400).section

figure, row = plt.subplots(1, 4, figsize=(9, 2.6), sharex=True, sharey=True)
for axes, (name, method) in zip(row, RUNS.items(), strict=True):
    section = simulate(SYSTEM, ETA, method, keep=400).section
    axes.plot(section[:, 2], section[:, 3], ".", markersize=3, color=PENALTY, label="penalty")
    axes.plot(reference[:, 2], reference[:, 3], "+", color=REFERENCE, label="reference")
    axes.set(title=name, xlabel="ξ₂")
row[0].set_ylabel("ξ₂′")
row[0].legend()
