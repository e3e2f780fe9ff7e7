"""Check command: all findings on the design at once."""
