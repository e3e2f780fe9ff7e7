"""Nodes of ROS 2 without a ROS installation."""
