"""Cost and error of the solvers beside those of other solvers."""
