"""The scene of a run: shapes, poses, muscle paths, motion."""
