"""The tolerances of branches: each with its unit and its reason.

Scaled: in units of the orbit's size and of the width of the range, as steps along a branch are measured.
"""

# Orbits that searches find

NEARLY_RETURNS = 0.03  # of the size: a state that nearly returns lies near an orbit
RETURNS_CLOSELY = 1e-6  # of the size: the events of a state that returns so closely are those of the orbit
SAME_ORBIT = 1e-6  # of the size: orbits closer than that are the same
ANOTHER_MOTION = 0.1  # of the orbit's size: an orbit farther away is another motion
INSTANT_ROUNDING = 1e-12  # excitation periods: so close to the end of a cycle an instant of a run is at it

# Margins: below zero the bodies penetrate, or the events are others

ZERO_MARGIN = 1e-8  # a margin this small is zero: farther below it is that of a solution which is no orbit …
BESIDE_SEQUENCE = 1e-3  # … but for one next to the end of its sequence, from which the curve leads to an orbit
MARGIN_ROUNDING = 1e-12  # below zero: a solution whose least margin is lower than rounding is no orbit
VANISHING_STEP = 1e-7  # scaled: where a step is shorter …
VANISHING_MARGIN = 3e-8  # … and a margin smaller, a phase vanishes: rounding hides the margin's zero
ROUNDED_IMPACTS = 1e-7  # excitation periods: so close together impacts are mostly rounding
REPEATED = 1e-10  # of the size: rounding; within the first step an orbit departs farther from one of a shorter period
SHORTEST_CONTACT = 1e-6  # excitation periods: a new contact, or flight, of the penalty is followed from there on …
SHORTEST_FLIGHT = 3e-3  # … and a new flight of the reference, whose gap is of third order in its length

# Steps along a curve

ROUGH = 1e-11  # a larger residual is no rounding: it may be that the equations only nearly have a solution there
SLOPE_DIFFERENCE = 1e-7  # of the width of the range, of differences in α₁: well above rounding
STEEP = 0.003  # scaled, of the tangent along α₁: below it an orbit is sought across the tangent, not at a given α₁
LONG_CORRECTION = 0.25  # of a step: a correction as long as that leads to another curve, or back along the same one
AT_BORDER = 1e-9  # scaled: closer to the border of a range is on it
ROOT_TOLERANCE = 1e-12  # of the interval, by default: shorter ones are rounding
LOGARITHMIC = 10.0  # a range whose ends differ by a larger factor may be followed in the logarithm

# Where branches meet, end and go on

REAL_PAIR = 1e-6  # a pair of multipliers with smaller imaginary parts is real, and no Neimark–Sacker point
UNLIKE = 1e-3  # of the largest: where a phase has no length rounding decides the sign of the determinants
SAME_HALVES = 1e-6  # excitation periods: so close to half a cycle apart events of a symmetric orbit are mirror images
LOST_SYMMETRY = 1e-7  # of the largest singular value: along a direction of a smaller one symmetry is being lost
NEAR_LOSS = 1e-4  # scaled: as far from where symmetry seems to be lost lie symmetric orbits that are not rounded
SINGULAR = 1e-5  # of the other singular values: a smaller one makes a branch point
CLOSED_BRANCH = 0.05  # of a step: so close to its first point a branch has closed
SAME_DOUBLING = 1e-6  # scaled: a period doubling no farther from where halves seem to meet is where they do
LONGEST_MEETING = 2e-4  # scaled: longest step over which the value of a meeting is interpolated
ACCUMULATED = 1e-8  # of the range: grazings of new impacts, ever closer, are the first of infinitely many within it
SAME_FOLD = 1e-9  # of the range: a fold so close to where a branch joins one of a shorter period is its turn there
SAME_JOIN = 1e-7  # of the range: nothing begins at points so close to where a branch joined another
INSIDE_SEQUENCE = 1e-6  # of a step: as far from the end of a sequence lies the last orbit that is kept
LOCATED_JUMP = 1e-9  # of a step: as well is the end of a jump located
INSIDE_CURVE = 1e-3  # of a step: as far from the end of its curve lies the first orbit after a jump
NEAR_MEETING = 1e-3  # scaled, from the place that a step shows: farther off lies another meeting
ON_CIRCLE = 1e-4  # a multiplier that close to the unit circle lies on it

# Curves of bifurcations in the plane of two numbers

POINT_DIFFERENCE = 1e-6  # scaled, of differences: their error and that of rounding are both small
SLOW = 0.5  # ratio of two steps of Newton's method, above which the derivatives are renewed
# Of a step: a correction as long as that leads to another curve, or the curve bends too much
LONG_POINT_CORRECTION = 0.1
CORRECTION_ROUNDING = 1e-9  # scaled: a correction this short is rounding, however short the step
ROUGH_STEP = 1e-5  # scaled: where a longer one leads out of the sequence, a shorter one may find its end
SAME_POINT = 1e-6  # of the ranges: points closer than that are the same
CLOSED_CURVE = 0.01  # of a step: so close to its first point a curve has closed
MEETS = 0.75  # of the difference of the halves of a cycle: a step to a smaller one may lead to where it is zero
EXTRAPOLATED = 1e-7  # of the ranges: a last place that changes them by less ends the extrapolation to such a point
TOUCH_LENGTH = 1e-5  # excitation periods: a contact shorter than that is a touch
SAME_TOUCH = 1e-4  # excitation periods: a minimum of the gap closer to a touch is the touch
BRIEF_CONTACT = 0.02  # excitation periods: contacts and flights of the penalty so short have unknowns of their own
