"""The replay page that opens from disk."""
