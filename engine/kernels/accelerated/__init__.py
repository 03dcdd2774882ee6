"""The same discrete solutions without walking through every step."""
