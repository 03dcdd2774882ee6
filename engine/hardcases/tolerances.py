"""What results of the hard cases may differ by: each with its unit and its reason."""

MARGIN = 64  # rounding errors in each piece: some tens of operations
PIECE = 1.0  # radians; a closed-form motion may be rounded once in each
# Allowed ratio of the changes of the result due to 2r and to r: 2 but for rounding and curvature
PROPORTION = (1.5, 2.7)
# Standard errors by which statistics of the same motion may differ: exceeded once in two million times
SAME_STATISTICS = 5.0
ROUNDED_CHANGE = 1e-13  # of the largest state: smaller changes of the result are rounding
