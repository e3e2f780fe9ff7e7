"""Names of the participants of a run."""

ROLES = ("plant", "controller", "reference")
HARDWARE = "hardware"
"""The FMU that takes the plant's place when hardware is driven."""
