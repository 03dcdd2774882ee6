"""Measured data: read, aligned by phase, compared, fitted."""
