"""Conversion of a design snapshot to a robot; see `build_robot`."""
