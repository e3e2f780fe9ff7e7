"""Calibration of a robot from recordings of its own motion."""
