"""Tab Explore: both solutions laid over each other, and what their difference means."""
