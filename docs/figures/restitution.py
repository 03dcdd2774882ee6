"""The restitution that contact laws give over the closing speed, beside the one that their formulas promise."""

from dataclasses import replace

import matplotlib.pyplot as plt
import numpy as np
from style import GREY
from vibroscope.engine import ExactPenalty, System, effective_restitution
from vibroscope.engine.law_table import numbers_of

PROMISED, K, D = 0.5, 12000, 18
SYSTEM, SPEED = replace(System(), restitution=PROMISED), np.geomspace(0.01, 10, 25)
FORMULAS = "hunt-crossley", "lankarani-nikravesh", "flores", "jankowski", "constant-restitution"
GIVEN_D = ("kelvin-voigt", D), ("limited", D), ("hunt-crossley", 500), ("impact", D), ("bilinear", D)

figure, (left, right) = plt.subplots(1, 2, figsize=(7, 3.4), sharey=True)
for law in FORMULAS:
    left.semilogx(SPEED, effective_restitution(SYSTEM, ExactPenalty(K, None, law), SPEED), label=law)
for law, damping in GIVEN_D:
    numbers = {"penetration": 0.001, "stiffening": 4.0}
    method = ExactPenalty(K, damping, law, **{name: numbers[name] for name in numbers_of(law) if name in numbers})
    right.semilogx(SPEED, effective_restitution(SYSTEM, method, SPEED), label=f"{law}, D = {damping}")
for axes, title in ((left, f"D from the formula for e = {PROMISED}"), (right, "the same D at every speed")):
    axes.axhline(PROMISED, color=GREY, linestyle="--")
    axes.set(xlabel="closing speed", ylim=(0, 1), title=title)
    axes.legend(fontsize="x-small")
left.set_ylabel("restitution")
