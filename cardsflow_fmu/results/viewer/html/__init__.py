"""Self-contained HTML page of a replay."""
