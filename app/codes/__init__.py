"""Simulation codes: what they do by default, and rules of thumb for K, D and the step. No panel import."""
