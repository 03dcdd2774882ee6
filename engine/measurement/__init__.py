"""Measured motion beside the solutions, and constants of the system fitted to it."""
