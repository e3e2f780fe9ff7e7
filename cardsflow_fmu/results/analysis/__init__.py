"""Analyses without a run: sizing, motion check, information."""
