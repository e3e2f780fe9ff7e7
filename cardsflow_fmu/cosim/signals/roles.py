"""Names of the participants of a run."""

ROLES = ("plant", "controller", "reference")
SENSORS, ESTIMATOR = "sensors", "estimator"
"""Participants of runs with an estimator: simulated sensors and the estimator."""
HARDWARE = "hardware"
"""Role of the FMU that replaces the plant to drive hardware."""
