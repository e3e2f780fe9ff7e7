"""From the snapshot of a design to a robot, step by step; `build_robot` takes them."""
