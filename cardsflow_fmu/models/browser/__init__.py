"""Simulation in a browser: everything that a page needs of an experiment."""
