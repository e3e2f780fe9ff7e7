"""SDF for Gazebo, and the muscles in its plug-in's file."""
