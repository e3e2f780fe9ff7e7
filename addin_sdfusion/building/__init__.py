"""Building of a robot from the snapshot of a design, step by step; see `build_robot`."""
