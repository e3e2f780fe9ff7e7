"""ROS 2 without a ROS installation: message types, their bytes, and nodes over zenoh and DDS."""
