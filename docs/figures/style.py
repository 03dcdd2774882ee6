"""What all figures share: no background, and grey lines that can be read on white and on black."""

import matplotlib.pyplot as plt

GREY = "#808080"
REFERENCE, PENALTY, EXACT, SPARE = "#3b82c4", "#d9730d", "#2f9e6e", "#a05fb5"

plt.rcParams.update(
    {
        "figure.facecolor": "none",
        "axes.facecolor": "none",
        "savefig.facecolor": "none",
        "axes.edgecolor": GREY,
        "axes.labelcolor": GREY,
        "axes.titlecolor": GREY,
        "axes.spines.top": False,
        "axes.spines.right": False,
        "xtick.color": GREY,
        "ytick.color": GREY,
        "text.color": GREY,
        "legend.frameon": False,
        "legend.labelcolor": GREY,
        "figure.constrained_layout.use": True,
        "svg.hashsalt": "vibroscope",
    }
)
