"""The colours of all figures; the rest of their style is in ``conf.py``."""

GREY = "#808080"
REFERENCE, PENALTY, EXACT, SPARE = "#3b82c4", "#d9730d", "#2f9e6e", "#a05fb5"
