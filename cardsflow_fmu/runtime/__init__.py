"""Runtime of FMUs: the C library and its Python part."""
