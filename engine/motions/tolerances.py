"""The tolerances by which motions are found, described and told apart: each with its unit and its reason."""

# Sections and runs

LEAST_SIZE = 1e-9  # units of length: a smaller motion counts as one of this size, so that shares of it mean something
DYING = 0.9  # of two halves of a section: a difference between its points that falls by more is the rest of a transient
# Of its size: a motion without a time step that returns so closely after a cycle, twice, has settled. What is left of
# its transient lies far below the tolerance of a period.
SETTLES = 1e-9
# Excitation periods: the paper takes a contact of fewer than 30 steps of T/2000 as an impact (Figures 10 to 12)
SUDDEN = 30 / 2000
SHORT_CONTACT = 2.0  # durations of a contact alone; in longer ones other forces press the pendulums together
REPEATED_IMPACTS = 1e-6  # of the size: impacts of a free vibration in closed form that differ by less repeat themselves
REPEATED_IMPACTS_BY_STEPS = 0.01  # of the size: the same with a time step, which scatters them
# Of a period, beside two steps: an impact at one stop and one half a cycle later at the other are alike …
ALIKE_PHASE = 1e-4
ALIKE_SPEED = 0.01  # … if their closing speeds differ by no more of the largest: less than a coarse step scatters them
UNBROKEN = 1e-12  # share of the time that rounding may take from a contact without an end
DRIFTS = 1e-6  # of its growth a period: a gap that grows by less than before by no more grows evenly, but for rounding
UNBALANCED = 0.01  # of the energy: a balance with a larger residual says nothing about the losses

# Newton's method for a periodic orbit

NEAR_RETURN = 0.3  # of the section's size: a return within this distance is worth an attempt …
NEARER_RETURN = 0.5  # … if its distance is at most so many times that of all shorter periods
SMALLEST_FRACTION = 2.0**-10  # of a Newton step: one that must be cut further does not converge
# Sizes of the section that a Newton step may lead away: one that leads farther has missed the orbit
LONGEST_NEWTON_STEP = 1e3
RESIDUAL = 1e-12  # of the section's size: rounding prevents any further reduction
APPROACHED = 0.03  # of its first distance from the orbit: so close a run must come that it is seen to settle
ON_ORBIT = 1e-10  # of the section's size: a state this close to the orbit lies on it but for rounding
# Units of length by which springs may press the bodies into each other, were they not in contact
LARGEST_PRESSING = 1e4

# Stability

STATE_DIFFERENCE = 1e-7  # of the state's size: well below what a time step shifts, well above rounding
SURELY_STABLE = 1e-9  # below one: a cycle whose largest multiplier is larger may be unstable but for rounding …
NEUTRAL = 1e-6  # … and above one: no larger it may be stable but for how closely points on branches are located
REAL_MULTIPLIER = 1e-9  # relative: a multiplier with a smaller imaginary part is real
FALLEN = 0.5  # what is left of a disturbance after the turns of a map that shows whether a region traps
JOINED = 1e-9  # of the size: gap and gap rate of bodies that move as one, but for rounding
# Irregularity of regular motions within thousands of periods, unless their tori are about to break up. A chaotic motion
# falls below it only if eight averages agree this well by chance.
REGULAR = 1e-5
# ln of what a disturbance may grow by: rounding that grows beyond the motion's size decides what comes then
FOLLOWED_GROWTH = 52 * 0.6931471805599453
EXPONENT_DRIFT = 5.0  # standard errors that the averages over the two halves of a run may differ by

# Bands that a time step makes

CLEAR_SPREAD = 1.0  # widths of a band: from this spread of a cycle on, a band about its points must show them
# Of the distances between the points of a cycle; a band that does not show it has some of them by chance
SHOWN_SPREAD = 0.5
# Of a section's size: one that repeats itself so closely goes on as it is, since what is left of a transient lies far
# below the width of a band
REPEATED_BAND = 1e-9
SHRUNK = 0.5  # of a width with a step four times as small: in proportion to Δτ it would be a quarter; chance needs room

# Which motions are the same

SAME_CYCLE = 1e-6  # of the size: cycles of closed-form solvers that differ by less are the same
NOISY = 3.0  # cycles of Newmark may differ by so many widths of their bands, and these widths by such a factor
THIN = 0.01  # of the size: bands that the time step causes differ by any factor below this width
SAME_AVERAGES = 6.0  # standard errors that the averages of one motion may differ by
BETWEEN_SOLVERS = 0.25  # of the size: sections of two methods that lie within it show one motion
