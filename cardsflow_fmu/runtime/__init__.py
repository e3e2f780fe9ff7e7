"""What makes a Python model an FMU: the C library, and the Python end that it calls."""
