"""Poincaré sections with smaller and smaller steps, and of the reference."""

import matplotlib.pyplot as plt
from style import PENALTY, REFERENCE
from vibroscope.engine import Newmark, Reference, read_system, simulate

found = read_system("../my.toml")  # figures are drawn in their own folder
SYSTEM, ETA = found.system, found.eta
RUNS = {
    "T/200": Newmark(584, 1.72, 200),
    "T/800": Newmark(584, 1.72, 800),
    "T/3200": Newmark(584, 1.72, 3200),
    "T/200, located": Newmark(584, 1.72, 200, located=True),
}
reference = simulate(SYSTEM, ETA, Reference(), keep=100).section

figure, row = plt.subplots(1, 4, figsize=(9, 2.6), sharex=True, sharey=True)
for axes, (name, method) in zip(row, RUNS.items(), strict=True):
    section = simulate(SYSTEM, ETA, method, keep=100).section
    axes.plot(section[:, 0], section[:, 1], ".", markersize=3, color=PENALTY, label="penalty")
    axes.plot(reference[:, 0], reference[:, 1], "+", color=REFERENCE, label="reference")
    axes.set(title=name, xlabel="ξ₁")
row[0].set_ylabel("ξ₁′")
row[0].legend()
