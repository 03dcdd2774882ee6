"""Data files: scenes, shipped diagrams, 60-digit solutions, figures."""
