"""Live view in a browser."""
