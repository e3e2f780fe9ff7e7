"""Transformations of robots: simplification, combination, locking and repair."""
