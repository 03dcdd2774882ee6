"""The parts of the difference over K for the system of ``my.toml``, D giving its restitution.

Each point is the median of nine runs with K up to 10 % off, and the band holds nine tenths of them: a single run may be
better by chance.
"""

import matplotlib.pyplot as plt
import numpy as np
from style import EXACT, PENALTY, SPARE
from vibroscope.engine import ComparisonQuestion, Newmark, compare, equal_restitution_damping, read_system

found = read_system("../my.toml")  # figures are drawn in their own folder
SYSTEM, ETA, STEPS = found.system, found.eta, (400, 3200)
K, NEAR = np.geomspace(30, 3e5, 17), np.linspace(0.9, 1.1, 9)


def parts(k: float, n: int) -> list[tuple[float, float]]:
    """Parts of the time step and of K and D, in per cent, of the runs near K."""
    runs = [
        compare(ComparisonQuestion(SYSTEM, ETA, Newmark(x, equal_restitution_damping(SYSTEM, x), n))) for x in k * NEAR
    ]
    return [(100 * c.time_step, 100 * c.regularisation) for c in runs]


figure, axes = plt.subplots(figsize=(7, 3.6))
for n, colour in zip(STEPS, (PENALTY, SPARE), strict=True):
    low, mid, high = np.quantile([parts(k, n) for k in K], (0.05, 0.5, 0.95), axis=1)
    axes.loglog(K, mid[:, 0], marker=".", color=colour, label=f"time step, T/{n}")
    axes.fill_between(K, low[:, 0], high[:, 0], color=colour, alpha=0.25, linewidth=0)
axes.loglog(K, mid[:, 1], color=EXACT, label="K and D")
axes.set(xlabel="contact stiffness K, in units of k₁", ylabel="part of the difference, %")
axes.legend()
