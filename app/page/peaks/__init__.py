"""View Peaks and spectra, of the tab Your code."""
