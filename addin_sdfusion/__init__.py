"""SDFusion: the Fusion 360 add-in, and the description of a robot that all else builds on."""
