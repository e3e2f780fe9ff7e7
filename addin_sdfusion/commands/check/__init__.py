"""Check command, which lists all findings on the design."""
