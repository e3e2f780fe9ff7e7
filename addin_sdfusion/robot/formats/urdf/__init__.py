"""The URDF format of ROS."""
