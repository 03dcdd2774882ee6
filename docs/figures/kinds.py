"""Three sections with a cloud of points: two motions that are irregular themselves, and one that a time step blurs."""

import matplotlib.pyplot as plt
from style import PENALTY, REFERENCE
from vibroscope.engine import Newmark, Reference, System, motion, simulate

SYSTEM = System()
RUNS = [(1.7, Reference()), (2.76, Newmark(12000, 18, 2000)), (2.76, Newmark(12000, 18, 2000, located=True))]

figure, row = plt.subplots(1, 3, figsize=(9, 3))
for axes, (eta, method) in zip(row, RUNS, strict=True):
    run = simulate(SYSTEM, eta, method, keep=1000)
    found = motion(SYSTEM, eta, method)
    colour = REFERENCE if method == Reference() else PENALTY
    axes.plot(run.section[:, 2], run.section[:, 3], ".", markersize=3, color=colour)
    steps = ", located" if getattr(method, "located", False) else ""
    axes.set(title=f"{method.name}{steps}, η = {eta}:\n{found.type}", xlabel="ξ₂", ylabel="ξ₂′")
row[2].set(xlim=row[1].get_xlim(), ylim=row[1].get_ylim())
