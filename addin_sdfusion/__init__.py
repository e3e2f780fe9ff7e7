"""SDFusion: the Fusion add-in, and the robot description that all other packages use."""
