"""One impact: what a contact alone gives with a law, an integrator, a contact status and a step, and what to choose."""
