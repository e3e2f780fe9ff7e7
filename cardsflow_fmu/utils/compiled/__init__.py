"""C library of this package for runs: the loop of a co-simulation."""
