"""ROS 2: live topics of runs and devices, and recordings that other tools can open."""
