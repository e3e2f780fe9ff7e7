"""The C core: its library, the robot's blob, frames."""
