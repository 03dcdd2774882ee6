"""Hard cases, with what can be expected of each."""
