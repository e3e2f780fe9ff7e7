"""OpenSim's .osim files."""
