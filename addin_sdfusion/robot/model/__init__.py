"""The robot description: links, joints, muscles, trajectories."""
