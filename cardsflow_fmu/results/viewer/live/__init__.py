"""Server of pages on loopback, and frames of a run in progress."""
