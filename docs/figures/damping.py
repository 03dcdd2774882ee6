"""The restitution that K and D deliver in the contact mode: the D that gives it, over K."""

from dataclasses import replace

import matplotlib.pyplot as plt
import numpy as np
from style import EXACT, PENALTY, REFERENCE
from vibroscope.engine import System, equal_restitution_damping

K = np.geomspace(100, 1e5, 60)

figure, axes = plt.subplots(figsize=(7, 3))
for e, colour in ((0.3, PENALTY), (0.5, REFERENCE), (0.8, EXACT)):
    axes.loglog(K, equal_restitution_damping(replace(System(), restitution=e), K), color=colour, label=f"e = {e}")
axes.set(xlabel="penalty stiffness K", ylabel="penalty damping D")
axes.legend()
