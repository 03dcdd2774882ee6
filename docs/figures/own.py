"""The system of ``my.toml``: displacement and contact force of the reference over those of a penalty model."""

import matplotlib.pyplot as plt
from style import PENALTY, REFERENCE
from vibroscope.engine import Newmark, Record, Reference, read_system, simulate

found = read_system("../my.toml")  # figures are drawn in their own folder
record = Record(periods=2, per_period=1000)
figure, (above, below) = plt.subplots(2, 1, figsize=(8, 4), sharex=True)
for name, method, style in (
    ("reference", Reference(), {"color": REFERENCE, "linewidth": 3, "alpha": 0.6}),
    ("K = 584, D = 2, 400 steps", Newmark(stiffness=584, damping=2, steps=400), {"color": PENALTY, "linewidth": 1}),
):
    path = found.units.trajectory(simulate(found.system, found.eta, method, record=record).trajectory)
    seconds = path.time - path.time[0]
    above.plot(seconds, 1e3 * path.displacement[0], label=name, **style)
    below.plot(seconds, path.force, **style)
above.set_ylabel("displacement, mm")
above.legend(loc="right")
below.set(xlabel="time, s", ylabel="contact force, N")
