"""Tab One impact."""
