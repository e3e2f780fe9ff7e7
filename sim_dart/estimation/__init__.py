"""Estimation of a robot's state from its muscles."""
