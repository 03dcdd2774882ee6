"""The tolerances of a search for K, D and the time step: each with its unit and its reason."""

FORGOTTEN = 1e-4  # remainder of a disturbance after the transient of a short run
# Relative: half the width of the neighbourhood of n, whose settings must do as well: one may be luck …
STEPS_AROUND = 0.02
AROUND = 0.01  # … and of K and D
LUCK = 2.0  # times its own error: a setting whose neighbours' error is as large is luck, and not shown
WELL = 0.8  # of the tolerances of restitution and peak force: of deviations below it none is better than another
GAIN = 0.95  # of the error: a level of steps that leaves more than this is without gain
STARTS_APART = 1.4  # factor between the K of settings from which a middle is looked for: nearer ones lead to the same
ENOUGH = 1.05  # times the least error: if nothing meets the tolerance, the cheapest setting within it is returned
WHOLE_STEPS = 1e-12  # relative: steps that exceed a whole number by less do so by rounding
OTHERWISE = 2.0  # times the error: further off, the motion without a time step is another one
