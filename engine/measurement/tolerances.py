"""The tolerances by which a measurement is read, compared and fitted: each with its unit and its reason."""

# Reading

WRONG_UNIT = 1e9  # in units of the model: a larger number has a wrong unit
CONTACT_FORCE = 0.05  # of the largest force: the bodies are in contact while it is larger
COMMON = 0.98  # share of the samples that gives the size of the motion, and of the slopes that gives its speed
FAR_OUT = 10.0  # times that size from the middle: a sample further out is an outlier …
JUMP = 0.5  # … if it gets so much of the way from the middle in one step …
TOO_FAST = 10.0  # … or comes and goes with more than so many times that speed
UNOBSERVED = 5.0  # median intervals between samples; a longer interval was not observed

# Whether it repeats itself

CERTAIN_SIGMAS = 4.0  # standard errors by which two numbers must differ to be told apart
OVERLAP = 1.5  # cycles that a record must cover to show that it repeats after one
BETTER = 1.5  # a longer cycle must leave so many times less of the squares
HIDDEN = 0.5  # share of a subharmonic's squares: if a shorter cycle leaves less, it reproduces it at the samples
INTEGRATED = 0.01  # of the size: what integrated noise of accelerations is taken for; it grows with the time
NORMAL_MEDIAN = 0.6745  # median size of a normal number of standard deviation 1
# Of the Gram matrix's diagonal, added to it: rounding, so that nearly dependent harmonics can be solved for
RIDGE = 1e-12
NYQUIST = 0.98  # of half the mean sampling rate: harmonics up to there tell frequencies apart
LAST_DIGITS = 1e-11  # of the measurement's size: smaller noise is that of the last digits, and what RIDGE leaves
UNEXPLAINED = 0.2  # of the measurement's size: if more remains, it is not in phase with the excitation

# How well a solution agrees with it

PHASE_DRIFT = 0.3  # radians over the whole record: with a larger one, the given η is not that of the measurement
TRIGGER = 3.0  # sampling intervals by which a trigger misses the start of a motion; a longer shift hides a difference
STILL = 0.05  # of the range: while a record stays so near to its first sample, the bodies may be held before the start
INSTANT = 1e-9  # of a cycle, between an impact and each of its two knots
WITHIN_NOISE = 1.1  # times the noise: a smaller difference is noise alone
HARDLY_VISIBLE = 0.05  # of the measured size: smaller differences are hardly visible
EXPLAINS = 0.2  # times the difference: if less remains with another zero, unit, sign or order, that explains it
SAME_SIZE = 1.25  # ratio of displacements to those of the reference; with a larger one they have another unit
HARDLY_MORE = 1.5  # times what the best reading of the columns leaves: readings that leave less are as good
SENSOR = 0.2  # of the closings per period: a solution with so many more or fewer differs from what the sensor counts

# Fitting

FIT_DIFFERENCE = 1e-5  # of the central differences; the reference's cycle is accurate to some 1e-8
CONTACT_DIFFERENCE = 1e-3  # of K and D, for theirs: between its samples a contact is a polynomial
SAME_MINIMUM = 1e-6  # relative: sums of squares that differ by less belong to the same minimum
INVISIBLE = 1e-6  # of the largest column of J: a parameter with a smaller one cannot be determined
AT_BOUND = 1e-6  # distance from a bound: a parameter that lies closer is held by it
CORRELATED = 0.95  # a larger correlation is remarked on
NOISIER = 1.5  # times the measurement's own noise: with larger residuals the model is not right
DEPENDENT = 0.3  # correlation of neighbouring residuals: with a larger one they are not independent noise
