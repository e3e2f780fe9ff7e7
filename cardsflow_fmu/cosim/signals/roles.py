"""Names of the participants of a run."""

ROLES = ("plant", "controller", "reference")
SENSORS, ESTIMATOR = "sensors", "estimator"
"""Participants of runs with an estimator: simulated sensors, and what makes a state of these."""
HARDWARE = "hardware"
"""The FMU that takes the plant's place when hardware is driven."""
