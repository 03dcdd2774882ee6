"""Sliders, typed values, switches and scene buttons."""
