"""What the other rooms know of ROS 2: topics, messages, addresses, and a node by rclpy."""
