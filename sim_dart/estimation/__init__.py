"""Estimation of the state of a robot from measurements of its muscles."""
