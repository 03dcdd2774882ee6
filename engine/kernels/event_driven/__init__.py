"""Closed-form phases joined by events: the reference and the exact penalty solution."""
