"""Jitted code only: floats, arrays, and one NamedTuple of numbers for each method."""
