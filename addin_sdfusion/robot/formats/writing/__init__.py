"""What writers of several formats share. Standard library only."""
