"""View Speed against error, of the tab Step and cost."""
