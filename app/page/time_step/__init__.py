"""View Time step, of the tab Step and cost."""
