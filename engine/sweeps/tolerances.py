"""The tolerances of studies: each with its unit and its reason."""

# Of its size: a motion without a time step that returns so closely after a cycle, twice, has settled. What is left of
# its transient lies far below the tolerance of a period.
SETTLES = 1e-9
SAME_IMPACTS = 1e-6  # impacts per period by which neighbours along an axis may differ by rounding
SCATTERED = 0.03  # of the size: what another motion of a method with a time step may be blurred by
