"""The SDF format of Gazebo, with the CARDSFlow plugin."""
