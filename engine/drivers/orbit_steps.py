"""Newton's method to an orbit, tangents and indicators (:mod:`..kernels.event_driven.orbit_steps`)."""

from ..kernels.event_driven.orbit_steps import (
    BEGINS,
    CONVERGED,
    ENDS,
    LENGTH,
    NEWTON_STEPS,
    STALLED,
    branch_point_indicator,
    doubling_indicator,
    impact_that_may_stick,
    indicators_of,
    interpolated,
    least_of_margins,
    margin_values,
    neimark_sacker_indicator,
    scales_of,
    step_in_plane,
    tangent_of,
)
from ..kernels.linear.small_systems import null_vector

__all__ = [
    "BEGINS",
    "CONVERGED",
    "ENDS",
    "LENGTH",
    "NEWTON_STEPS",
    "STALLED",
    "branch_point_indicator",
    "doubling_indicator",
    "impact_that_may_stick",
    "indicators_of",
    "interpolated",
    "least_of_margins",
    "margin_values",
    "neimark_sacker_indicator",
    "null_vector",
    "scales_of",
    "step_in_plane",
    "tangent_of",
]
