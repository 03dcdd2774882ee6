"""The style of all figures."""

GREY = "#808080"
REFERENCE, PENALTY, EXACT, SPARE = "#3b82c4", "#d9730d", "#2f9e6e", "#a05fb5"

# No background, and grey lines that can be read on white and on black.
STYLE = dict.fromkeys(("figure.facecolor", "axes.facecolor", "savefig.facecolor"), "none")
STYLE |= dict.fromkeys(("axes.edgecolor", "axes.labelcolor", "axes.titlecolor", "legend.labelcolor"), GREY)
STYLE |= dict.fromkeys(("xtick.color", "ytick.color", "text.color"), GREY)
STYLE |= {"axes.spines.top": False, "axes.spines.right": False, "legend.frameon": False}
STYLE |= {"figure.constrained_layout.use": True, "svg.hashsalt": "vibroscope", "svg.fonttype": "none"}
