"""Tab Speed."""
