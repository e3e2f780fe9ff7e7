"""Kinematic tree of the links and their frames."""
