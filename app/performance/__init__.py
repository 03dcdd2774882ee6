"""Speed against error of the solvers, and their peers."""
