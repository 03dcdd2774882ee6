"""Time stepping, step by step: Newmark's method, plain and with located contact changes."""
