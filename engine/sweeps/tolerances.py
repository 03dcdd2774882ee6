"""The tolerances of studies: each with its unit and its reason."""

SAME_IMPACTS = 1e-6  # impacts per period by which neighbours along an axis may differ by rounding
SCATTERED = 0.03  # of the size: what another motion of a method with a time step may be blurred by
