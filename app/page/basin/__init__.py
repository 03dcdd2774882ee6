"""Tab Basins."""
