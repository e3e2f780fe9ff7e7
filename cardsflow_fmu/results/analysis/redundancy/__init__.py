"""Muscle redundancy: forces and activations of muscles along a given motion."""
