"""How kernels are compiled, cached, and given their arguments in packed arrays."""
