"""Tab Paper."""
