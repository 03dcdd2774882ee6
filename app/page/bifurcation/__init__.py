"""Tab Bifurcation."""
