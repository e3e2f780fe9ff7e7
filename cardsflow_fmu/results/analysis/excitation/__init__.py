"""Motions that identify a robot's numbers."""
