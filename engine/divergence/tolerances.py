"""The tolerances of a comparison and its verdict: each with its unit and its reason."""

# How a motion is settled

NARROW = 0.2  # of the cycle's size: the width of a band that a time step makes about it
BURSTS = 4.0  # of its widths: how far the middle of such a band may lie from the cycle
DRAWS_NEARER = 0.99  # times as far apart a cycle later: points that draw nearer to each other become one
SECTION_DRIFT = 2.0  # times the distance of halves: sections that differ by more belong to a motion that still changes
NOTICED = 0.02  # of the section's size: less is no change that matters
CHANCE = 3.0  # floors: what two sections of one motion differ by, by chance, stays below

# How well solutions agree

SAME_CURVE = 0.02  # relative rms: below it two curves coincide on the screen …
CLOSE_CURVE = 0.1  # … and below this one they are close
SAME_COUNT = 0.05  # per period, and relative: smaller differences in the number of impacts are not mentioned
VISIBLE = 1e-3  # of the section's size: smaller scatter is not mentioned
EVEN_SAMPLES = 1e-9  # of a period: samples whose spacing is off by more are not spread evenly over it
SAME_NUMBER = 0.01  # relative: what is as close as this to a present number is no other one
SAME_DURATION = 0.25  # relative: a duration that is further from another is no longer the same

# Contacts

NEAR_ENCOUNTER = 0.125  # excitation periods: an impact and a contact that are further apart do not belong together
SAME_RESTITUTION = 0.15  # of 1: a restitution that a contact would deliver alone may be off by so much
AS_ASKED = 0.07  # relative: a restitution that is measured is as asked
RESOLVED = 10.0  # steps in a contact: with fewer, the restitution depends on where in a step it begins
LEAST_IN_CONTACT = 4.0  # steps: K with fewer is not tried between two stops, where such a contact gains energy for ever
# Steps in a contact where K, D and the step are changed together: with so many the step is no cause
AMPLE = 5 * RESOLVED

# What is to blame

REMOVED = 0.75  # share of what can be removed that a number to blame removes
HALF = 0.5  # share of the difference that may be left by what is to blame
EQUALLY = 1.2  # times the least: a number that leaves no more is to blame as well, whatever it removes
TIE = 1.5  # times the least: the same of a number that removes as much as is asked
APART = 0.85  # of the reference: motions that are left so far apart have nothing in common
NEARLY = 1.3  # times as much may be left with a status, integrator or number of steps that stands for no step at all
WORKS = 1.25  # times the least: a value that leaves no more works as well
LESS = 0.98  # of the difference: a change that leaves more of it is no better one
