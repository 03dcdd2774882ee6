"""Hard cases: runs that a solver of impacts can get wrong, and how this engine does in them."""
