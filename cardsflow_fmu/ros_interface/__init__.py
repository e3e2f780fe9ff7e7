"""Interface to ROS 2: topics, messages, addresses, and nodes that use rclpy."""
