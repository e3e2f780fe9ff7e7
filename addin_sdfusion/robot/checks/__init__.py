"""The single checks of a robot, by what they look at; `check.py` lists them."""
