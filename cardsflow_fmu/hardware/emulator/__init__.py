"""Emulated hardware: plant, sensors, drives, faults of a link."""
