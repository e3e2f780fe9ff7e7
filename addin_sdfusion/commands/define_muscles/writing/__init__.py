"""Writing of the muscle table into a design."""
