"""Recommendation of K, D and the time step: settings that meet a tolerance at least cost."""
