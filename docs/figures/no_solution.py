"""Steps without a solution, over K and the steps per period, for a contact status from the end of the step."""

import matplotlib.pyplot as plt
import numpy as np
from vibroscope.engine import TimeStepping, equal_restitution_damping, read_system, simulate

found = read_system("../my.toml")  # figures are drawn in their own folder
SYSTEM, ETA, PERIODS = found.system, found.eta, 50
K, STEPS = np.geomspace(30, 3e4, 24), np.unique(np.geomspace(50, 2000, 24).astype(int))


def first_period(k, n):
    """Period of the first step without a solution; nan if all have one."""
    method = TimeStepping(k, equal_restitution_damping(SYSTEM, k), int(n), status="end")
    run = simulate(SYSTEM, ETA, method, periods=PERIODS, keep=PERIODS)
    return np.nan if run.ok else len(run.section) + 1


first = [[first_period(k, n) for k in K] for n in STEPS]
figure, axes = plt.subplots(figsize=(7, 3.6))
drawn = axes.pcolormesh(K, STEPS, first, cmap="viridis_r")
axes.set(xscale="log", yscale="log", xlabel="penalty stiffness K", ylabel="steps per period T/Δτ")
figure.colorbar(drawn, label="period in which a step\nhas no solution")
