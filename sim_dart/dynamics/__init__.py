"""Robot dynamics for controllers."""
