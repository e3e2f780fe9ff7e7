"""The runtime of FMUs: the C library, and the Python end that it calls."""
