"""Settings of optimal motions."""
