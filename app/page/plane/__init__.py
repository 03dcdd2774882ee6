"""Tab K–D plane."""
