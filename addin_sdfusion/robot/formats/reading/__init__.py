"""What readers of several formats share. Not in Fusion: lxml."""
