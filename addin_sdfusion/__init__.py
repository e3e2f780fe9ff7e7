"""SDFusion: the Fusion add-in, and the robot description that all else builds on."""
