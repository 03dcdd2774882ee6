"""View Basins and coexisting motions, of the tab Bifurcation."""
