"""Emulated hardware: plant, sensors, motors and link faults."""
