"""Which K, D and step to set instead."""
