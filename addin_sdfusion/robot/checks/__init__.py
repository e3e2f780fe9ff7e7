"""Single checks of a robot, by subject; `check.py` lists them."""
