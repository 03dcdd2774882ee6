"""Many cells in one call."""
