"""View Diagram and branches, of the tab Bifurcation."""
