"""Models in C: their library, files and variables."""
