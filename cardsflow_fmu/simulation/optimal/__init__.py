"""Optimal motions of experiments."""
