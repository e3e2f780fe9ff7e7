"""Checks of a robot, grouped by subject; `check.py` lists them."""
