"""File formats of robots: one package per format, with its reader and its writer."""
