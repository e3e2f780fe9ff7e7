"""ROS's URDF."""
