"""The kinematic tree of the links, and their frames."""
