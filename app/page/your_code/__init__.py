"""Tab Your code."""
