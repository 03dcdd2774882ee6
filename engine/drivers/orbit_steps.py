"""Newton's method to an orbit, tangents and indicators (:mod:`..kernels.event_driven.orbit_steps`)."""

from ..kernels.event_driven.orbit_steps import (
    BEGINS,
    ENDS,
    LENGTH,
    branch_point_indicator,
    doubling_indicator,
    impact_that_may_stick,
    indicators_of,
    interpolated,
    margin_values,
    neimark_sacker_indicator,
    scales_of,
    step_at_value,
    step_in_plane,
    tangent_of,
)
from ..kernels.linear.small_systems import null_vector

__all__ = [
    "BEGINS",
    "ENDS",
    "LENGTH",
    "branch_point_indicator",
    "doubling_indicator",
    "impact_that_may_stick",
    "indicators_of",
    "interpolated",
    "margin_values",
    "neimark_sacker_indicator",
    "null_vector",
    "scales_of",
    "step_at_value",
    "step_in_plane",
    "tangent_of",
]
