"""Obstacles of motions: distances, constraints, and motions around obstacles."""
