"""SDF of Gazebo, with our plugin."""
