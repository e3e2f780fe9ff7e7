"""The MJCF format of MuJoCo."""
