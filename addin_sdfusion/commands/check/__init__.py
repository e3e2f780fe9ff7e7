"""Check: all that is wrong with the design, at once."""
