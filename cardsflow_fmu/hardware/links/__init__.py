"""Links to hardware: UDP, serial lines and ROS 2 topics."""
