"""Between the public objects and the kernels: pack the numbers, call in bounded pieces, collect what is recorded."""
