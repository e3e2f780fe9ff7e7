"""Calibration of a robot from recordings of its motion."""
