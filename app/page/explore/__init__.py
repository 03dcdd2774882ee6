"""Tab Explore: both solutions drawn over each other, and what their difference means."""
