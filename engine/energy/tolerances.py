"""The tolerance of an energy balance, with its unit and its reason."""

EVERY_STEP = 1e-3  # relative: samples whose spacing is a step but for so much are those of every step
