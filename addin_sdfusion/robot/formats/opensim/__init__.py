"""The .osim format of OpenSim."""
