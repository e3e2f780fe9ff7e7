"""Messages of ROS 2: types, their bytes, and recordings that other tools open."""
