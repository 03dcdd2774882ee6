"""Tab Help."""
